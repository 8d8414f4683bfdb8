"""The typer application, and what several verbs do: reading, checking, saying how far they are."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import typer

from physident.cli.options import parse_numbers
from physident.errors import InputError, warn

if TYPE_CHECKING:
    from physident.recordings.recording import Recording

app = typer.Typer(
    name="physident",
    help="Identify the dynamics of robot arms from recordings, and find what their simulation gets wrong.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

T = TypeVar("T")


def read_recordings(paths: list[str], columns: str | None, gains: str | None, quiet: bool = False) -> list[Recording]:
    """Recordings of the given paths and patterns, with a progress bar; unless quiet, says what was left out of each."""
    from physident.recordings.layout import ColumnLayout
    from physident.recordings.load import find_recordings, load_recording

    layout = ColumnLayout.parse(columns) if columns is not None else None
    numbers = parse_numbers(gains, "--drive-gains") if gains is not None else None
    files = find_recordings(paths)
    recordings = [load_recording(file, layout, numbers) for file in progress(files, "reading")]
    for recording in () if quiet else recordings:
        report(recording)
    return recordings


def check_outputs(inputs: Iterable[str | Path | None], *outputs: Path | None, plot: Path | None = None) -> None:
    """Before any work: raises InputError for an output that cannot be written, or that would replace an input.

    ``inputs`` are files, patterns, or names of no file; None is skipped in both.
    """
    from physident.files import check_target
    from physident.view.style import FORMATS

    if plot is not None and plot.suffix.lower() not in FORMATS:
        raise InputError(f"plot {str(plot)!r} has no known ending, expected one of {', '.join(FORMATS)}")
    asked = [path for path in (*outputs, plot) if path is not None]
    for output in asked:
        check_target(output)
    read = [file for source in inputs if source for file in glob.glob(str(source)) or [str(source)]]
    places = [os.path.realpath(path) for path in asked]
    if replaced := [path for path in read if os.path.exists(path) and os.path.realpath(path) in places]:
        raise InputError(f"output {replaced[0]!r} is also read by this command; expected another path to write to")
    if len(set(places)) < len(places):
        raise InputError(f"output {str(asked[-1])!r} is given twice; expected another path for each result")


def report(recording: Recording) -> None:
    """Warn of what of a recording was left out: rows by number, columns by name."""
    if recording.rejected:
        bad = recording.rejected
        shown = "; ".join(f"row {b.row}: {b.reason}" for b in bad[:3])
        more = f"; and {len(bad) - 3} more (physident inspect names all)" if len(bad) > 3 else ""
        warn(f"{recording.source}: {len(bad)} bad rows left out ({shown}{more})")
    if recording.ignored:
        warn(f"{recording.source}: columns ignored: {_listed(recording.ignored)}")


def progress(items: Iterable[T], doing: str) -> Iterator[T]:
    """The items, with a progress bar on standard error once they have taken more than two seconds."""
    import time

    listed = list(items)
    bar = None
    start = time.monotonic()
    try:
        for index, item in enumerate(listed):
            if bar is None and time.monotonic() - start > 2:
                from rich.console import Console
                from rich.progress import Progress

                bar = Progress(console=Console(stderr=True), transient=True)
                bar.start()
                bar.add_task(doing, total=len(listed))
            if bar is not None:
                bar.update(bar.task_ids[0], completed=index)
            yield item
    finally:
        if bar is not None:
            bar.stop()


@contextmanager
def busy(doing: str) -> Iterator[None]:
    """A clock on standard error for work whose steps cannot be counted, once it has taken more than two seconds."""
    import threading

    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn(doing), TimeElapsedColumn())
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    bar.add_task(doing, total=None)
    timer = threading.Timer(2, bar.start)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        if bar.live.is_started:  # stopping a bar that never ran would print an empty line
            bar.stop()


def _listed(names: tuple[str, ...]) -> str:
    """Column names in one line: numbered ones as a range, as in target_torque_1..6."""
    groups: dict[str, list[str]] = {}
    for name in names:
        stem, _, number = name.rpartition("_")
        groups.setdefault(stem if number.isdigit() else name, []).append(name)
    texts = [f"{g[0]}..{g[-1].rpartition('_')[2]}" if len(g) > 1 else g[0] for g in groups.values()]
    return ", ".join(texts[:8]) + (f" and {len(texts) - 8} more" if len(texts) > 8 else "")
