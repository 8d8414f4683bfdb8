"""Residuals of rows that were left out, row by row, for the few candidates that need more than a sum."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.search_data import OUTSIDE, Baseline, SearchData
from physident.diagnosis.statistics.normal_equations import pseudo_inverse, whitening

Array = NDArray[np.float64]


class LeftOutFits:
    """A baseline fitted outside each fold, kept, so that one candidate more costs its own products alone."""

    def __init__(self, data: SearchData, baseline: Baseline, weights: Array) -> None:
        self.joints, self.squares = baseline.joints, weights**2
        self.tests = [np.flatnonzero(data.fold == f) for f in np.unique(data.fold) if f != OUTSIDE]
        y = data.response
        grams = [self._products(rows, self.joints, self.joints) for rows in self.tests]
        slopes = [self._products(rows, self.joints, y.T[:, :, None])[:, 0] for rows in self.tests]
        whole, slope = np.sum(grams, axis=0) + np.diag(baseline.prior), np.sum(slopes, axis=0)
        self.inverse = [pseudo_inverse(whole - part) for part in grams]
        self.x = [inverse @ (slope - part) for inverse, part in zip(self.inverse, slopes, strict=True)]
        self.response, self.alone = y, np.zeros_like(y)
        for rows, x in zip(self.tests, self.x, strict=True):
            self.alone[rows] = y[rows] - np.column_stack([B[rows] @ x for B in self.joints])

    def residual(self, options: Sequence[Sequence[Array]] = (), priors: Sequence[Array] = ()) -> Array:
        """Residual (M, n) [N m|N] in each fold of the baseline and the best option fitted outside it; zero in gaps.

        Each option is the columns (M, k) of an effect in each joint's rows; the best has the largest gain outside the fold.
        ``priors`` (k,) are the prior precisions of each option's values, by default none.
        """
        if not options:
            return self.alone
        C = [np.column_stack(part) for part in zip(*options, strict=True)]
        ends = np.cumsum([option[0].shape[1] for option in options])
        places = [np.arange(end - o[0].shape[1], end) for o, end in zip(options, ends, strict=True)]
        prior = np.concatenate(priors) if priors else np.zeros(ends[-1])
        y = self.response.T[:, :, None]
        sums = [
            (self._products(rows, C, C), self._products(rows, self.joints, C), self._products(rows, C, y)[:, 0])
            for rows in self.tests
        ]
        whole = [np.sum(part, axis=0) for part in zip(*sums, strict=True)]
        result = self.alone.copy()
        for rows, part, inverse, x in zip(self.tests, sums, self.inverse, self.x, strict=True):
            CC, BC, Cy = (total - left_out for total, left_out in zip(whole, part, strict=True))
            theta, moved = _best(CC, BC, Cy - BC.T @ x, inverse, places, prior)
            for j, (B, columns) in enumerate(zip(self.joints, C, strict=True)):
                result[rows, j] -= columns[rows] @ theta - B[rows] @ moved
        return result

    def _products(self, rows: NDArray[np.intp], left: Sequence[Array] | Array, right: Sequence[Array] | Array) -> Array:
        """Weighted products of two sets of columns over some rows of all joints."""
        return np.sum([s * (a[rows].T @ b[rows]) for s, a, b in zip(self.squares, left, right, strict=True)], axis=0)


def _best(
    CC: Array, BC: Array, slope: Array, inverse: Array, places: Sequence[NDArray[np.intp]], prior: Array
) -> tuple[Array, Array]:
    """Values (K,) of the best option's columns, the others' zero, and by how much (R,) the baseline's then fall."""
    theta, moved, best = np.zeros(len(slope)), np.zeros(len(inverse)), 0.0
    for at in places:
        Z = inverse @ BC[:, at]
        inner = CC[np.ix_(at, at)]
        root = whitening(inner[None], (inner - BC[:, at].T @ Z + np.diag(prior[at]))[None])[0]
        values = root @ (root.T @ slope[at])
        if (seen := float(slope[at] @ values)) > best:
            best, theta = seen, np.zeros(len(slope))
            theta[at], moved = values, Z @ values
    return theta, moved


def block_costs(residual: Array, weights: Array, labels: NDArray[np.intp]) -> Array:
    """Squared weighted residual of each block (G, n), by joint."""
    squares = (residual * weights) ** 2
    inside = labels != OUTSIDE
    return np.column_stack([np.bincount(labels[inside], part[inside]).astype(float) for part in squares.T])


def standard_error(differences: Array) -> float:
    """Standard error of a sum over blocks (G,) that are independent of each other."""
    G = len(differences)
    return float(np.sqrt(G / (G - 1) * np.sum((differences - differences.mean()) ** 2)))


def reduction_percent(before: Array, after: Array) -> float:
    """By how much [%] the RMS of the joint that feels it most falls, from squared residuals (n,) before and after."""
    left = np.maximum(after, 0.0) / np.maximum(before, 1e-300)
    return float(100 * (1 - np.sqrt(left.min())))
