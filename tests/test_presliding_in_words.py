"""A bristle's stiffness says nothing to a user: what it holds once it slides, and by how much that changed, is said in N m."""

from __future__ import annotations

import numpy as np

import physident as pid
from physident.effects.hysteresis import PreslidingHysteresis


def test_the_sliding_friction_and_its_change_are_told(ur5: pid.Robot) -> None:
    effect = PreslidingHysteresis((2, 5), distance=(0.001, 0.02))
    stiffness, before = np.array([9000.0, 110.0]), np.array([8000.0, 0.0])
    told = effect.change_in_words(ur5, stiffness, before)
    assert (
        told
        == "Once joint 2 slides, this friction is 9 N m, changed by +1 N m. Once joint 5 slides, this friction is 2.2 N m."
    )
