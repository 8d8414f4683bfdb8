"""Inverses of normal matrices in which directions may be missing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs

Array = NDArray[np.float64]
potrf, potri = get_lapack_funcs(("potrf", "potri"))  # Cholesky factor, and inverse from it
INSIDE = 1e-6  # share of a candidate direction outside the baseline below which its value is rounding and noise
RANK = 1e-10  # of the largest eigenvalue of the scaled normal matrix, the square of a singular value: below, rounding decides
DECIDED = 1e-6  # of a scaled matrix's smallest pivot: all eigenvalues then lie far above RANK
ZERO = 1e-9  # of the largest column: a smaller one is rounding


def whitening(inner: Array, outside: Array) -> Array:
    """Roots (O, k, k) of the inverse of ``outside`` (O, k, k), zero along directions inside the baseline."""
    size = np.sqrt(np.maximum(np.diagonal(inner, axis1=1, axis2=2), 0.0))
    size = np.where(size > ZERO * np.maximum(size.max(axis=1, keepdims=True), 1e-300), size, np.inf)
    values, vectors = np.linalg.eigh(outside / (size[:, :, None] * size[:, None, :]))
    scale = np.where(values > INSIDE, 1 / np.sqrt(np.maximum(values, INSIDE)), 0.0)
    return vectors * scale[:, None, :] / size[:, :, None]


def pseudo_inverse(H: Array) -> Array:
    """Inverse of a normal matrix (R, R), zero along directions that nothing decides."""
    if not len(H):
        return H
    size = np.sqrt(np.maximum(np.diag(H), 0.0))  # rounding may make a silent column negative
    size = np.where(size > ZERO * size.max(), size, np.inf)
    scaled = H / np.outer(size, size)
    L, failed = potrf(scaled, lower=1, clean=1)
    if not failed and L.diagonal().min() ** 2 > DECIDED:  # ten times as fast where every direction is decided
        lower, _ = potri(L, lower=1)
        return (lower + np.tril(lower, -1).T) / np.outer(size, size)
    values, vectors = np.linalg.eigh(scaled)
    kept = values > RANK * values[-1]
    root = vectors[:, kept] / np.sqrt(values[kept]) / size[:, None]
    return root @ root.T


def undecided(H: Array, rows: Array) -> NDArray[np.bool_]:
    """Which linear functions (r,) of some values, ``rows`` (r, R), their normal matrix (R, R) leaves open: the same torque, another value."""
    size = np.sqrt(np.maximum(np.diag(H), 0.0))
    felt = np.flatnonzero(size > ZERO * size.max(initial=0.0))
    if not len(felt):
        return np.asarray(rows.any(axis=1))
    values, vectors = np.linalg.eigh(H[np.ix_(felt, felt)] / np.outer(size[felt], size[felt]))
    scaled = rows[:, felt] / size[felt]
    along = scaled @ vectors[:, values <= RANK * values[-1]]
    silent = np.delete(rows, felt, axis=1).any(axis=1)
    return np.logical_or(silent, (along**2).sum(axis=1) > INSIDE * (scaled**2).sum(axis=1))


def first_takes_all(H: Array, sizes: Sequence[int]) -> Array:
    """The map (R, R) of least-norm values to those of the same torque in which groups of so many values give what several of them can make
    to the first: the mass of a payload can be one of the link before it, and the norm alone would share it out.

    ``H`` (R, R) is the normal matrix of the groups' columns.
    """
    size = np.sqrt(np.maximum(np.diag(H), 0.0))
    felt = np.flatnonzero(size > ZERO * size.max(initial=0.0))
    result, size = np.eye(len(H)), size[felt]
    if not len(felt):
        return result
    group = np.repeat(np.arange(len(sizes)), sizes)[felt]
    values, vectors = np.linalg.eigh(H[np.ix_(felt, felt)] / np.outer(size, size))
    free, total = vectors[:, values <= RANK * values[-1]], np.eye(len(felt))
    for last in reversed(range(len(sizes))):  # as small as those after it allow
        own = group == last
        u, s, vt = np.linalg.svd(free[own])
        rank = int(np.sum(s > INSIDE))
        moves = np.zeros_like(total)
        moves[:, own] = free @ vt[:rank].T @ (u[:, :rank] / s[:rank]).T
        total, free = total - moves @ total, free @ vt[rank:].T
    result[np.ix_(felt, felt)] = total / size[:, None] * size
    return result
