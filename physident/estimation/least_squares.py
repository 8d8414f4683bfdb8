"""Ordinary and weighted least squares of the compressed regressor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import Regressor
from physident.errors import NotSolvedError
from physident.estimation.physical.certificate import condition_number
from physident.estimation.uncertainty import RANK_TOLERANCE, correlation_rows, jackknife
from physident.estimation.weighting import compress, expand, joint_sigma, noise_floor, weight_rows, whiten
from physident.identifiability.base_parameters import BaseParameters
from physident.large_arrays import blocks

Array = NDArray[np.float64]
ROUNDING = 1e-9  # of the largest column: a joint that rests leaves rounding of its position, and no equation
MAX_ITERATIONS = 500  # a model that lacks most of the torque, as one without friction, takes more than 80
SETTLED = 1e-6  # relative change of the noise's size between iterations


@dataclass(frozen=True, eq=False)
class Solution:
    """Base parameters (r,) that minimise the weighted residual, with what is known about them.

    ``covariance`` (r, r) from ``blocks`` blocks; ``sigma`` (n,) [N m|N] residual per joint; ``determined`` (r,) which the
    data decided; ``stationarity`` largest normalised gradient left; ``condition`` of the scaled regressor;
    ``iterations``; ``effective_samples`` (n,) how many independent samples the residuals are worth.
    """

    base: Array
    covariance: Array
    sigma: Array
    determined: NDArray[np.bool_]
    stationarity: float
    condition: float
    iterations: int
    effective_samples: Array
    blocks: int


def least_squares(
    regressor: Regressor, base: BaseParameters, nominal: Array, noise: Literal["equal", "diagonal", "full"]
) -> Solution:
    """Least squares over the base parameters; directions that the data do not move stay at ``nominal`` (p,).

    ``noise`` "equal": thesis eq. 3.64. "diagonal": rows of joint j over its residual's standard deviation; "full": rows
    whitened by the residuals' covariance between joints; both iterated until that settles. Raises NotSolvedError where
    it does not.
    """
    start = base.values(nominal)
    covariance = np.eye(len(regressor.joints))
    for iteration in range(1, MAX_ITERATIONS + 1):
        if noise == "full" and iteration > 1:
            step = solve_step(whiten(regressor, covariance), base, None, start)
        else:
            step = solve_step(regressor, base, 1 / np.sqrt(np.diag(covariance)), start)
        residual = regressor.residual(expand(base, step.x))
        found = _noise(regressor, residual, base, noise == "full")
        if noise == "equal" or np.allclose(found, covariance, rtol=SETTLED, atol=SETTLED * np.diag(covariance).min()):
            break
        covariance = found
    else:
        raise NotSolvedError(
            f"weighted least squares did not settle in {MAX_ITERATIONS} iterations; try method='ols' and look at its residuals"
        )
    white = whiten(regressor, covariance) if noise == "full" else weight_rows(regressor, np.diag(covariance) ** -0.5)
    return finish(regressor, white, base, step, iteration)


def finish(
    regressor: Regressor,
    white: Regressor,
    base: BaseParameters,
    step: Step,
    iterations: int,
    influence: Array | None = None,
    curvature: Array | None = None,
) -> Solution:
    """The solution of a settled iteration, proved stationary from the rows themselves.

    ``white`` is the regressor in units of the noise; ``influence``, ``curvature`` (M, n) of a robust loss.
    """
    theta = expand(base, step.x)
    residual = regressor.residual(theta)
    if influence is None:
        influence = white.residual(theta)
    gradient = sum(
        np.bincount(rows.columns, rows.some(some).T @ psi[some], len(base.columns))
        for rows, psi in zip(white.joints, influence.T, strict=True)
        for some in blocks(len(psi))
    )
    if white.prior is not None:
        gradient = gradient - white.prior * theta
    cosine = np.abs(np.asarray(gradient)[base.independent]) / (
        step.scale * max(float(np.linalg.norm(influence)), 1e-300)
    )
    memory = correlation_rows(regressor, residual)
    left_out = jackknife(white, base, influence, float(memory.max()), curvature)
    return Solution(
        step.x, left_out.covariance, joint_sigma(regressor, residual, base.r), step.determined, float(cosine.max()),
        step.condition, iterations, len(residual) / memory, left_out.informative,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Step:
    """One linear solution: base parameters ``x`` (r,), ``scale`` (r,) the columns' lengths, what the data determine."""

    x: Array
    scale: Array
    determined: NDArray[np.bool_]
    condition: float


def solve_step(regressor: Regressor, base: BaseParameters, weights: Array | None, start: Array) -> Step:
    factor = compress(regressor, base, weights)
    scale = np.linalg.norm(factor.R, axis=0)
    says = scale > ROUNDING * scale.max(initial=0.0)
    scale = np.where(says, scale, 1.0)
    U, singular, Vt = np.linalg.svd(says * factor.R / scale)
    kept = singular > RANK_TOLERANCE * singular[0]
    step = Vt[kept].T @ ((U[:, kept].T @ (factor.z - factor.R @ start)) / singular[kept])
    lost = np.abs(Vt[~kept]).max(axis=0, initial=0.0)
    return Step(start + step / scale, scale, lost < 1e-6, condition_number(singular))


def _noise(regressor: Regressor, residual: Array, base: BaseParameters, full: bool) -> Array:
    """Covariance (n, n) of the residuals, diagonal unless ``full``."""
    sigma = np.maximum(joint_sigma(regressor, residual, base.r), noise_floor(regressor))
    if not full:
        return np.diag(sigma**2)
    size = np.sqrt(len(residual)) * np.maximum(np.sqrt((residual**2).mean(axis=0)), noise_floor(regressor))
    correlation = (residual / size).T @ (residual / size)
    np.fill_diagonal(correlation, 1.0 + 1e-9)  # noise-free data have no rank
    return correlation * np.outer(sigma, sigma)
