"""Physical signs of the model plus the change: what a candidate's values would make of the arm."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.search.hypothesis import Hypothesis

Array = NDArray[np.float64]
SPEEDS = 40  # of the grid on which a joint's friction must oppose its motion, up to the fastest that was recorded
SIGN_STANDARD_ERRORS = (
    3.0  # standard errors beyond the sign: what noise alone does once in 700 times is no contradiction
)


def physical_contradiction(hypothesis: Hypothesis) -> str | None:
    """What the effect that was accepted last makes impossible, in words; None where the extended arm can exist.

    Its own cones, and the friction of its joints as a sum over all effects at speeds that were recorded.
    """
    model, robot = hypothesis.extension.model, hypothesis.problem.model.robot
    effect, places = hypothesis.accepted[-1].effect, hypothesis.extension.places[-1]
    for cone in effect.cones(robot):
        rows = np.zeros((len(cone.map), len(model.theta)))
        rows[:, places] = cone.map
        new = places.min() >= len(hypothesis.problem.model.theta)  # what was not there cannot have fallen
        if _negative(hypothesis, rows, cone.offset, 0.0 if new else SIGN_STANDARD_ERRORS):
            return f"{effect.name} would be negative"
    names = [column.joint for column in effect.columns(robot)]
    for j in {joint - 1 for joint in names}:
        fastest = max(float(np.abs(one.v[:, j]).max()) for one in hypothesis.problem.signals)
        speeds = np.linspace(fastest / SPEEDS, fastest, SPEEDS)
        v = np.concatenate([-speeds[::-1], speeds])
        if not effect.friction(robot, v).any():
            continue
        rows = []
        for other in model.effects:
            mine = np.array([column.joint == j + 1 for column in other.columns(robot)])
            rows.append((other.friction(robot, v) * np.sign(v)) * mine[:, None])
        if _negative(hypothesis, np.concatenate(rows).T, np.zeros(len(v)), SIGN_STANDARD_ERRORS):
            return f"friction of joint {j + 1} would drive it"
    return None


def _negative(hypothesis: Hypothesis, rows: Array, offset: Array, doubt: float) -> bool:
    values = rows @ hypothesis.extension.model.theta + offset
    errors = np.sqrt(np.maximum(np.einsum("kp,pq,kq->k", rows, hypothesis.covariance, rows, optimize=True), 0.0))
    return bool((values < -doubt * errors - 1e-12).any())
