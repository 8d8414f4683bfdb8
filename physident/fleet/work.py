"""The work on one file, which a worker does: a recording in, a few rows of numbers out. Samples never travel."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import date
from typing import Any

from physident.errors import InputError, PhysidentError
from physident.estimation.estimate import Estimate
from physident.estimation.estimate_file import load_estimate
from physident.estimation.identify import prepare_all
from physident.fleet.candidates import words_of
from physident.fleet.changes import Change, changes_in
from physident.fleet.friction_laws import identify_with_friction_laws
from physident.processes import VARIABLE
from physident.recordings.load import load_recording
from physident.recordings.recording import Recording
from physident.recordings.signals import as_filter
from physident.robots.robot import Robot

LEVEL = 0.05 / 30  # of a finding: five per cent, shared by the parameters of an arm


@dataclass(frozen=True, kw_only=True)
class Reading:
    """How the files of a fleet are read: columns, gains [N m/A] and the cutoff [Hz] of the filter."""

    columns: str | None = None
    drive_gains: tuple[float, ...] | None = None
    cutoff: float | None = None


@dataclass(frozen=True, kw_only=True)
class Task:
    """A file of an arm and a day, with its hash; ``baseline`` is the path of the arm's model file, ``reason`` why there is none."""

    file: str
    digest: str
    arm: str
    day: date
    baseline: str
    reason: str = ""


def read(file: str, robot: Robot, reading: Reading) -> Recording:
    """The recording of a file; raises InputError as ``load_recording`` does."""
    return load_recording(file, reading.columns, reading.drive_gains, joints=robot.joint_names)


def make_baseline(robot: Robot, files: list[str], wanted: int, reading: Reading) -> Estimate | str:
    """The model of an arm from its first ``wanted`` files that can be used, or why there is none."""
    recordings, reason = [], "no files"
    for file in files:
        try:
            with _quiet():
                recording = read(file, robot, reading)
                prepare_all(robot, [recording], as_filter(reading.cutoff))  # a pose at rest is no baseline
            recordings.append(recording)
        except PhysidentError as error:
            reason = str(error)
        if len(recordings) == wanted:
            break
    if not recordings:
        return f"the arm has no baseline: {reason}"
    with _quiet():
        try:
            return identify_with_friction_laws(robot, recordings, reading.cutoff)
        except PhysidentError as error:
            return f"the arm has no baseline: {error}"


def rows_of_file(task: Task, robot: Robot, reading: Reading) -> list[dict[str, Any]]:
    """A row for each parameter, or one with the reason why the file cannot be used: a broken file never stops a fleet."""
    common = {"arm": task.arm, "day": task.day, "file": task.file, "hash": task.digest}
    with _quiet():
        try:
            if not os.path.exists(task.baseline):
                raise InputError(task.reason or f"the arm's baseline {task.baseline} cannot be found by this worker")
            baseline = load_estimate(task.baseline)
            recording = read(task.file, robot, reading)
            converted = recording.with_default_drive_gains(baseline.drive_gains)
            changes = changes_in(baseline, converted)
        except PhysidentError as error:
            return [{**common, "error": str(error)}]
        except Exception as error:  # one file in thousands must not cost the others; the row says what to report
            return [{**common, "error": f"{type(error).__name__}: {str(error)[:200]}; this is a mistake of physident"}]
    return [{**common, **_row(change, converted)} for change in changes]


def _row(change: Change, recording: Recording) -> dict[str, Any]:
    j = change.candidate.joint - 1
    temperature = float("nan")
    if recording.temperature is not None:
        temperature = float(recording.temperature[:, j].mean())
    return {
        "parameter": change.parameter, "effect": change.candidate.effect, "joint": change.candidate.joint,
        "unit": change.unit, "value": change.value, "change": change.change, "std": change.std, "low": change.low,
        "high": change.high, "baseline": change.baseline, "information": change.information,
        "blocks": float(change.blocks), "temperature": temperature,
        "coupling": list(change.coupling), "load": change.load, "seconds": recording.duration,
        "start": float(recording.time[0]),
        "finding": _finding(change),
    }  # fmt: skip


def _finding(change: Change) -> str | None:
    """A sentence where the recording alone shows that the parameter differs from the baseline's."""
    from scipy.stats import t

    limit = float(t.ppf(1 - LEVEL / 2, max(1, change.blocks - 1)))
    if abs(change.change) <= limit * change.std:
        return None
    words = words_of(change.candidate.effect, change.candidate.joint)
    return f"{words}: {change.parameter} differs by {change.change:+.3g} {change.unit} from the baseline"


@contextmanager
def _quiet() -> Iterator[None]:
    """Warnings of single files are no news in a fleet; one process, because the cluster has one for each processor."""
    os.environ[VARIABLE] = "1"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
