"""Residuals of rows that were left out, row by row, for the few candidates that need more than a sum."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.evidence import OUTSIDE, Baseline, Evidence, inverted, whitening

Array = NDArray[np.float64]


def left_out_residual(
    evidence: Evidence, baseline: Baseline, weights: Array, options: Sequence[Sequence[Array]] = ()
) -> Array:
    """Residual (M, n) [N m|N] in each fold of the baseline and the best option fitted outside it; zero in gaps.

    Each option is the columns (M, k) of an effect in each joint's rows; the best has the largest gain outside the fold.
    """
    n = len(weights)
    y = evidence.response * weights
    B = [w * own for w, own in zip(weights, baseline.joints, strict=True)]
    C = [[w * own for w, own in zip(weights, option, strict=True)] for option in options]
    result = np.zeros_like(y)
    for f in np.unique(evidence.fold[evidence.fold != OUTSIDE]):
        train, test = (evidence.fold != OUTSIDE) & (evidence.fold != f), evidence.fold == f
        H = sum(own[train].T @ own[train] for own in B) + np.diag(baseline.prior)
        inverse = inverted(H)
        x = inverse @ sum(own[train].T @ y[train, j] for j, own in enumerate(B))
        left = y - np.column_stack([own @ x for own in B])
        best, chosen = 0.0, left[test]
        for option in C:
            Z = inverse @ sum(own[train].T @ c[train] for own, c in zip(B, option, strict=True))
            apart = [c - own @ Z for own, c in zip(B, option, strict=True)]
            inner = sum(c[train].T @ c[train] for c in option)
            outside = sum(c[train].T @ a[train] for c, a in zip(option, apart, strict=True))
            slope = sum(c[train].T @ left[train, j] for j, c in enumerate(option))
            root = whitening(np.asarray(inner)[None], np.asarray(outside)[None])[0]
            theta = root @ (root.T @ slope)
            if (seen := float(slope @ theta)) > best:
                best, chosen = seen, left[test] - np.column_stack([a[test] @ theta for a in apart])
        result[test] = chosen
    return result / weights[:n]


def block_costs(residual: Array, weights: Array, labels: NDArray[np.intp]) -> Array:
    """Squared weighted residual of each block (G, n), by joint."""
    squares = (residual * weights) ** 2
    inside = labels != OUTSIDE
    return np.column_stack([np.bincount(labels[inside], own[inside]) for own in squares.T])


def standard_error(differences: Array) -> float:
    """Standard error of a sum over blocks (G,) that are independent of each other."""
    G = len(differences)
    return float(np.sqrt(G / (G - 1) * np.sum((differences - differences.mean()) ** 2)))
