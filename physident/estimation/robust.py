"""Huber's estimator by iterated reweighting: outliers count linearly, not squared."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import Regressor
from physident.errors import NotSolvedError
from physident.estimation.least_squares import Solution, finish, least_squares, solve_step
from physident.estimation.weighting import expand, noise_floor, weight_rows
from physident.identifiability.base_parameters import BaseParameters

Array = NDArray[np.float64]
MAX_ITERATIONS = 200
SETTLED = 1e-7  # change of the base parameters' torques over the noise
MIDDLE_HALF = 1.4826  # standard deviation of a Gaussian over the median of its absolute value


def robust_least_squares(regressor: Regressor, base: BaseParameters, nominal: Array, threshold: float) -> Solution:
    """Minimises the sum of Huber's loss of residual / noise; bends at ``threshold`` standard deviations.

    Starts from weighted least squares; the noise of each joint is that of the middle half of its residuals, iterated.
    Raises NotSolvedError where it does not settle. Source: Huber, "Robust Statistics" (1981), sec. 7.8.
    """
    first = least_squares(regressor, base, nominal, "diagonal")
    x, start = first.base, base.values(nominal)
    for iteration in range(1, MAX_ITERATIONS + 1):  # noqa: B007  (read after the loop)
        residual = regressor.residual(expand(base, x))
        sigma = middle_sigma(regressor, residual)
        weights = np.sqrt(huber_weights(residual / sigma, threshold)) / sigma
        step = solve_step(weight_rows(regressor, weights), base, None, start)
        moved = (regressor.predict(expand(base, step.x - x)) / sigma).std()
        x = step.x
        if moved < SETTLED:
            break
    else:
        raise NotSolvedError(
            f"robust least squares did not settle in {MAX_ITERATIONS} iterations; try method='wls' and look at its residuals"
        )
    white = weight_rows(regressor, 1 / sigma)
    u = white.residual(expand(base, x))
    inside = (np.abs(u) <= threshold).astype(float)
    return finish(regressor, white, base, step, iteration, np.clip(u, -threshold, threshold), inside)


def huber_weights(u: Array, threshold: float) -> Array:
    """Weight of a squared residual ``u`` [standard deviations] that gives it Huber's influence."""
    return np.minimum(1.0, threshold / np.maximum(np.abs(u), 1e-300))


def middle_sigma(regressor: Regressor, residual: Array) -> Array:
    """Standard deviation (n,) [N m|N] of the middle half of each joint's residuals, deaf to outliers."""
    size = np.nanmedian(np.where(regressor.counted, np.abs(residual), np.nan), axis=0)
    return np.maximum(MIDDLE_HALF * size, noise_floor(regressor))
