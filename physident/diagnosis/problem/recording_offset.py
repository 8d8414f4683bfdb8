"""Optional nuisance columns: a torque sensor's zero that drifts between recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from physident.effects.effect import Array, Effect
from physident.recordings.signals import Signals
from physident.robots.robot import Robot


@dataclass(frozen=True)
class RecordingOffset(Effect):
    """A constant torque in one recording alone, known by its hash, one column a joint; never part of a model."""

    recording: str = ""

    name: ClassVar[str] = "recording_offset"
    unit: ClassVar[str] = "N m"

    def values(self, robot: Robot, signals: Signals) -> Array:
        inside = float(signals.recording == self.recording)
        return np.full((len(self.active(robot)), len(signals.time)), inside)


def offset_of_each_recording(signals: Sequence[Signals]) -> list[RecordingOffset]:
    """One offset for each recording, because the true zero is unknown."""
    return [RecordingOffset(recording=one.recording) for one in signals]
