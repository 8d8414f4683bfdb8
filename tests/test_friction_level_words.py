"""The sentence on an arm's friction tells the joints of which it is certain."""

from __future__ import annotations

import numpy as np

import physident as pid
from physident.effects.scales.friction_level import FrictionLevel


def test_only_joints_that_are_certain_are_told(ur5: pid.Robot) -> None:
    level = FrictionLevel(coulomb=(1.0,) * 6, viscous=(1.0,) * 6, uneven_percent=5.0)
    every = np.array([-12.0, -13.0, -24.0, -22.0, -11.0, -12.5])
    assert level.told_in_words(ur5, every) == (
        "The friction of all joints is 11 to 24 % lower than the model's, as in a warmer arm."
    )
    some = every * [1, 1, 0, 0, 1, 0]
    assert level.told_in_words(ur5, some) == (
        "The friction of joints 1, 2, 5 is 11 to 13 % lower than the model's; that of the others may be as before."
    )
    mixed = np.array([3.0, 0, -2.0, 0, 0, 0])
    assert "joints 1, 3 is 2 % lower to 3 % higher than the model's" in level.told_in_words(ur5, mixed)
    assert level.told_in_words(ur5, np.zeros(6)) == ""
