"""Options that several verbs share, and what their texts mean."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from physident.errors import InputError

if TYPE_CHECKING:
    from physident.recordings.signals import Filter
    from physident.robots.robot import Robot

Recordings = Annotated[
    list[str], typer.Argument(metavar="REC...", help="Recordings: .csv, .csv.gz, .npz, or patterns.")
]
RobotOption = Annotated[str | None, typer.Option("--robot", help="Built-in name (ur5), .urdf file or DH table .toml.")]
ColumnsOption = Annotated[
    str | None,
    typer.Option("--columns", help="Layout without canonical header: time=0,q=1:7,dq=7:13,current=13:19 (zero-based)."),
]
GainsOption = Annotated[
    str | None,
    typer.Option("--drive-gains", help='Motor current to joint torque [N m/A], one a joint: "10.7 10.7 ...".'),
]


def _checked_cutoff(cutoff: float | None) -> float | None:
    if cutoff is not None:
        from physident.recordings.signals import Filter

        Filter(cutoff)
    return cutoff


CutoffOption = Annotated[
    float | None,
    typer.Option("--cutoff", callback=_checked_cutoff, help="Cutoff of the low-pass on both sides [Hz]."),
]
ModelOption = Annotated[Path, typer.Option("--model", help="A model file that identify wrote.")]
JsonOption = Annotated[Path | None, typer.Option("--json", help="Also write the result as JSON to this file.")]
IncludeFittedOption = Annotated[
    bool, typer.Option("--include-fitted", help="Allow recordings the model was fitted to.")
]


def robot_of(option: str | None) -> Robot:
    """The robot of --robot; raises InputError where none was given."""
    from physident.robots.load import load_robot

    if option is None:
        raise InputError("no robot given, expected --robot with a built-in name (ur5), a .urdf or a DH table .toml")
    return load_robot(option)


def filter_of(cutoff: float | None) -> Filter:
    """The filter with the cutoff of --cutoff [Hz], the usual one without it."""
    from physident.recordings.signals import Filter

    return Filter() if cutoff is None else Filter(cutoff)


def names_of(text: str) -> list[str]:
    """Names separated by commas."""
    return [name.strip() for name in text.split(",") if name.strip()]


def effects_of(option: str | None) -> Sequence[str]:
    """The effects of --effects, the default ones without it."""
    from physident.effects.catalogue import DEFAULT_EFFECTS

    return DEFAULT_EFFECTS if option is None else names_of(option)


def parse_numbers(text: str, option: str) -> tuple[float, ...]:
    """Numbers separated by commas or spaces; raises InputError naming the option."""
    try:
        numbers = tuple(float(part) for part in re.split(r"[,\s]+", text.strip()) if part)
    except ValueError:
        numbers = ()
    if not numbers or not all(map(math.isfinite, numbers)):
        raise InputError(f"{option} is {text!r}, expected finite numbers separated by commas or spaces")
    return numbers
