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
    blocks_of,
    first_coefficient,
    lasting,
    load_and_day,
    residual_of,
)
from physident.estimation.uncertainty import t_quantile

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
    torque, beside = (load.torque / sigma).reshape(-1), load_and_day(model, whole, load, sigma)
    carried = whole.predict(np.where(lasting(model), model.theta, 0.0)) / sigma
    places = [None, *range(1, n + 1)] if n > 1 else [None]
    left = {j: residual_of(_joined(carried, j, beside), torque) for j in places}
    joint = min(places, key=lambda j: float(left[j] @ left[j]))
    labels = blocks_of(load, left[joint])
    change, error, slope = first_coefficient(_joined(carried, joint, beside), torque, labels)
    arm = (whole.Y[:, :, estimate.base.independent] / sigma[:, None]).reshape(len(torque), -1)
    transfer = slope @ arm
    return GainChange(
        joint=joint,
        change=change,
        error=math.sqrt(error**2 + float(transfer @ estimate.covariance @ transfer)),
        blocks=int(labels[-1]) + 1,
        tested=len(places),
    )


def _joined(carried: Array, joint: int | None, beside: Array) -> Array:
    """Columns (M n, 1 + k): what the arm carries (M, n), on one joint or on all, and those beside it (M n, k)."""
    chosen = np.ones(carried.shape[1]) if joint is None else np.arange(1, carried.shape[1] + 1) == joint
    return np.column_stack([(carried * chosen).reshape(-1), beside])
