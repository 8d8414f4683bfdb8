"""What a recorded effort cannot be, held against its own motion and against the robot's limits."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from physident.errors import InputError
from physident.recordings.recording import Recording
from physident.robots.robot import Robot

MOVES = 0.05  # rad or m: over less, coarse digits may hide what a quiet joint's torque does
BEYOND = 10.0  # times a robot's effort limit: real arms stay below once, a wrong prefix of the unit is a thousand times
HIGH = 99.0  # percentile: spikes are no unit


def refuse_twice(recordings: Sequence[Recording]) -> None:
    """Raises InputError where two recordings hold the same samples: they would count as twice the evidence."""
    seen: dict[str, str] = {}
    for recording in recordings:
        if recording.sha256 in seen:
            raise InputError(
                f"{recording.source}: holds the same samples as {seen[recording.sha256]}; expected each recording once"
            )
        seen[recording.sha256] = recording.source


def check_effort(recordings: Sequence[Recording], robot: Robot) -> None:
    """Raises InputError, naming recording and joint, for a constant effort (see ``refuse_constant``), and for torques far
    beyond the robot's effort limits, which are of another unit. The recordings have the robot's joints."""
    for recording in recordings:
        refuse_constant(recording)
        _refuse_other_unit(recording, robot)


def refuse_constant(recording: Recording) -> None:
    """Raises InputError for an effort that is the same to the last bit in every row while its joint moves."""
    moved, varied = np.ptp(recording.q, axis=0), np.ptp(recording.effort, axis=0)
    for j in np.flatnonzero((varied == 0) & (moved > MOVES)):
        unit = "A" if recording.effort_kind == "current" else "N m"
        raise InputError(
            f"{recording.source}: the {recording.effort_kind} of joint {j + 1} is {recording.effort[0, j]:g} {unit} in every"
            f" row while the joint moves over {moved[j]:.3g} rad; expected a measured channel: mend the log or --columns,"
            " or leave the recording out"
        )


def _refuse_other_unit(recording: Recording, robot: Robot) -> None:
    high = np.percentile(np.abs(recording.torque), HIGH, axis=0)
    ratio = high / robot.torque_limit  # zero where the robot states no limit
    j = int(np.argmax(ratio))
    if ratio[j] > BEYOND:
        guess = "N m: is the log in mN m?"
        if recording.effort_kind == "current":
            guess = "amperes and drive gains in N m/A: is the log in mA?"
        raise InputError(
            f"{recording.source}: the torque of joint {j + 1} reaches {high[j]:.4g} N m, {ratio[j]:.0f} times the robot's effort"
            f" limit of {robot.torque_limit[j]:g} N m; expected {guess} Convert it, or correct the limit in {robot.source}"
        )
