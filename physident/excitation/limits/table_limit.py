"""The table: a horizontal plane that the arm stays above."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.excitation.limits.arm_geometry import ArmGeometry, index_pairs, link_name
from physident.excitation.limits.limit import ACTIVE_DISTANCE, DISTANCE_RESERVE, LENGTH_UNIT, Margin, WorkspaceLimit
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
FIXED = 1e-6  # m: an end of a capsule whose height changes less than this over all poses is fixed


@dataclass(frozen=True, eq=False)
class TableLimit(WorkspaceLimit):
    """The ends of the links' capsules stay ``clearance`` [m] above a table at ``height`` [m] in the base frame.

    ``height`` is None where there is no table.
    """

    arm: ArmGeometry
    height: float | None
    clearance: float

    lower = 0.0
    upper = np.inf

    @cached_property
    def ends(self) -> tuple[tuple[int, int], ...]:
        """Ends of capsules (capsule, end) whose height the joints can change."""
        if self.height is None:
            return ()
        z = self.arm.sampled_ends[..., 2]
        return tuple((c, end) for c in range(len(self.arm.capsules)) for end in (0, 1) if np.ptp(z[:, c, end]) > FIXED)

    @property
    def count(self) -> int:
        return len(self.ends)

    def constraint(self, values: Array) -> Array:
        c, end = index_pairs(self.ends)
        distance = self.arm.ends(values)[:, c, end, 2] - self.arm.radii[c] - (self.height or 0.0)
        return (distance - (self.clearance + DISTANCE_RESERVE)) / LENGTH_UNIT

    def gradient(self, values: Array, jacobian: Array) -> Array:
        c, end = index_pairs(self.ends)
        return self.arm.end_jacobians(jacobian)[:, c, end, 2] / LENGTH_UNIT

    def margins(self, states: Signals) -> list[Margin]:
        if not self.ends:
            return []
        z = self.arm.ends(self.arm.values(states.q))[..., 2].min(axis=0) - (self.height or 0.0)
        distance, link = min(
            (float(z[c, end]) - self.arm.capsules[c].radius, self.arm.capsules[c].link) for c, end in self.ends
        )
        return [
            Margin.of(
                "table", link_name(link), "m",
                reached=distance, allowed=self.clearance, margin=distance - self.clearance,
                active_below=ACTIVE_DISTANCE,
            )
        ]  # fmt: skip
