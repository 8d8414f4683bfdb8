"""By how much the friction of the other joints differs along the same repeated motion: a joint that differs by far more has changed.

Recordings of different motions differ by what the model lacks along each, too, and not by the day alone. Along a repeated motion that cancels,
and the joints that nothing was found on show what the day makes of friction. Where they differ by far less than the recordings of the
healthy arm did, those did not differ by their days.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.grading.control import UNUSUAL
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.usual.usual_friction import UsualFriction
from physident.dynamics.friction_parameters import friction_values

Array = NDArray[np.float64]
LEAST = 0.01  # of the friction: no gear repeats better from day to day


def as_other_joints_show(hypothesis: Hypothesis, usual: UsualFriction) -> UsualFriction:
    """What is ``usual``, with the limit of a joint's friction that the joints show on which nothing was found, where they differ by less
    than chance makes of as much scatter as the recordings of the healthy arm show (F test).

    It stays as it is where a recording repeats no motion, and where something was found on several joints: those that are left were chosen for
    differing little. What was found on the whole arm is part of what the other joints differ by.
    """
    from scipy.stats import f, t

    problem, named = hypothesis.problem, {j for one in hypothesis.accepted for j in one.candidate.joints}
    others = [j for j in range(problem.model.robot.n) if j + 1 not in named]
    if not problem.all_compared or not others or len(named) > 1 or usual.spread == 0:
        return usual
    shares = _shares(hypothesis)[others]
    shares = shares[np.isfinite(shares)]
    if not len(shares):
        return usual
    spread = float(np.sqrt(np.mean(shares**2)))
    if (spread / usual.spread) ** 2 >= f.ppf(UNUSUAL, len(shares), usual.freedom):
        return usual
    most = float(t.ppf(1 - UNUSUAL / (2 * problem.model.robot.n), len(shares)) * spread)
    return replace(usual, joint=min(usual.joint, max(LEAST, most)), spread=spread)


def _shares(hypothesis: Hypothesis) -> Array:
    """By which share (n,) of its friction each joint differs from the repeated recordings, all that was found included; NaN without friction."""
    problem = hypothesis.problem
    change = hypothesis.fit.residual + sum(
        hypothesis.columns(one.candidate, one.effect).torque(values)
        for one, values in zip(hypothesis.accepted, hypothesis.effect_values, strict=True)
    )
    values, shares = np.sum(friction_values(problem.model), axis=0), []
    for j, joint in enumerate(problem.regressor.joints):
        own = joint.columns < len(values)
        friction = joint.values[:, own] @ values[joint.columns[own]]
        power = float(friction @ friction)
        shares.append(float(friction @ change[:, j]) / power if power > 0 else np.nan)
    return np.array(shares)
