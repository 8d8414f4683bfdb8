"""Weights that make rows of compared recordings and of others equally sure."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def evened(residual: Array, weights: Array, compared: NDArray[np.bool_], usual: Array) -> Array:
    """What rows (M, n) are multiplied by, so that those of ``compared`` recordings (M,) and the others leave a residual of one size.

    A model errs along a new motion by more than the noise that a comparison leaves: without weights, what a comparison knows would
    be lost among what the others do not. The less sure rows count for less, and the surer ones as they are. ``residual`` (M, n) has
    the ``weights`` (M, n) given; rows that are not compared err at least by what is ``usual`` (n,) [N m|N], however much of it many
    candidates at once take up.
    """
    result = np.ones(residual.shape)
    if compared.all() or not compared.any():
        return result
    sizes = [
        np.sqrt((residual[rows] ** 2).sum(axis=0) / np.maximum((weights[rows] ** 2).sum(axis=0), 1e-300))
        for rows in (compared, ~compared)
    ]
    sizes[1] = np.maximum(sizes[1], usual)
    least = np.maximum(np.minimum(*sizes), 1e-300)
    for rows, size in zip((compared, ~compared), sizes, strict=True):
        result[rows] = least / np.maximum(size, least)
    return result
