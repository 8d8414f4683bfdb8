"""Ordinary and weighted least squares of the compressed regressor, with standard errors that survive autocorrelation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.base_parameters import BaseParameters
from physident.errors import NotSolvedError
from physident.regressor import Regressor

Array = NDArray[np.float64]
RANK_TOLERANCE = 1e-8  # of the largest singular value, columns scaled to unit length
MAX_ITERATIONS = 50
BLOCK_PERIODS = 10  # a block of scores lasts this many correlation times


@dataclass(frozen=True, eq=False)
class Solution:
    """Base parameters (r,) that minimise the weighted residual, with what is known about them.

    ``covariance`` (r, r); ``sigma`` (n,) [N m|N] residual per joint; ``determined`` (r,) which the data decided;
    ``stationarity`` largest normalised gradient left; ``condition`` of the scaled regressor; ``iterations``;
    ``effective_samples`` (n,) how many independent samples the residuals are worth.
    """

    base: Array
    covariance: Array
    sigma: Array
    determined: NDArray[np.bool_]
    stationarity: float
    condition: float
    iterations: int
    effective_samples: Array


def least_squares(regressor: Regressor, base: BaseParameters, nominal: Array, weighted: bool) -> Solution:
    """Least squares over the base parameters; directions that the data do not move stay at ``nominal`` (p,).

    Unweighted: thesis eq. 3.64. Weighted: rows of joint j over its residual's standard deviation, iterated until that
    settles. Raises NotSolvedError where it does not.
    """
    n = len(regressor.joints)
    weights = np.ones(n)
    start = base.values(nominal)
    for iteration in range(1, MAX_ITERATIONS + 1):
        x, singular, V, scale = _solve(regressor, base, weights, start)
        residual = regressor.torque - regressor.predict(_expand(base, x))
        sigma = _sigma(regressor, residual, base)
        if not weighted:
            break
        if np.allclose(1 / sigma, weights, rtol=1e-6):
            break
        weights = 1 / sigma
    else:
        raise NotSolvedError(
            f"weighted least squares did not settle in {MAX_ITERATIONS} iterations; try method='ols' and look at its residuals"
        )
    kept = singular > RANK_TOLERANCE * singular[0]
    pinv = (V[:, kept] / singular[kept] ** 2) @ V[:, kept].T / np.outer(scale, scale)
    gradient = _scores(regressor, base, residual, weights)
    covariance = pinv @ _clustered(regressor, gradient, residual) @ pinv
    lost = V[:, ~kept] / scale[:, None]
    determined = (np.abs(lost).max(axis=1, initial=0.0) * scale) < 1e-6
    normalised = np.abs(gradient.sum(axis=0)) / (scale * max(float(np.linalg.norm(residual * weights)), 1e-300))
    return Solution(
        x, covariance, sigma, determined, float(normalised.max()),
        float(singular[0] / singular[kept][-1]), iteration, effective_samples(regressor, residual),
    )  # fmt: skip


def _solve(
    regressor: Regressor, base: BaseParameters, weights: Array, start: Array
) -> tuple[Array, Array, Array, Array]:
    R, z, _ = regressor.compressed(weights)
    A = R[:, base.independent]
    scale = np.linalg.norm(A, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    U, singular, Vt = np.linalg.svd(A / scale, full_matrices=False)
    kept = singular > RANK_TOLERANCE * singular[0]
    step = Vt[kept].T @ ((U[:, kept].T @ (z - A @ start)) / singular[kept])
    return start + step / scale, singular, Vt.T, scale


def _expand(base: BaseParameters, x: Array) -> Array:
    """Parameters (p,) with base values x and zeros in the dependent places: enough to predict."""
    theta = np.zeros(len(base.columns))
    theta[base.independent] = x
    return theta


def _sigma(regressor: Regressor, residual: Array, base: BaseParameters) -> Array:
    """Residual standard deviation per joint; the r parameters are charged to the joints in equal parts."""
    freedom = max(1.0, len(residual) - base.r / residual.shape[1])
    sigma = np.sqrt((residual**2).sum(axis=0) / freedom)
    floor = 1e-12 * max(1.0, float(np.abs(regressor.torque).max()))
    return np.maximum(sigma, floor)  # noise-free data must not divide by zero


def _scores(regressor: Regressor, base: BaseParameters, residual: Array, weights: Array) -> Array:
    """Score of every kept instant (M, r): Y_B^T W^2 residual."""
    place = np.full(len(base.columns), -1)
    place[base.independent] = np.arange(base.r)
    scores = np.zeros((len(residual), base.r))
    for j, rows in enumerate(regressor.joints):
        mine = np.flatnonzero(place[rows.columns] >= 0)
        scores[:, place[rows.columns[mine]]] += rows.values[:, mine] * (weights[j] ** 2 * residual[:, j])[:, None]
    return scores


def _clustered(regressor: Regressor, scores: Array, residual: Array) -> Array:
    """Covariance of the summed scores from sums over blocks far longer than the residuals' memory."""
    length = max(1, int(np.ceil(BLOCK_PERIODS * correlation_rows(regressor, residual).max())))
    blocks = block_labels(regressor.segment, length)
    sums = np.zeros((blocks[-1] + 1, scores.shape[1]))
    np.add.at(sums, blocks, scores)
    count = len(sums)
    return sums.T @ sums * (count / max(1, count - 1))


def block_labels(segment: NDArray[np.intp], length: int) -> NDArray[np.intp]:
    """Labels (M,) of contiguous blocks of about ``length`` rows that do not cross segments."""
    labels = np.empty(len(segment), dtype=np.intp)
    label = 0
    for part in np.unique(segment):
        rows = np.flatnonzero(segment == part)
        for block in np.array_split(rows, max(1, round(len(rows) / length))):
            labels[block] = label
            label += 1
    return labels


def correlation_rows(regressor: Regressor, residual: Array) -> Array:
    """Integrated autocorrelation time (n,) of each joint's residual, in kept rows, at least one.

    Summed up to the first pair of lags whose sum is negative (Geyer, "Practical Markov chain Monte Carlo", 1992, sec. 3.3).
    """
    times = []
    for series in residual.T:
        pieces = [series[regressor.segment == s] for s in np.unique(regressor.segment)]
        rho = _autocorrelation(pieces)
        pairs = rho[: len(rho) // 2 * 2].reshape(-1, 2).sum(axis=1)
        negative = np.flatnonzero(pairs <= 0)
        stop = negative[0] if len(negative) else len(pairs)
        times.append(max(1.0, 2 * pairs[:stop].sum() - 1))
    return np.array(times)


def effective_samples(regressor: Regressor, residual: Array) -> Array:
    """How many independent samples (n,) each joint's residuals are worth."""
    return len(residual) / correlation_rows(regressor, residual)


def _autocorrelation(pieces: list[Array]) -> Array:
    """Autocorrelation of a series in pieces, lags from 0 to a third of the longest piece."""
    lags = max(2, max(len(piece) for piece in pieces) // 3)
    total = np.zeros(lags)
    for piece in pieces:
        size = 1 << int(2 * len(piece) - 1).bit_length()
        spectrum = np.abs(np.fft.rfft(piece, size)) ** 2
        lagged = np.fft.irfft(spectrum, size)[: min(lags, len(piece))]
        total[: len(lagged)] += lagged
    return total / total[0] if total[0] > 0 else np.eye(1, lags)[0]
