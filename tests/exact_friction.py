"""The one place where a test's arm is given the estimator's own friction near zero speed.

The plant's friction turns by another law, over another width. Tests of the machinery (thresholds, rivals, offsets, files,
printing) need an arm that the default model describes exactly and take it from here: its friction turns by the estimator's
law, over a width that the estimator tries. What they show of found causes holds for such arms only; the open world judges the
others.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from physident.recordings.velocity_sign import CERTAIN
from tests.plant import Arm
from tests.plant.laws import Smooth

Array = NDArray[np.float64]


WIDTH = 0.008  # rad/s: one of the widths that the estimator tries
STEEP = np.sqrt(2 / np.pi)  # the standard deviation whose expected sign has the slope 1


@dataclass(frozen=True, eq=False)
class EstimatorsOwn(Smooth):
    """s = E sgn(u) for a velocity as uncertain as ``width`` [rad/s]: erf(sqrt(pi) u / (2 width)).

    A recording asks for it tens of thousands of times, so it is written here once more, for few numbers at a time; a test of
    ``expected_sign`` proves that both are the same.
    """

    width: Array | float = WIDTH

    @cached_property
    def bounds(self) -> tuple[float, float]:
        """The speed [rad/s] from which on the sign is certain, and the one that erf counts in."""
        std = STEEP * float(np.max(self.width))
        return CERTAIN * std, float(np.sqrt(2) * std)

    def direction(self, u: Array) -> Array:
        """s (..., m) at speeds (..., m) [rad/s]."""
        certain, unit = self.bounds
        return np.where(np.abs(u) > certain, np.sign(u), erf(u / unit))

    def slope(self, u: Array) -> Array:
        """ds/du (..., m) [s/rad]."""
        return np.exp(-np.pi * np.square(u / self.width) / 4) / self.width


def exact_arm(arm: Arm | None = None) -> Arm:
    """An arm, by default the ordinary one, with friction that turns exactly as `physident.identify` assumes."""
    arm = arm or Arm()
    return replace(arm, friction=replace(arm.friction, law=EstimatorsOwn()))
