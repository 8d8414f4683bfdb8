"""Checks of recordings before they are used: duplicates, constant efforts, and efforts in another unit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from physident.errors import InputError
from physident.large_arrays import blocks, extent
from physident.recordings.recording import Recording
from physident.robots.robot import Robot

MIN_TRAVEL = 0.05  # rad or m: over a smaller range, a coarsely quantised torque may be constant
MAX_RATIO = 10.0  # to the robot's effort limit: real torques are below one, a wrong unit prefix gives a thousand
SHOWN = 100_000  # rows at most that a percentile is of
PERCENTILE = 99.0  # of the torque, so that single spikes do not count


def refuse_duplicates(recordings: Sequence[Recording]) -> None:
    """Raises InputError for two recordings with the same samples, which would count twice."""
    seen: dict[str, str] = {}
    for recording in recordings:
        if recording.sha256 in seen:
            raise InputError(
                f"{recording.source}: has the same samples as {seen[recording.sha256]}; expected each recording once"
            )
        seen[recording.sha256] = recording.source


def check_effort(recordings: Sequence[Recording], robot: Robot) -> None:
    """Raises InputError, naming recording and joint, for a constant effort (see ``refuse_constant``) and for torques so far
    above the robot's effort limits that their unit must be wrong. The recordings have the robot's joints."""
    for recording in recordings:
        refuse_constant(recording)
        _refuse_other_unit(recording, robot)


def refuse_constant(recording: Recording) -> None:
    """Raises InputError for an effort that is exactly the same in every row while its joint moves."""
    travel, variation = extent(recording.q), extent(recording.effort)
    for j in np.flatnonzero((variation == 0) & (travel > MIN_TRAVEL)):
        unit = "A" if recording.effort_kind == "current" else "N m"
        raise InputError(
            f"{recording.source}: the {recording.effort_kind} of joint {j + 1} is {recording.effort[0, j]:g} {unit} in every"
            f" row while the joint moves over {travel[j]:.3g} rad; expected a measured channel: correct the log or --columns,"
            " or leave the recording out"
        )


def _refuse_other_unit(recording: Recording, robot: Robot) -> None:
    every = -(-len(recording.time) // SHOWN)
    torque = recording.torque
    some = np.concatenate([torque[rows][::every].copy() for rows in blocks(len(torque))])  # what is read is given back
    high = np.percentile(np.abs(some), PERCENTILE, axis=0)
    ratio = high / robot.torque_limit  # zero where the robot states no limit
    j = int(np.argmax(ratio))
    if ratio[j] > MAX_RATIO:
        guess = "N m: is the log in mN m?"
        if recording.effort_kind == "current":
            guess = "amperes and drive gains in N m/A: is the log in mA?"
        raise InputError(
            f"{recording.source}: the torque of joint {j + 1} reaches {high[j]:.4g} N m, {ratio[j]:.0f} times the robot's effort"
            f" limit of {robot.torque_limit[j]:g} N m; expected {guess} Convert it, or correct the limit in {robot.source}"
        )
