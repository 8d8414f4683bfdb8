"""A designed motion as the independent plant of ``tests/plant`` follows it, for studies that record both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import physident as pid

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Plan:
    """A trajectory as the plant's controller follows it."""

    trajectory: pid.Trajectory

    @property
    def duration(self) -> float:
        """How long it lasts [s]."""
        return self.trajectory.duration

    def states(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities, accelerations (N, 6) at times (N,) [s]."""
        s = self.trajectory.states(time)
        return s.q, s.v, s.a
