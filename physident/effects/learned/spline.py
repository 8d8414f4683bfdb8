"""Smooth functions on an interval or a circle, from the smoothest on: the modes of uniform cubic B-splines.

A curve is a sum of modes. Each is scaled so that one standard deviation for all of them is the prior of a curve which forgets over a
certain length (Matern's of smoothness 3/2; Rasmussen and Williams, "Gaussian processes for machine learning" (2006), sec. 4.2.1):
where nothing was recorded it returns to zero, and what is much finer than that length must be shown by the more rows. The first is a
constant: a curve without a mean of its own would swing where no row has been to have none over its whole range.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
WAVES = np.pi  # wave number over the whole range, of half a wave: over a third of its range a curve forgets


def mode_count(pieces: int) -> int:
    """How many modes there are of splines of so many pieces, the same on an interval and on a circle."""
    return pieces


def bumps(t: Array, pieces: int) -> Array:
    """Values (pieces + 3, ...) of the B-splines at places ``t`` (...) from 0 to ``pieces``."""
    distance = np.abs(t - np.arange(-1.0, pieces + 2).reshape(-1, *np.ones(np.ndim(t), dtype=int)))
    outer, inner = np.maximum(2 - distance, 0.0), np.maximum(1 - distance, 0.0)
    return (outer * outer * outer - 4 * (inner * inner * inner)) / 6  # a product is ten times as fast as a power


@cache
def modes(pieces: int, circle: bool) -> Array:
    """Coefficients (pieces + 3, modes) of the B-splines in each mode, from the constant on.

    The root mean square of a mode over the interval or the circle is WAVES^2 / (WAVES^2 + k^2), k its wave number.
    """
    folded = _folded(pieces) if circle else np.eye(pieces + 3)
    size, rough = (folded.T @ matrix @ folded for matrix in _products(pieces))
    root = np.linalg.inv(np.linalg.cholesky(size)).T
    energy, vectors = np.linalg.eigh(root.T @ rough @ root)
    found, squares = (
        root @ vectors,
        np.sqrt(np.maximum(energy, 0.0)),
    )  # the roughness of a wave is the fourth power of k
    found[:, 0], squares[0] = np.linalg.lstsq(folded, np.ones(pieces + 3), rcond=None)[0], 0.0
    if not circle:  # a constant and a line bend no more than each other: the line is half a wave
        line = np.arange(-1.0, pieces + 2) - pieces / 2
        found[:, 1], squares[1] = line / np.sqrt(line @ size @ line), np.pi**2
    scaled = folded @ (found * WAVES**2 / (WAVES**2 + squares))[:, : mode_count(pieces)]
    scaled.setflags(write=False)
    return scaled


@cache
def sizes(pieces: int) -> Array:
    """The root mean square (modes,) of each mode over an interval; on a circle it is about the same."""
    found = modes(pieces, False)
    return np.sqrt(np.einsum("bm,bc,cm->m", found, _products(pieces)[0], found))


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
    return (value * w) @ value.T, (bent * w) @ bent.T * pieces**4
