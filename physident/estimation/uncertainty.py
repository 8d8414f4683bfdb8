"""Standard errors for autocorrelated residuals: a jackknife over blocks much longer than the residuals' correlation time.

Residuals of real arms are correlated over a second and more: thousands of rows amount to hundreds of independent samples,
and textbook standard errors are several times too small. Leaving out one block at a time needs no model of the noise.
Unlike sums of scores over blocks, it is not biased low by the parameters fitted to the same residuals (MacKinnon,
Nielsen, Webb, "Cluster-robust inference: a guide to empirical practice" (2023), the estimator CV3). Intervals use
Student's t with one degree of freedom less than there are blocks that know something.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import Regressor
from physident.errors import warn
from physident.estimation.weighting import base_rows
from physident.identifiability.base_parameters import BaseParameters
from physident.large_arrays import BLOCK, blocks, release

Array = NDArray[np.float64]
BLOCK_PERIODS = 10  # a block lasts this many correlation times, where the data are long enough
FEWEST_BLOCKS = 8  # below, Student's t is wider than any interval worth printing
SHORTEST_PERIODS = 2  # correlation times in a block, below which blocks are not independent
RANK_TOLERANCE = 1e-8  # of the largest singular value, columns scaled to unit length
ROWS = 1 << 13  # of the dense regressor at once
LEVERAGE_FLOOR = 1e-6  # smallest share of a direction's information in the other blocks


@dataclass(frozen=True, eq=False)
class Jackknife:
    """The influence of each of G blocks on an estimate.

    ``deviations`` (G, r): change of the base parameters when the block is left out; ``pushes`` (G, r): the gradient that
    causes the same change with all blocks present; ``shares`` (G,): how many parameters' worth of information is in it.
    """

    deviations: Array
    pushes: Array
    shares: Array

    @property
    def blocks(self) -> int:
        """Number of blocks G."""
        return len(self.deviations)

    @property
    def informative(self) -> int:
        """How many equal blocks would know as much of the variance: those in which joints rest tell little of it
        (Bell and McCaffrey, "Bias reduction in standard errors" (2002), Satterthwaite's count of the leverages)."""
        return max(1, round(float(self.shares.sum() ** 2 / max((self.shares**2).sum(), 1e-300))))

    @property
    def shrink(self) -> float:
        """(G - 1) / G: factor from the sum of squares over blocks to a variance."""
        return (self.blocks - 1) / self.blocks

    @property
    def covariance(self) -> Array:
        """Covariance (r, r) of the base parameters."""
        return self.deviations.T @ self.deviations * self.shrink


def jackknife(
    regressor: Regressor,
    base: BaseParameters,
    influence: Array,
    correlation: float,
    curvature: Array | None = None,
    information: Array | None = None,
) -> Jackknife:
    """The jackknife of an M-estimator whose rows are in units of the noise.

    ``influence`` (M, n) is psi of the residual, the residual itself for squares; ``curvature`` (M, n) its derivative,
    None for one; ``correlation`` the residuals' integrated autocorrelation time in rows; ``information`` (r, r) the
    curvature of data and prior together, None for the data alone. Directions without curvature have no deviation.
    """

    def curved(rows: slice | NDArray[np.intp], A: Array) -> Array:
        return A if curvature is None else A * np.sqrt(curvature[rows])[:, :, None]

    H = np.zeros((base.r, base.r)) if information is None else information
    if information is None and regressor.prior is not None:
        H = H + np.diag(regressor.prior[base.independent])
    for some in blocks(len(regressor.time), ROWS) if information is None else ():
        A = curved(some, base_rows(regressor, base, some))
        H = H + np.einsum("mjr,mjs->rs", A, A, optimize=True)
    scale = np.sqrt(np.where(np.diag(H) > 0, np.diag(H), 1.0))
    values, vectors = np.linalg.eigh(H / np.outer(scale, scale))
    kept = values > RANK_TOLERANCE**2 * values[-1]
    root = vectors[:, kept] / np.sqrt(values[kept]) / scale[:, None]  # root root^T is the inverse information
    deviations, pushes, shares, since_release = [], [], [], 0
    for block in _rows_of_blocks(regressor, correlation):
        A = base_rows(regressor, base, block)
        rows = curved(block, A).reshape(-1, base.r)
        Z = rows @ root
        shares.append(float((Z**2).sum()))
        score = np.einsum("mjr,mj->r", A, influence[block])
        share, directions = np.linalg.eigh(np.eye(Z.shape[1]) - Z.T @ Z)
        deviations.append(root @ ((directions / np.maximum(share, LEVERAGE_FLOOR)) @ (directions.T @ (score @ root))))
        pushes.append(score + rows.T @ (rows @ deviations[-1]))
        since_release += len(A)
        if since_release > BLOCK:
            release()
            since_release = 0
    return Jackknife(np.array(deviations), np.array(pushes), np.array(shares))


def _rows_of_blocks(regressor: Regressor, correlation: float) -> list[NDArray[np.intp]] | list[slice]:
    total = len(regressor.segment)
    length = max(1, min(math.ceil(BLOCK_PERIODS * correlation), total // FEWEST_BLOCKS))
    if length < SHORTEST_PERIODS * correlation:
        seconds = total / regressor.kept_rate
        warn(
            f"{seconds:.3g} s of motion contain {total / correlation:.0f} independent samples: standard errors are rough;"
            " record longer or more often"
        )
    labels = block_labels(regressor.segment, length)
    ends = np.flatnonzero(np.diff(labels)) + 1
    if len(ends) == labels.max():  # no block is in two places
        return [slice(a, b) for a, b in itertools.pairwise([0, *ends.tolist(), total])]
    return np.split(np.argsort(labels, kind="stable"), np.flatnonzero(np.diff(np.sort(labels))) + 1)


def t_quantile(blocks: int, level: float = 0.95) -> float:
    """Half-width of a two-sided interval in standard errors, from this many blocks."""
    from scipy.stats import t

    return float(t.ppf((1 + level) / 2, max(1, blocks - 1)))


def block_labels(segment: NDArray[np.intp], length: int) -> NDArray[np.intp]:
    """Labels (M,) of contiguous blocks of about ``length`` rows that do not cross segments."""
    labels = np.empty(len(segment), dtype=np.intp)
    label = 0
    order = np.argsort(segment, kind="stable")
    ends = np.flatnonzero(np.diff(segment[order])) + 1
    for rows in np.split(order, ends):
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
        most = max(2, max(map(len, pieces)) // 3)
        time, ended = _summed(_autocorrelation(pieces, min(most, BLOCK)))
        if not ended and most > BLOCK:
            time, _ = _summed(_autocorrelation(pieces, most))
        times.append(max(1.0, time))
    return np.array(times)


def _summed(rho: Array) -> tuple[float, bool]:
    """The integrated time of an autocorrelation (lags,), and whether a pair of lags whose sum is not positive has ended the sum."""
    pairs = rho[: len(rho) // 2 * 2].reshape(-1, 2).sum(axis=1)
    negative = np.flatnonzero(pairs <= 0)
    stop = negative[0] if len(negative) else len(pairs)
    return float(2 * pairs[:stop].sum() - 1), bool(len(negative))


def _autocorrelation(pieces: list[Array], lags: int) -> Array:
    """Autocorrelation (lags,) of a series in pieces, from lag 0 on."""
    total = np.zeros(lags)
    for piece in pieces:
        for rows in blocks(len(piece), max(len(piece) if lags > BLOCK else 0, 4 * BLOCK)):
            lagged = _lagged(piece[rows], piece[rows.start : rows.stop + lags], lags)
            total[: len(lagged)] += lagged
    return total / total[0] if total[0] > 0 else np.eye(1, lags)[0]


def _lagged(series: Array, later: Array, lags: int) -> Array:
    """Sums of the products of a series (N,) with what comes from its beginning on, ``later`` (N and more,), at each lag."""
    size = 1 << int(len(series) + len(later) - 1).bit_length()
    product = np.conj(np.fft.rfft(series, size)) * np.fft.rfft(later, size)
    return np.fft.irfft(product, size)[: min(lags, len(later))]
