"""Recordings that several tests of a module ask for are made by the first that does."""

from __future__ import annotations

from pathlib import Path

import physident as pid
from tests.plant import Arm, Sensors, record
from tests.plant.motions import Motion

STEP = 4e-3  # s: torque after the filter is then right to an eighth of the instruments' noise, which is a hundredth of its power


def made_once(path: Path, arm: Arm, motion: Motion, noise: int) -> pid.Recording:
    """The recording in a file, which is that of an arm's motion with some noise; the file's name must tell all three."""
    if not path.exists():
        record(arm, motion, Sensors(), noise, step=STEP).write_csv(path)
    return pid.load_recording(path)
