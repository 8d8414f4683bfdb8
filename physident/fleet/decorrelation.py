"""Noise that lasts from row to row, made white: generalised least squares.

What a model leaves of a recording is correlated over seconds. Ordinary least squares stays right then, but slow errors of the model
outweigh everything else. With each row taken relative to what the rows before it predict, fast and slow parts count as much as they
are known (Aitken, "On least squares and linear combination of observations", 1936; Cochrane and Orcutt, "Application of least
squares regression to relationships containing auto-correlated error terms", 1949).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import Regressor

Array = NDArray[np.float64]
LASTS = 0.5  # s: of the rows before that predict a row; slower noise is predicted through them, one after another
FEWEST = 50  # rows for each coefficient: fewer determine it to worse than a tenth
WHITE = 0.01  # share of the noise that is taken to be white, or what the low-pass took out would count as known exactly


@dataclass(frozen=True, eq=False)
class Decorrelation:
    """The filter (order + 1,) of each joint, of a row and of those before it, that makes noise white with unit variance."""

    filters: tuple[Array, ...]

    @property
    def order(self) -> int:
        """Number of rows before a row that predict it."""
        return len(self.filters[0]) - 1

    def apply(self, rows: Regressor, response: Array, block: slice) -> tuple[Array, Array]:
        """Columns (K n, p) and response (K n,) of a block of rows, white; rows at the beginning of a segment are left out."""
        start = max(0, block.start - self.order)
        segment = rows.segment[start : block.stop]
        at = np.arange(max(block.start - start, self.order), block.stop - start)
        at = at[segment[at - self.order] == segment[at]]
        Y, y = rows.dense(slice(start, block.stop)), response[start : block.stop]
        columns, white = np.zeros((len(at), *Y.shape[1:])), np.zeros((len(at), y.shape[1]))
        for j, taps in enumerate(self.filters):
            for lag, tap in enumerate(taps):
                columns[:, j] += tap * Y[at - lag, j]
                white[:, j] += tap * y[at - lag, j]
        return columns.reshape(-1, Y.shape[2]), white.ravel()


def decorrelation_of(rows: Regressor, noise: Array) -> Decorrelation:
    """The autoregression of each joint's ``noise`` (M, n) in the rows of a regressor, by Yule and Walker's equations."""
    from scipy.linalg import solve_toeplitz

    order = min(round(LASTS * rows.kept_rate), len(noise) // FEWEST)
    filters = []
    for series in noise.T:
        power = np.array([_product(series, rows.segment, lag) for lag in range(order + 1)])
        if power[0] == 0.0 or not order:
            filters.append(np.r_[1.0 if power[0] == 0.0 else len(series) ** 0.5 / power[0] ** 0.5, np.zeros(order)])
            continue
        power[0] *= 1 + WHITE
        taps = solve_toeplitz(power[:-1], power[1:])
        left = (power[0] - taps @ power[1:]) / len(series)
        filters.append(np.r_[1.0, -taps] / np.sqrt(left))
    return Decorrelation(tuple(filters))


def _product(series: Array, segment: NDArray[np.intp], lag: int) -> float:
    """Sum of the products of values that lie ``lag`` rows apart in the same segment."""
    later = len(series) - lag
    return float((series[:later] * series[lag:]) @ (segment[:later] == segment[lag:]))
