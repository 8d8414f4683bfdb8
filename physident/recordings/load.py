"""Recordings from files: a path, a glob pattern, a declared layout."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from physident.errors import InputError, PhysidentError
from physident.recordings.channels import printable
from physident.recordings.columns.layout import ColumnLayout
from physident.recordings.columns.reading import Reading
from physident.recordings.formats.read import is_there, parts_of, read_table
from physident.recordings.recording import Recording
from physident.robots.robot import Robot

Recordings = Recording | str | Path | Iterable["Recordings"]
"""What functions take as recordings: one or several, each a recording, a path or a pattern."""


def load_recordings(
    paths: str | Path | Iterable[str | Path],
    columns: str | ColumnLayout | None = None,
    drive_gains: Sequence[float] | None = None,
    *,
    topic: str | None = None,
    rate: float | None = None,
    joints: Sequence[str] | None = None,
) -> list[Recording]:
    """Recordings from files or glob patterns, in sorted order for a pattern.

    ``columns`` declares the layout of files without the canonical header, as in
    ``"time=0,q=1:7,dq=7:13,current=13:19"`` (zero-based, half-open) or, by names, ``"time=t,q=position,tau=torque"``.
    ``drive_gains`` (n,) [N m/A] turn currents into joint torques. ``topic`` is that of a ROS bag, ``rate`` [Hz] that of
    rows without a clock, ``joints`` the wanted joints of a file that names them (``robot.joint_names``). Each episode of a
    LeRobot data set, and each recording in a session, is one recording. Raises InputError, naming the file, for a file
    that is not a recording.
    """
    patterns = [paths] if isinstance(paths, str | Path) else list(paths)
    reading = _reading(columns, topic, rate, joints)
    return [_load(file, reading, drive_gains) for file in find_recordings(patterns)]


def find_recordings(patterns: Iterable[str | Path]) -> list[str]:
    """The files of paths and glob patterns, each once, and each part of a file that contains several recordings, PATH#K;
    raises InputError for one that matches nothing."""
    files: list[str] = []
    for pattern in map(str, patterns):
        try:
            found = [pattern] if is_there(pattern) else sorted(filter(os.path.exists, glob.glob(pattern)))
        except ValueError:
            found = []
        if not found:
            raise InputError(
                f"recording {printable(pattern)!r} not found: expected a file or a pattern that matches some"
            )
        files += [part for file in found for part in parts_of(file)]
    return list(dict.fromkeys(files))


def load_recording(
    path: str | Path,
    columns: str | ColumnLayout | None = None,
    drive_gains: Sequence[float] | None = None,
    *,
    topic: str | None = None,
    rate: float | None = None,
    joints: Sequence[str] | None = None,
) -> Recording:
    """One recording from a file or folder, or a part of it, PATH#K; arguments and errors as in ``load_recordings``."""
    return _load(path, _reading(columns, topic, rate, joints), drive_gains)


def if_at_hand(
    path: str, sha256: str, columns: str | ColumnLayout | None, joints: Sequence[str] | None
) -> Recording | None:
    """A recording that was used before, with the wanted ``joints``; None where it is gone, cannot be read any more, or has changed since
    it had the hash ``sha256``."""
    try:
        recording = load_recording(path, columns, joints=joints)
    except PhysidentError:
        return None
    return recording if recording.sha256 == sha256 else None


def as_recordings(given: Recordings, robot: Robot | None, columns: str | ColumnLayout | None = None) -> list[Recording]:
    """Recordings from what a function was given: one or several recordings, paths or patterns.

    Files are read with ``columns``; recordings whose joints have names get the robot's joints in the robot's order, if there is one. Raises
    InputError for anything else, and for recordings that lack one of the robot's joints.
    """
    names = None if robot is None else robot.joint_names
    if isinstance(given, str | Path):
        return load_recordings(given, columns, joints=names)
    if isinstance(given, Recording):
        return [given if names is None else given.in_order_of(names)]
    try:
        listed = list(given)
    except TypeError:
        raise InputError(
            f"recordings are {type(given).__name__}, expected recordings or paths, one or several"
        ) from None
    if wrong := [one for one in listed if not isinstance(one, Recording | str | Path | list | tuple)]:
        raise InputError(
            f"recordings contain {type(wrong[0]).__name__}, expected recordings or paths; arrays go through"
            " Recording.from_arrays or Recording.from_frame"
        )
    return [recording for one in listed for recording in as_recordings(one, robot, columns)]


def _reading(
    columns: str | ColumnLayout | None, topic: str | None, rate: float | None, joints: Sequence[str] | None
) -> Reading:
    reading = Reading.parse(columns) if isinstance(columns, str) else Reading(columns=columns)
    given = {"topic": topic, "rate": rate, "joints": None if joints is None else tuple(joints)}
    return replace(reading, **{name: value for name, value in given.items() if value is not None})


def _load(path: str | Path, reading: Reading, drive_gains: Sequence[float] | None) -> Recording:
    table = read_table(path, reading)
    recording = replace(Recording.from_table(table, reading, printable(path)), layout=reading.text)
    return recording if drive_gains is None else recording.gained(drive_gains)
