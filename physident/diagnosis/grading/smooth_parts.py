"""What rows hold beyond a function of their joint's position, and one of its velocity, that is common to all recordings.

Most of what a model lacks is such a function: a cable, cogging, bent friction. Other motions show other parts of it, and each of them
would look like a change. What a function of the same state explains before and after has not changed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.learned.pool import AMPLITUDES
from physident.dynamics.regressor import build_regressor
from physident.effects.learned.curve import LearnedCurve
from physident.effects.learned.curves import LearnedPosition
from physident.effects.learned.velocity_curve import LearnedVelocity
from physident.estimation.weighting import weight_rows
from physident.recordings.signals import Filter, Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class SmoothParts:
    """Columns (M, k) of the functions of one joint, and the ``precision`` (k,) of a prior by which each function is as large as what is left
    of the joint's torque."""

    columns: Array
    precision: Array

    def taken_off(self, rows: Array) -> Array:
        """Rows (M, ...), in units of what is left, less what the functions explain of them.

        Source: the partial residuals of Robinson, "Root-N-consistent semiparametric regression" (1988), eq. 3.2, with a penalised
        spline in the place of a kernel.
        """
        S = self.columns
        return rows - S @ np.linalg.solve(S.T @ S + np.diag(self.precision), S.T @ rows)


def smooth_parts(robot: Robot, parts: Sequence[tuple[Sequence[Signals], Array]], filter: Filter) -> list[SmoothParts]:
    """The functions of each joint in the rows of several sets of signals, each with the weights (M, n) of its rows."""
    every = [one for signals, _ in parts for one in signals]
    curves = [
        _as_large_as_one(kind((j + 1,)), robot) for j in range(robot.n) for kind in (LearnedPosition, LearnedVelocity)
    ]
    placed = [curve.placed(robot, every) for curve in curves]
    precision = np.concatenate([curve.prior_sizes_of_one() for curve in curves]) ** -2
    built = [weight_rows(build_regressor(robot, placed, signals, filter), weights) for signals, weights in parts]
    result = []
    for j in range(robot.n):
        columns = built[0].joints[j].columns
        values = np.concatenate([one.joints[j].values for one in built])
        result.append(SmoothParts(columns=values, precision=precision[columns]))
    return result


def _as_large_as_one(curve: LearnedCurve, robot: Robot) -> LearnedCurve:
    """The curve with a prior by which its torque is expected to have a root mean square of one."""
    return replace(curve, amplitude=(AMPLITUDES[-1],), ceiling=(1 / np.sqrt(len(curve.columns(robot))),))
