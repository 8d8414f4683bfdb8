"""Residuals of rows that were left out, row by row, for the few candidates that need more than a sum."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.evidence import OUTSIDE, Baseline, Evidence
from physident.diagnosis.normal import inverted, whitening

Array = NDArray[np.float64]


def left_out_residual(
    evidence: Evidence, baseline: Baseline, weights: Array, options: Sequence[Sequence[Array]] = ()
) -> Array:
    """Residual (M, n) [N m|N] in each fold of the baseline and the best option fitted outside it; zero in gaps.

    Each option is the columns (M, k) of an effect in each joint's rows; the best has the largest gain outside the fold.
    """
    R, n = len(baseline.prior), len(weights)
    sizes = [option[0].shape[1] for option in options]
    places = [np.arange(R + end - k, R + end) for k, end in zip(sizes, np.cumsum(sizes), strict=True)]
    rows = [
        w * np.column_stack([baseline.joints[j], *(option[j] for option in options), evidence.response[:, j]])
        for j, w in enumerate(weights)
    ]
    labels = np.unique(evidence.fold[evidence.fold != OUTSIDE])
    grams = {f: _gram(rows, evidence.fold == f) for f in labels}
    whole = sum(grams.values())
    result = np.zeros_like(evidence.response)
    for f in labels:
        values = _fitted(whole - grams[f], R, places, baseline.prior)
        test = evidence.fold == f
        for j in range(n):
            result[test, j] = (rows[j][test, -1] - rows[j][test, :-1] @ values) / weights[j]
    return result


def _gram(rows: Sequence[Array], chosen: NDArray[np.bool_]) -> Array:
    """Products of columns, and of columns and the response, which stands last."""
    parts = [own[chosen] for own in rows]
    return np.sum([part.T @ part for part in parts], axis=0)


def _fitted(G: Array, R: int, places: Sequence[NDArray[np.intp]], prior: Array) -> Array:
    """Values of all columns: the baseline's and the best option's, the others' zero."""
    inverse = inverted(G[:R, :R] + np.diag(prior))
    values, best = np.zeros(len(G) - 1), 0.0
    values[:R] = x = inverse @ G[:R, -1]
    for at in places:
        Z = inverse @ G[:R, at]
        inner, slope = G[np.ix_(at, at)], G[at, -1] - G[:R, at].T @ x
        root = whitening(inner[None], (inner - G[:R, at].T @ Z)[None])[0]
        theta = root @ (root.T @ slope)
        if (seen := float(slope @ theta)) > best:
            best = seen
            values[R:] = 0.0
            values[at], values[:R] = theta, x - Z @ theta
    return values


def block_costs(residual: Array, weights: Array, labels: NDArray[np.intp]) -> Array:
    """Squared weighted residual of each block (G, n), by joint."""
    squares = (residual * weights) ** 2
    inside = labels != OUTSIDE
    return np.column_stack([np.bincount(labels[inside], own[inside]).astype(float) for own in squares.T])


def standard_error(differences: Array) -> float:
    """Standard error of a sum over blocks (G,) that are independent of each other."""
    G = len(differences)
    return float(np.sqrt(G / (G - 1) * np.sum((differences - differences.mean()) ** 2)))
