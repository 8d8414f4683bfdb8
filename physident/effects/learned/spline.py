"""Smooth functions on an interval or a circle, from the smoothest on: the modes of uniform cubic B-splines.

A curve is a sum of modes. Each is scaled by its roughness, the integral of its squared second derivative, so that one standard
deviation for all of them is the prior of a smoothing spline (Wahba, "Spline models for observational data" (1990), sec. 1.5). No mode
has a mean: a constant belongs to other effects. A straight line counts as rough as the first curve that bends.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def mode_count(pieces: int) -> int:
    """How many modes there are of splines of so many pieces, the same on an interval and on a circle."""
    return pieces - 1


def bumps(t: Array, pieces: int) -> Array:
    """Values (pieces + 3, ...) of the B-splines at places ``t`` (...) from 0 to ``pieces``."""
    distance = np.abs(t - np.arange(-1.0, pieces + 2).reshape(-1, *np.ones(np.ndim(t), dtype=int)))
    return (np.maximum(2 - distance, 0.0) ** 3 - 4 * np.maximum(1 - distance, 0.0) ** 3) / 6


@cache
def modes(pieces: int, circle: bool) -> Array:
    """Coefficients (pieces + 3, modes) of the B-splines in each mode, from the smoothest on.

    Of the size one, as root mean square over the interval or the circle, is the first; the others fall as the square root of their
    roughness rises.
    """
    folded = _folded(pieces) if circle else np.eye(pieces + 3)
    size, rough = (folded.T @ matrix @ folded for matrix in _products(pieces))
    root = np.linalg.inv(np.linalg.cholesky(size)).T
    energy, vectors = np.linalg.eigh(root.T @ rough @ root)
    free = 1 if circle else 2  # a constant; and a line, which does not bend
    first = energy[free]
    found = root @ vectors
    if not circle:
        line = np.linalg.lstsq(found[:, :2], np.arange(-1.0, pieces + 2) - pieces / 2, rcond=None)[0]
        line = found[:, :2] @ line
        found[:, 1], energy[1] = line / np.sqrt(line @ size @ line), first
    scaled = found[:, 1:] * np.sqrt(first / np.maximum(energy[1:], first))
    scaled = folded @ scaled[:, : mode_count(pieces)]
    scaled.setflags(write=False)
    return scaled


def _folded(pieces: int) -> Array:
    """Which B-spline of a circle each one of the interval is: the last three are the first three."""
    result = np.zeros((pieces + 3, pieces))
    result[np.arange(pieces + 3), np.arange(pieces + 3) % pieces] = 1.0
    return result


def _products(pieces: int) -> tuple[Array, Array]:
    """Integrals (pieces + 3, pieces + 3) of products of B-splines, and of their second derivatives, over the unit interval."""
    nodes, weights = np.polynomial.legendre.leggauss(4)  # exact for the products of two cubics
    t = (np.arange(pieces)[:, None] + (nodes + 1) / 2).ravel()
    w = np.tile(weights / 2, pieces) / pieces
    value = bumps(t, pieces)
    distance = np.abs(t - np.arange(-1.0, pieces + 2)[:, None])
    bent = np.maximum(2 - distance, 0.0) - 4 * np.maximum(1 - distance, 0.0)
    return (value * w) @ value.T, (bent * w) @ bent.T
