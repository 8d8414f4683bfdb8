"""Recordings from files: a path, a glob pattern, a declared layout."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from physident.errors import InputError
from physident.recordings.formats.read import read_table
from physident.recordings.layout import ColumnLayout
from physident.recordings.recording import Recording
from physident.recordings.rows import recording_from_rows


def load_recordings(
    paths: str | Path | Iterable[str | Path],
    columns: str | ColumnLayout | None = None,
    drive_gains: Sequence[float] | None = None,
) -> list[Recording]:
    """Recordings from files or glob patterns, in sorted order for a pattern.

    ``columns`` declares the layout of files without the canonical header, as in
    ``"time=0,q=1:7,dq=7:13,current=13:19"`` (zero-based, half-open). ``drive_gains`` (n,) [N m/A] turn currents into
    joint torques. Raises InputError, naming the file, for a file that is not a recording.
    """
    patterns = [paths] if isinstance(paths, str | Path) else list(paths)
    return [load_recording(file, columns, drive_gains) for file in find_recordings(patterns)]


def find_recordings(patterns: Iterable[str | Path]) -> list[str]:
    """The files of paths and glob patterns, each once; raises InputError for one that matches nothing."""
    files: list[str] = []
    for pattern in map(str, patterns):
        found = [pattern] if os.path.exists(pattern) else sorted(filter(os.path.exists, glob.glob(pattern)))
        if not found:
            raise InputError(f"recording {pattern!r} not found: expected a file or a pattern that matches some")
        files += found
    return list(dict.fromkeys(files))


def load_recording(
    path: str | Path, columns: str | ColumnLayout | None = None, drive_gains: Sequence[float] | None = None
) -> Recording:
    """One recording from a .csv, .csv.gz or .npz file; arguments and errors as in ``load_recordings``."""
    layout = ColumnLayout.parse(columns) if isinstance(columns, str) else columns
    table = read_table(Path(path))
    layout = layout or ColumnLayout.from_header(table.names, str(path))
    layout.check_width(table.values.shape[1], str(path))
    recording = recording_from_rows(layout.split(table.values), str(path), table.rows, table.rejected)
    recording = replace(recording, ignored=layout.unused(table.names))
    if drive_gains is None:
        return recording
    with_gains = recording.with_drive_gains(drive_gains)  # first, because it checks the gains
    if recording.effort_kind == "torque":
        raise InputError(
            f"{path}: contains torques, but drive gains are given; name its effort 'current', or leave out the gains"
        )
    return with_gains
