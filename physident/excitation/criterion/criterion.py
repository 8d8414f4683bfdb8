"""What a good excitation is: functions of the information matrix G = sum_k Y_k^T Y_k of a motion, with their gradients.

G is symmetric and positive semidefinite; every criterion is to be made small.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError

Array = NDArray[np.float64]
FLOOR = 1e-13  # of the largest eigenvalue: below, rounding decides


class Criterion(ABC):
    """A function of the information matrix (r, r), small where a motion excites every parameter."""

    name: ClassVar[str]

    @abstractmethod
    def values(self, G: Array) -> Array:
        """Values (...) of information matrices (..., r, r)."""

    @abstractmethod
    def gradient(self, G: Array) -> tuple[float, Array]:
        """The value that is made small and its symmetric gradient (r, r) at one information matrix."""


@dataclass(frozen=True)
class Condition(Criterion):
    """log cond(Y), Y the stacked regressor; thesis eq. 3.59 with cond(Y)^2 = cond(Y^T Y).

    The largest and the smallest singular value s are not smooth where two meet: the gradient is that of their soft
    counterparts (log sum s^p - log sum s^-p) / p, which bound the logarithm of the condition number from above. ``sharpness`` p.
    """

    sharpness: float = 30.0

    name: ClassVar[str] = "condition"

    def values(self, G: Array) -> Array:
        size = _eigenvalues(G)
        return 0.5 * np.log(size[..., -1] / size[..., 0])

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
    """-log det(G) / (2 r): the volume of the parameters' confidence ellipsoid, as a mean over parameters."""

    name: ClassVar[str] = "d_optimal"

    def values(self, G: Array) -> Array:
        return -0.5 * np.log(_eigenvalues(G)).mean(axis=-1)

    def gradient(self, G: Array) -> tuple[float, Array]:
        size, vectors = _decomposed(G)
        return -0.5 * float(np.log(size).mean()), -(vectors * (0.5 / (len(size) * size))) @ vectors.T


@dataclass(frozen=True)
class AOptimal(Criterion):
    """log(trace(G^-1) / r) / 2: the parameters' mean square error, as the logarithm of its root."""

    name: ClassVar[str] = "a_optimal"

    def values(self, G: Array) -> Array:
        return 0.5 * np.log((1 / _eigenvalues(G)).mean(axis=-1))

    def gradient(self, G: Array) -> tuple[float, Array]:
        size, vectors = _decomposed(G)
        total = float((1 / size).sum())
        return 0.5 * float(np.log(total / len(size))), -(vectors * (0.5 / (total * size**2))) @ vectors.T


CRITERIA: dict[str, type[Criterion]] = {c.name: c for c in (Condition, DOptimal, AOptimal)}


def make_criterion(criterion: str) -> Criterion:
    """The criterion of a name; raises InputError for an unknown one."""
    if criterion not in CRITERIA:
        raise InputError(f"criterion is {criterion!r}, expected one of {', '.join(CRITERIA)}")
    return CRITERIA[criterion]()


def _eigenvalues(G: Array) -> Array:
    size = np.linalg.eigvalsh(G)
    return np.maximum(size, FLOOR * np.maximum(size[..., -1:], 1e-300))


def _decomposed(G: Array) -> tuple[Array, Array]:
    size, vectors = np.linalg.eigh(G)
    return np.maximum(size, FLOOR * max(float(size[-1]), 1e-300)), vectors
