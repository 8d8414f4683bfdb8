"""Physical signs of the model plus the change: what a candidate's values would make of the arm."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.search.hypothesis import State

Array = NDArray[np.float64]
SPEEDS = 40  # of the grid on which a joint's friction must oppose its motion, up to the fastest that was recorded
DOUBT = 3.0  # standard errors beyond the sign: what noise alone does once in 700 times is no contradiction


def contradicted(state: State) -> str | None:
    """What the effect that was accepted last makes impossible, in words; None where the extended arm can exist.

    Its own cones, and the friction of its joints as a sum over all effects at speeds that were recorded.
    """
    model, robot = state.extension.model, state.case.model.robot
    effect, places = state.accepted[-1].effect, state.extension.places[-1]
    for cone in effect.cones(robot):
        rows = np.zeros((len(cone.map), len(model.theta)))
        rows[:, places] = cone.map
        new = places.min() >= len(state.case.model.theta)  # what was not there cannot have fallen
        if _negative(state, rows, cone.offset, 0.0 if new else DOUBT):
            return f"{effect.name} would be negative"
    names = [column.joint for column in effect.columns(robot)]
    for j in {joint - 1 for joint in names}:
        fastest = max(float(np.abs(one.v[:, j]).max()) for one in state.case.signals)
        speeds = np.linspace(fastest / SPEEDS, fastest, SPEEDS)
        v = np.concatenate([-speeds[::-1], speeds])
        if not effect.friction(robot, v).any():
            continue
        rows = []
        for own in model.effects:
            mine = np.array([column.joint == j + 1 for column in own.columns(robot)])
            rows.append((own.friction(robot, v) * np.sign(v)) * mine[:, None])
        if _negative(state, np.concatenate(rows).T, np.zeros(len(v)), DOUBT):
            return f"friction of joint {j + 1} would drive it"
    return None


def _negative(state: State, rows: Array, offset: Array, doubt: float) -> bool:
    values = rows @ state.extension.model.theta + offset
    errors = np.sqrt(np.maximum(np.einsum("kp,pq,kq->k", rows, state.covariance, rows, optimize=True), 0.0))
    return bool((values < -doubt * errors - 1e-12).any())
