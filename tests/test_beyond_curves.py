"""A simulation says where it leaves what a learned curve was learned from, and is silent where it does not."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import physident as pid
from physident.effects.learned.curves import LearnedPosition
from physident.effects.learned.velocity_curve import LearnedVelocity


def test_a_motion_beyond_a_curve_is_told(ur5: pid.Robot) -> None:
    motion = pid.random_trajectory(ur5, seed=1, base_frequency=0.2, duration=5.0)
    states = motion.states(np.linspace(0.0, motion.duration, 2001))
    q, v = states.q[:, 1], states.v[:, 2]
    middle, fastest = (q.min() + q.max()) / 2, np.abs(v).max()
    for share in (1.0, 0.5):
        half = share * np.ptp(q) / 2
        curves = [
            LearnedPosition((2,), (middle - half,), (middle + half,), (1.0,)),
            LearnedVelocity((3,), (-share * fastest,), (share * fastest,), (1.0,)),
        ]
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            pid.simulate(pid.Model.nominal(ur5, ["rigid_body", *curves]), motion)
        texts = [str(one.message) for one in said]
        if share == 1.0:
            assert texts == []
            continue
        told = ("joint 2 leaves what learned_position was", "joint 3 leaves what learned_velocity was")
        for text, start, reached in zip(texts, told, (q, v), strict=True):
            assert text.startswith(start)
            ends = [float(x) for x in text.split(": ")[1].split(" rad")[0].split(" to ")]
            assert ends == pytest.approx([reached.min(), reached.max()], abs=0.05)  # a controller follows it nearly
