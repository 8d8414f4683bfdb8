"""Whether the torque scale of a joint, or of all, differs from that of the recordings which the arm was identified from.

A load adds ten parameters to the last link. A drive gain that is another one scales everything its motor carries, the arm's
own torque too, which no load on the last link does. Friction of the day is fitted along, because it changes without a gain.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor
from physident.effects.classification import Family
from physident.estimation.estimate import Estimate
from physident.estimation.uncertainty import BLOCK_PERIODS, FEWEST_BLOCKS, block_labels, correlation_rows, t_quantile

Array = NDArray[np.float64]
LEVEL = 0.99  # of the test of all joints together: one healthy recording in a hundred is doubted
SMALLEST = 0.02  # relative: no current sensor is more accurate, and the mass changes by less than its interval
RANK = 1e-9  # of the largest singular value, columns scaled to unit length
OF_THE_DAY = (Family.FRICTION, Family.MEASUREMENT)


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
    families = [effect.family for effect in model.effects for _ in effect.columns(model.robot)]
    of_the_day = np.array([family in OF_THE_DAY for family in families])
    arm, torque = whole.Y / sigma[:, None], (load.torque / sigma).reshape(-1)
    beside = np.concatenate([load.Y / sigma[:, None], arm[:, :, of_the_day]], axis=2)
    carried = whole.predict(np.where(of_the_day, 0.0, model.theta)) / sigma
    places = [None, *range(1, n + 1)] if n > 1 else [None]
    left = {j: _left(_joined(carried, j, beside), torque) for j in places}
    joint = min(places, key=lambda j: float(left[j] @ left[j]))
    length = math.ceil(BLOCK_PERIODS * correlation_rows(load, left[joint].reshape(-1, n)).max())
    labels = block_labels(load.segment, max(1, min(length, len(load.time) // FEWEST_BLOCKS)))
    change, error = _change(_joined(carried, joint, beside), torque, np.repeat(labels, n), estimate, arm)
    return GainChange(joint=joint, change=change, error=error, blocks=int(labels[-1]) + 1, tested=len(places))


def _joined(carried: Array, joint: int | None, beside: Array) -> Array:
    """Columns (M n, 1 + k) of unit length: what the arm carries (M, n), on one joint or on all, and those beside it (M, n, k)."""
    chosen = np.ones(carried.shape[1]) if joint is None else np.arange(1, carried.shape[1] + 1) == joint
    columns = np.concatenate([(carried * chosen)[:, :, None], beside], axis=2)
    return columns.reshape(-1, columns.shape[2])


def _scaled(columns: Array) -> tuple[Array, float]:
    """Columns of unit length, and the length of the first."""
    size = np.linalg.norm(columns, axis=0)
    size = np.where(size > 0, size, 1.0)
    return columns / size, float(size[0])


def _left(columns: Array, torque: Array) -> Array:
    """The residual of least squares, joints within instants."""
    columns, _ = _scaled(columns)
    return torque - columns @ np.linalg.lstsq(columns, torque, rcond=RANK)[0]


def _change(
    columns: Array, torque: Array, labels: NDArray[np.intp], estimate: Estimate, arm: Array
) -> tuple[float, float]:
    """The first column's coefficient and its standard error: a jackknife over blocks, and the arm's own uncertainty."""
    columns, size = _scaled(columns)
    normal = columns.T @ columns
    inverse = np.linalg.pinv(normal, rcond=RANK, hermitian=True)
    x = inverse @ (columns.T @ torque)
    residual = torque - columns @ x
    deviations = []
    for block in range(labels[-1] + 1):
        rows = columns[labels == block]
        rest = np.linalg.pinv(normal - rows.T @ rows, rcond=RANK, hermitian=True)
        deviations.append(float(rest[0] @ (rows.T @ residual[labels == block])))
    transfer = inverse[0] @ columns.T @ arm[:, :, estimate.base.independent].reshape(len(torque), -1)
    blocks = len(deviations)
    variance = (blocks - 1) / blocks * float(np.square(deviations).sum())
    variance += float(transfer @ estimate.covariance @ transfer)
    return float(x[0]) / size, math.sqrt(variance) / size
