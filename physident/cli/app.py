"""The typer application, and what several commands share: reading recordings, checking outputs, showing progress."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from physident.cli.options import parse_numbers
from physident.cli.progress import busy, progress, share_done
from physident.cli.replacement import check_replacement
from physident.cli.verb import Application
from physident.errors import InputError, warn
from physident.files import VERSION

if TYPE_CHECKING:
    from physident.recordings.recording import Recording

__all__ = ["app", "busy", "check_outputs", "progress", "read_recordings", "share_done", "write_result"]  # for the verbs
COMMANDS = {  # by folder, in the order of --help
    "recordings": ("demo", "inspect", "design", "simulate"),
    "models": ("identify", "validate", "compare", "payload", "drive-gains", "base-parameters", "export", "replay"),
    "diagnosis": ("diagnose", "plan", "resume", "report", "view"),
    "fleet": ("fleet", "drift"),
}


class GroupedCommands(TyperGroup):
    """Lists the commands of ``physident --help`` under the headings of ``COMMANDS``."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        for heading, names in COMMANDS.items():
            commands = {name: self.get_command(ctx, name) for name in names}
            rows = [(name, command.get_short_help_str()) for name, command in commands.items() if command is not None]
            with formatter.section(heading.capitalize()):
                formatter.write_dl(rows)


app = Application(
    name="physident",
    cls=GroupedCommands,
    help="Identify the dynamics of robot arms from recordings, and find what their simulation gets wrong.",
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _print_version(asked: bool) -> None:
    if asked:
        typer.echo(f"physident {VERSION}")
        raise typer.Exit


@app.callback()
def start(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Identify the dynamics of robot arms from recordings, and find what their simulation gets wrong."""


def read_recordings(
    paths: list[str],
    layout: str | None,
    gains: str | None,
    quiet: bool = False,
    joints: Sequence[str] | None = None,
) -> list[Recording]:
    """The recordings of paths and patterns, with a progress bar; unless ``quiet``, warns of rows and columns left out.

    ``layout`` is the text of ``layout_of``; ``joints`` are those of the robot, for files that name their joints.
    """
    from physident.recordings.load import find_recordings, load_recording

    numbers = parse_numbers(gains, "--drive-gains") if gains is not None else None
    files = find_recordings(paths)
    recordings = [load_recording(file, layout, numbers, joints=joints) for file in progress(files, "reading")]
    for recording in () if quiet else recordings:
        warn_of_rejected(recording)
    return recordings


def check_outputs(
    inputs: Iterable[str | Path | None],
    *outputs: Path | None,
    plot: Path | None = None,
    edited: Path | None = None,
) -> None:
    """Raises InputError for an output that cannot be written, or that would replace an input or a file of another program
    (without --force); called before any work.

    ``inputs`` are files, patterns, or names that are no files, such as that of a built-in robot. ``edited`` is a file that
    the user wants to be changed where it is. None is skipped.
    """
    from physident.graphics.style import FORMATS
    from physident.outputs import check_target, is_standard_output

    if plot is not None and plot.suffix.lower() not in FORMATS:
        raise InputError(f"plot {str(plot)!r} has no known ending, expected one of {', '.join(FORMATS)}")
    given = [path for path in (*outputs, plot, edited) if path is not None]
    for output in given:
        check_target(output)
    read = [file for source in inputs if source for file in glob.glob(str(source)) or [str(source)]]
    places = ["-" if is_standard_output(path) else os.path.realpath(path) for path in given]
    if replaced := [path for path in read if os.path.exists(path) and os.path.realpath(path) in places]:
        raise InputError(f"output {replaced[0]!r} is also read by this command; expected another path to write to")
    if len(set(places)) < len(places):
        raise InputError(f"output {str(given[-1])!r} is given twice; expected another path for each result")
    for output in given:
        if output != edited:
            check_replacement(output)


def warn_of_rejected(recording: Recording) -> None:
    """Warn of the rows and columns of a recording that were left out."""
    if recording.rejected:
        bad = recording.rejected
        shown = "; ".join(f"row {b.row}: {b.reason}" for b in bad[:3])
        more = f"; and {len(bad) - 3} more (physident inspect lists all)" if len(bad) > 3 else ""
        warn(f"{recording.source}: {len(bad)} bad rows left out ({shown}{more})")
    if recording.ignored:
        warn(f"{recording.source}: columns ignored: {_listed(recording.ignored)}")


def write_result(path: Path | None, kind: str, data: dict[str, Any]) -> None:
    """Write a verb's result as JSON of schema physident.<kind>/1, where --json was given."""
    from physident.files import write_json

    if path is not None:
        write_json(path, {"schema": f"physident.{kind}/1", **data})


def _listed(names: tuple[str, ...]) -> str:
    """Column names in one line, numbered ones as a range: target_torque_1..6."""
    groups: dict[str, list[str]] = {}
    for name in names:
        stem, _, number = name.rpartition("_")
        groups.setdefault(stem if number.isdigit() else name, []).append(name)
    texts = [f"{g[0]}..{g[-1].rpartition('_')[2]}" if len(g) > 1 else g[0] for g in groups.values()]
    return ", ".join(texts[:8]) + (f" and {len(texts) - 8} more" if len(texts) > 8 else "")
