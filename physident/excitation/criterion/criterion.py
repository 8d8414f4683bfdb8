"""Criteria of a good motion: functions of its information matrix G = sum_k Y_k^T Y_k, with their gradients.

G is symmetric and positive semidefinite. Every criterion is minimised.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError, did_you_mean

Array = NDArray[np.float64]
FLOOR = 1e-13  # of the largest eigenvalue: smaller ones are rounding


class Criterion(ABC):
    """A function of the information matrix (r, r), small for a motion that excites every parameter."""

    name: ClassVar[str]

    @abstractmethod
    def values(self, G: Array) -> Array:
        """Values (...) of information matrices (..., r, r)."""

    @abstractmethod
    def gradient(self, G: Array) -> tuple[float, Array]:
        """The value that a solver minimises, and its symmetric gradient (r, r), at one information matrix."""


@dataclass(frozen=True)
class Condition(Criterion):
    """log cond(Y), Y the stacked regressor; thesis eq. 3.59 with cond(Y)^2 = cond(Y^T Y).

    Where two singular values s meet, the largest and the smallest one are not smooth. The gradient is therefore that of
    (log sum s^p - log sum s^-p) / p with ``sharpness`` p, an upper bound of the logarithm of the condition number.
    """

    sharpness: float = 30.0

    name: ClassVar[str] = "condition"

    def values(self, G: Array) -> Array:
        eigenvalues = _eigenvalues(G)
        return 0.5 * np.log(eigenvalues[..., -1] / eigenvalues[..., 0])

    def gradient(self, G: Array) -> tuple[float, Array]:
        size, vectors = _decomposed(G)
        p = self.sharpness
        high, low = 0.5 * p * np.log(size), -0.5 * p * np.log(size)
        large, small = np.exp(high - high.max()), np.exp(low - low.max())
        value = (high.max() + np.log(large.sum()) + low.max() + np.log(small.sum())) / p
        slope = 0.5 * (large / large.sum() - small / small.sum()) / size
        return float(value), (vectors * slope) @ vectors.T


@dataclass(frozen=True)
class DOptimal(Criterion):
    """-log det(G) / (2 r): the logarithm of the confidence ellipsoid's volume, as a mean over parameters."""

    name: ClassVar[str] = "d_optimal"

    def values(self, G: Array) -> Array:
        return -0.5 * np.log(_eigenvalues(G)).mean(axis=-1)

    def gradient(self, G: Array) -> tuple[float, Array]:
        size, vectors = _decomposed(G)
        return -0.5 * float(np.log(size).mean()), -(vectors * (0.5 / (len(size) * size))) @ vectors.T


@dataclass(frozen=True)
class AOptimal(Criterion):
    """log(trace(G^-1) / r) / 2: the logarithm of the parameters' root mean square error."""

    name: ClassVar[str] = "a_optimal"

    def values(self, G: Array) -> Array:
        return 0.5 * np.log((1 / _eigenvalues(G)).mean(axis=-1))

    def gradient(self, G: Array) -> tuple[float, Array]:
        size, vectors = _decomposed(G)
        total = float((1 / size).sum())
        return 0.5 * float(np.log(total / len(size))), -(vectors * (0.5 / (total * size**2))) @ vectors.T


CRITERIA: dict[str, type[Criterion]] = {c.name: c for c in (Condition, DOptimal, AOptimal)}


def make_criterion(criterion: str) -> Criterion:
    """The criterion with a name of ``CRITERIA``; raises InputError for an unknown name."""
    if criterion not in CRITERIA:
        raise InputError(
            f"criterion is {criterion!r}, expected one of {', '.join(CRITERIA)}{did_you_mean(criterion, CRITERIA)}"
        )
    return CRITERIA[criterion]()


def _eigenvalues(G: Array) -> Array:
    size = np.linalg.eigvalsh(G)
    return np.maximum(size, FLOOR * np.maximum(size[..., -1:], 1e-300))


def _decomposed(G: Array) -> tuple[Array, Array]:
    size, vectors = np.linalg.eigh(G)
    return np.maximum(size, FLOOR * max(float(size[-1]), 1e-300)), vectors
