"""Whether the torque scale of a joint, or of all, differs from that of the recordings which the arm was identified from.

A load adds ten parameters to the last link. A drive gain that is another one scales everything its motor carries, the arm's
own torque too, which no load on the last link does. Friction of the day is fitted along, because it changes without a gain.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import Regressor
from physident.estimation.estimate import Estimate
from physident.estimation.payload.friction_of_the_day import (
    INSTANTS,
    Rows,
    blocks_of,
    first_coefficient,
    lasting,
    load_and_day,
    solve_factor,
)
from physident.estimation.uncertainty import t_quantile
from physident.large_arrays import blocks

Array = NDArray[np.float64]
LEVEL = 0.99  # of the test of all joints together: one healthy recording in a hundred is doubted
SMALLEST = 0.02  # relative: no current sensor is more accurate, and the mass changes by less than its interval


@dataclass(frozen=True, kw_only=True)
class GainChange:
    """The one change of a drive gain that explains most of what a model of the arm and a load leave.

    ``joint`` (from 1) is where it is, None for one change on all joints; ``change`` is relative, ``error`` its standard
    error, from ``blocks`` blocks; it is the largest of ``tested`` changes.
    """

    joint: int | None
    change: float
    error: float
    blocks: int
    tested: int

    @property
    def real(self) -> bool:
        """Whether the change is beyond its error and beyond the accuracy of sensors."""
        allowed = t_quantile(self.blocks, 1 - (1 - LEVEL) / self.tested)
        return abs(self.change) > max(allowed * self.error, SMALLEST)

    @property
    def interval(self) -> tuple[float, float]:
        """The factor of the torque with 95 % confidence."""
        half = t_quantile(self.blocks) * self.error
        return 1 + self.change - half, 1 + self.change + half


def find_gain_change(estimate: Estimate, whole: Regressor, load: Regressor, sigma: Array) -> GainChange:
    """The change of drive gains in recordings of a load: ``whole`` and ``load`` are the arm's and the load's weighted
    regressors, ``sigma`` (n,) [N m|N] the residual. The uncertainty of the arm's parameters is part of the error."""
    model, n = estimate.model, len(whole.joints)
    carried = whole.predict(np.where(lasting(model), model.theta, 0.0))

    def each(some: slice) -> Array:
        """What the arm carries on each joint, one column each, and the columns beside it."""
        own = (carried[some] / sigma)[:, :, None] * np.eye(n)
        return np.column_stack([own.reshape(-1, n), load_and_day(model, whole, load, sigma, some)])

    rows = Rows(load.torque, sigma, each)
    places = [None, *range(1, n + 1)] if n > 1 else [None]
    left = {j: _left(rows.factor, _joined(j, n, rows.factor.shape[1] - 1)) for j in places}
    joint = min(places, key=lambda j: left[j])
    joined = _joined(joint, n, rows.factor.shape[1] - 1)
    chosen = Rows(load.torque, sigma, lambda some: each(some) @ joined)
    labels = blocks_of(load, chosen.residual(solve_factor(rows.factor[:, :-1] @ joined, rows.factor[:, -1])))
    fit = first_coefficient(chosen, labels)
    transfer = np.zeros(len(estimate.base.independent))
    for some in blocks(len(load.torque), INSTANTS):
        arm = whole.dense(some)[:, :, estimate.base.independent] / sigma[:, None]
        transfer += (chosen.columns(some) @ fit.slope) @ arm.reshape(-1, len(transfer))
    return GainChange(
        joint=joint,
        change=fit.value,
        error=math.sqrt(fit.error**2 + float(transfer @ estimate.covariance @ transfer)),
        blocks=fit.blocks,
        tested=len(places),
    )


def _joined(joint: int | None, n: int, count: int) -> Array:
    """The matrix (count, 1 + count - n) that keeps what the arm carries on one of n joints, or sums it over all, and the rest."""
    result = np.zeros((count, 1 + count - n))
    result[:n, 0] = 1.0 if joint is None else np.arange(1, n + 1) == joint
    result[n:, 1:] = np.eye(count - n)
    return result


def _left(factor: Array, joined: Array) -> float:
    """The square sum that least squares of joined columns leave."""
    columns, torque = factor[:, :-1] @ joined, factor[:, -1]
    residual = torque - columns @ solve_factor(columns, torque)
    return float(residual @ residual)
