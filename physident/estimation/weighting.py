"""Weighting, whitening and compressing a regressor: the steps that all estimators share."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import JointRows, Regressor
from physident.identifiability.base_parameters import BaseParameters
from physident.large_arrays import blocks, computed, magnitude, squares

Array = NDArray[np.float64]
ROWS = 1 << 13  # looked at at once
SMALLEST = 1e-12  # N m|N: the residual of exact data
FINEST = 1e-4  # of a joint's torque: 13 bits of its range, beyond any torque sensor or current loop


@dataclass(frozen=True, eq=False)
class Compressed:
    """The QR factor of a regressor: |residual|^2 = |R b - z|^2 + rest for base parameters b (r,), with R (r, r), z (r,).

    ``rows`` is the number of rows behind it.
    """

    R: Array
    z: Array
    rest: float
    rows: int


def weight_rows(regressor: Regressor, weights: Array) -> Regressor:
    """The regressor with every row and its torque multiplied by ``weights``, (n,) or (M, n)."""
    weights = np.broadcast_to(weights, regressor.torque.shape)
    prior = _scaled_prior(regressor, weights.max(axis=0))
    M = len(weights)
    joints = tuple(
        rows.weighted(computed(M, lambda some, w=w: w[some]))
        for rows, w in zip(regressor.joints, weights.T, strict=True)
    )
    torque = computed(weights.shape, lambda some: regressor.torque[some] * weights[some])
    return replace(regressor, joints=joints, torque=torque, prior=prior)


def _scaled_prior(regressor: Regressor, weights: Array) -> Array | None:
    """The rows that a prior counts for, weighted as the rows of its joint that count most (n,)."""
    if regressor.prior is None:
        return None
    return regressor.prior * weights[[column.joint - 1 for column in regressor.columns]] ** 2


def whiten(regressor: Regressor, covariance: Array) -> Regressor:
    """The regressor whose rows at one instant are mixed so that noise of ``covariance`` (n, n) [N m] becomes white.

    Row j is sum_k W_jk row_k with W the inverse of the covariance's Cholesky factor: thesis eq. 3.63.
    """
    W = np.linalg.inv(np.linalg.cholesky(covariance))
    every = np.arange(len(regressor.columns))
    Y = np.einsum("jk,mkp->jmp", W, regressor.Y, optimize=True)
    joints = tuple(JointRows(every, values) for values in Y)
    prior = _scaled_prior(regressor, 1 / np.sqrt(np.diag(covariance)))
    return replace(regressor, joints=joints, torque=regressor.torque @ W.T, prior=prior)


def information_in(regressor: Regressor, base: BaseParameters, sigma: Array, worth: Array) -> Array:
    """The information (r, r) about the base parameters in a regressor whose rows of each joint leave ``sigma`` (n,) [N m|N] and
    are worth ``worth`` (n,) independent samples."""
    information = np.zeros((base.r, base.r))
    place = np.full(len(regressor.columns), -1)
    place[base.independent] = np.arange(base.r)
    for rows, size, samples in zip(regressor.joints, sigma, worth, strict=True):
        chosen, total = place[rows.columns] >= 0, len(regressor.time)
        at = np.ix_(place[rows.columns[chosen]], place[rows.columns[chosen]])
        for some in blocks(total, ROWS):
            Y = rows.some(some)[:, chosen] / max(float(size), SMALLEST)
            information[at] += samples / total * (Y.T @ Y)
    if regressor.prior is not None:
        noise = np.maximum(sigma[[column.joint - 1 for column in regressor.columns]], SMALLEST)
        information += np.diag((regressor.prior / noise**2)[base.independent])
    return information


def compress(regressor: Regressor, base: BaseParameters, weights: Array | None = None) -> Compressed:
    """The QR factor of a regressor over its base parameters, after ``weights`` (n,) of its joints."""
    weights = np.ones(len(regressor.joints)) if weights is None else weights
    R, z, rest = regressor.compressed(weights)
    r = base.r
    factor = np.zeros((r + 1, r + 1))
    found = np.linalg.qr(np.column_stack([R[:, base.independent], z]), mode="r")
    factor[: len(found)] = found[: r + 1]
    return Compressed(factor[:r, :r], factor[:r, r], rest + float(factor[r, r] ** 2), int(regressor.counted.sum()))


def base_rows(regressor: Regressor, base: BaseParameters, rows: slice | NDArray[np.intp]) -> Array:
    """The columns (K, n, r) of the base parameters, in some rows."""
    return regressor.dense(rows)[:, :, base.independent]


def expand(base: BaseParameters, values: Array) -> Array:
    """Parameters (p,) with base parameters ``values`` (r,) and zeros in the dependent places: enough to predict."""
    theta = np.zeros(len(base.columns))
    theta[base.independent] = values
    return theta


def joint_sigma(regressor: Regressor, residual: Array, parameters: float) -> Array:
    """Residual standard deviation (n,) [N m|N]; the ``parameters`` fitted are charged to the joints in equal parts."""
    freedom = np.maximum(1.0, regressor.counted.sum(axis=0) - parameters / residual.shape[1])
    return np.maximum(np.sqrt(squares(residual) / freedom), rounding(regressor))


def rounding(regressor: Regressor) -> float:
    """Standard deviation below which residuals are rounding: noise-free data must not divide by zero."""
    return 1e-12 * max(1.0, float(magnitude(regressor.torque).max()))


def noise_floor(regressor: Regressor, share: float = FINEST) -> Array:
    """Smallest noise (n,) [N m|N] that a joint's rows are weighted by: no torque is known better than a ``share`` of its size.

    Below it, residuals of noise-free data are what resampling, differences and the filter leave, which says nothing about
    the joint; weights that followed it would never settle.
    """
    size = np.sqrt((regressor.torque**2).mean(axis=0))
    # a joint that carries next to no torque is not known better than a hundredth of that share of the others
    return np.maximum(share * np.maximum(size, size.max() / 100), rounding(regressor))
