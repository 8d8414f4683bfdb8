"""The one place where a test's arm is given the estimator's own friction near zero speed.

The plant's friction turns by another law, over another width. Today the diagnosis explains part of that difference by
Stribeck friction, even on a healthy arm: ``test_an_unchanged_arm_of_another_law_is_accused_of_nothing`` expects this failure.
Tests of the machinery (gates, rivals, offsets, files, printing) need an arm that the default model describes exactly and take
it from here. What they show of found causes holds for such arms only; the open world judges the others.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.effects.friction import SMOOTHING
from tests.plant import Arm
from tests.plant.laws import Smooth

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class EstimatorsOwn(Smooth):
    """s = tanh(u / width)."""

    width: Array | float = SMOOTHING

    def direction(self, u: Array) -> Array:
        """s (..., m) at speeds (..., m) [rad/s]."""
        return np.tanh(u / self.width)

    def slope(self, u: Array) -> Array:
        """ds/du (..., m) [s/rad]."""
        return (1 - np.square(np.tanh(u / self.width))) / self.width


def exact_arm(arm: Arm | None = None) -> Arm:
    """An arm, by default the ordinary one, with friction that turns exactly as `physident.identify` assumes."""
    arm = arm or Arm()
    return replace(arm, friction=replace(arm.friction, law=EstimatorsOwn()))
