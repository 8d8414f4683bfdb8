"""Options that several commands have, and how their values are read."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from physident.errors import InputError, warn

if TYPE_CHECKING:
    from physident.recordings.signals import Filter
    from physident.robots.robot import Robot

Recordings = Annotated[
    list[str],
    typer.Argument(
        metavar="RECORDING...",
        help="Recordings (.csv, .csv.gz, .txt, .npz, .parquet, .mat, .rrd; ROS 2 bags .db3, .mcap or their folder; LeRobot"
        " data sets), or patterns such as runs/*.csv.",
    ),
]
RobotOption = Annotated[
    str | None,
    typer.Option(
        "--robot",
        metavar="NAME|FILE",
        help="A built-in robot (ur5, ur10e), a URDF, xacro or MuJoCo file, or a DH table (.toml).",
    ),
]
JointsOption = Annotated[
    str | None,
    typer.Option(
        "--joints",
        metavar="NAMES",
        help="With --robot: the arm's joints from base to tip, by names or patterns: panda_joint1,panda_joint2 or 'panda_joint*'.",
    ),
]
LockOption = Annotated[
    list[str] | None,
    typer.Option(
        "--lock",
        metavar="NAME=VALUE",
        help="With --robot: a joint that does not move and its position [rad|m], as finger_joint1=0.02; repeat for several.",
    ),
]
ToolOption = Annotated[
    str | None, typer.Option("--tool", metavar="LINK", help="With --robot: the link that is the tool frame.")
]
GearRatiosOption = Annotated[
    str | None,
    typer.Option(
        "--gear-ratios",
        metavar="RATIOS",
        help='With --robot: turns of each motor for one turn of its joint, one number for each joint: "101 101 ...". Ripple of the motors is'
        " then found, too.",
    ),
]
ColumnsOption = Annotated[
    str | None,
    typer.Option(
        "--columns",
        metavar="LAYOUT",
        help="Columns of files without a header, counted from 0: time=0,q=1:7,dq=7:13,current=13:19; or their names:"
        " time=t,q=position,tau=torque.",
    ),
]
TopicOption = Annotated[
    str | None,
    typer.Option("--topic", metavar="TOPIC", help="Topic of a ROS 2 bag (sensor_msgs/JointState), if it has several."),
]
RateOption = Annotated[
    float | None, typer.Option("--rate", metavar="HZ", help="Rate of the rows of files without a clock [Hz].")
]
GainsOption = Annotated[
    str | None,
    typer.Option(
        "--drive-gains",
        metavar="GAINS",
        help='Joint torque per motor current [N m/A], one number for each joint: "10.7 10.7 ...".',
    ),
]


def _checked_cutoff(cutoff: float | None) -> float | None:
    if cutoff is not None:
        from physident.recordings.signals import Filter

        Filter(cutoff)
    return cutoff


CutoffOption = Annotated[
    float | None,
    typer.Option(
        "--cutoff",
        metavar="HZ",
        callback=_checked_cutoff,
        help="Cutoff of the low-pass for torque and model [Hz].",
    ),
]
ModelOption = Annotated[Path, typer.Option("--model", metavar="FILE", help="A model that identify wrote.")]
JsonOption = Annotated[
    Path | None, typer.Option("--json", metavar="FILE", help="Also write the result as JSON to this file.")
]


def plot_option(what: str) -> Any:
    """The option --plot of a verb that also draws something."""
    return typer.Option("--plot", metavar="FIGURE", help=f"Also draw {what} (.png, .pdf, .svg).")


def _checked_meshes(folder: Path | None) -> Path | None:
    if folder is not None and not folder.is_dir():
        raise InputError(
            f"--meshes {str(folder)!r} is no folder; expected the folder that package:// in the URDF stands for"
        )
    return folder


MeshesOption = Annotated[
    Path | None,
    typer.Option(
        "--meshes", metavar="FOLDER", callback=_checked_meshes, help="Folder of the robot's mesh packages (package://)."
    ),
]
IncludeFittedOption = Annotated[
    bool, typer.Option("--include-fitted", help="Allow recordings that the model was fitted to.")
]


def robot_of(
    option: str | None,
    joints: str | None = None,
    lock: Sequence[str] | None = None,
    tool: str | None = None,
    gear_ratios: str | None = None,
) -> Robot:
    """The robot of --robot, with --joints, --lock, --tool and --gear-ratios; raises InputError without --robot.

    Warns of the joints that were locked.
    """
    robot = optional_robot(option, joints, lock, tool, gear_ratios)
    if robot is None:
        raise InputError(
            "no robot given, expected --robot with a built-in name (ur5, ur10e), a .urdf, a MuJoCo .xml or a .toml"
        )
    return robot


def optional_robot(
    option: str | None,
    joints: str | None = None,
    lock: Sequence[str] | None = None,
    tool: str | None = None,
    gear_ratios: str | None = None,
) -> Robot | None:
    """The robot of --robot, None without it; raises InputError for an option of it without --robot."""
    from physident.robots.load import load_robot, parse_locks

    given = {"--joints": joints, "--lock": lock, "--tool": tool, "--gear-ratios": gear_ratios}
    if option is None:
        if lonely := [name for name, value in given.items() if value]:
            raise InputError(
                f"{lonely[0]} was given without --robot, expected both: a model has its joints and gears; identify it again to change them"
            )
        return None
    robot = load_robot(
        option,
        joints=joints,
        lock=parse_locks(lock) if lock else None,
        tool=tool,
        gear_ratios=None if gear_ratios is None else parse_numbers(gear_ratios, "--gear-ratios"),
    )
    if robot.locked and (joints is not None or lock):
        warn(f"{robot.source}: locked: {robot.locked_text()}")
    return robot


def filter_of(cutoff: float | None) -> Filter:
    """The filter with the cutoff [Hz] of --cutoff, or the default filter."""
    from physident.recordings.signals import Filter

    return Filter() if cutoff is None else Filter(cutoff)


def layout_of(columns: str | None, topic: str | None, rate: float | None, remembered: str | None = None) -> str | None:
    """One text of --columns, --topic and --rate; options that are not given are those that a model remembers."""
    from physident.recordings.columns.reading import reading_text

    return reading_text(columns, topic, rate, remembered)


def names_of(text: str) -> list[str]:
    """Names separated by commas."""
    return [name.strip() for name in text.split(",") if name.strip()]


def effects_of(option: str | None) -> Sequence[str]:
    """The effects of --effects, or the default effects."""
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
