"""Base parameters of the halves beside the thesis' lists (4.4), (4.5): the same space, and what is misprinted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.rigid_body_regressor import torque_regressor
from physident.identifiability.base_parameters import BaseParameters, random_motion, select_base
from studies.thesis.halves import dh_columns, from_dh_frames, half
from studies.thesis.published import MEANT, PRINTED

Array = NDArray[np.float64]
SHOWN = 1e-6  # share of a combination that torques do not show: below it, it is a base parameter


@dataclass(frozen=True, eq=False)
class List:
    """One half's list: ours (first independent columns), the thesis' columns with the sums they stand for, and of each
    printed entry the share (r,) that lies outside what torques show, NaN where it is no combination of parameters."""

    ours: BaseParameters
    theirs: BaseParameters
    outside: Array
    angle: float  # largest principal angle between the column spaces [rad]


def compare(name: str, seed: int = 0) -> List:
    """The lists of one half ("bse" or "w"), from a random motion."""
    robot, columns = half(name), dh_columns(name)
    motion = random_motion(robot, seed)
    Y = torque_regressor(robot, motion.q, motion.v, motion.a).reshape(-1, 30) @ from_dh_frames(name)
    names = [column.name for column in columns]
    chosen = [names.index(parameter) for parameter in MEANT[name]]
    rest = [i for i in range(30) if i not in chosen]
    order = [*chosen, *rest]
    theirs = select_base(np.asarray(np.linalg.qr(Y[:, order], mode="r")), [columns[i] for i in order])
    ours = select_base(np.asarray(np.linalg.qr(Y, mode="r")), columns)
    shown = np.linalg.qr(ours.grouping.T)[0]  # an orthonormal basis of the combinations that torques show
    outside = np.array([_outside(entry, names, shown) for entry in PRINTED[name]])
    return List(ours, theirs, outside, angle(Y[:, ours.independent], Y[:, chosen]))


def printed_rank(name: str) -> int:
    """How many of the columns that a list names first are independent when it is read as printed."""
    robot = half(name)
    motion = random_motion(robot, 0)
    Y = torque_regressor(robot, motion.q, motion.v, motion.a).reshape(-1, 30) @ from_dh_frames(name)
    names = [column.name for column in dh_columns(name)]
    first = [next(iter(entry)) for entry in PRINTED[name]]
    return int(np.linalg.matrix_rank(Y[:, [names.index(parameter) for parameter in first if parameter in names]]))


def _outside(entry: dict[str, float], names: list[str], shown: Array) -> float:
    if any(parameter not in names for parameter in entry):
        return np.nan
    row = np.zeros(len(names))
    row[[names.index(parameter) for parameter in entry]] = list(entry.values())
    row /= np.linalg.norm(row)
    return float(np.linalg.norm(row - shown @ (shown.T @ row)))


def angle(A: Array, B: Array) -> float:
    """Largest principal angle [rad] between the spaces that the columns of A and B (N, r) span; pi/2 for other ranks."""
    if np.linalg.matrix_rank(A) != np.linalg.matrix_rank(B):
        return float(np.pi / 2)
    basis, other = (np.linalg.qr(X / np.linalg.norm(X, axis=0))[0] for X in (A, B))
    # the sine by what is left over: the arc cosine of nearly one would lose half the digits
    return float(np.arcsin(min(1.0, np.linalg.norm(other - basis @ (basis.T @ other), 2))))


def printed(entry: dict[str, float]) -> str:
    """An entry as text."""
    text = ""
    for name, factor in entry.items():
        sign = " - " if factor < 0 else " + " if text else ""
        text += sign + ("" if abs(factor) == 1 else f"{abs(factor):g} ") + name
    return text


def table(name: str, found: List) -> list[str]:
    """Rows of a table: what is printed, and the sum that its column stands for."""
    marks = ["no parameter" if np.isnan(o) else "" if o < SHOWN else "not shown" for o in found.outside]
    rows = [f"{'printed':<28}{'by torques':<14}what the column stands for (p_1 + beta p_2)"]
    rows += [
        f"{printed(entry):<28}{mark or 'shown':<14}{text}"
        for entry, mark, text in zip(PRINTED[name], marks, found.theirs.expressions(), strict=True)
    ]
    return rows
