"""How well a motion tells effects apart, as a function of its information matrix."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.excitation.criterion.criterion import Criterion

Array = NDArray[np.float64]
RIDGE = 1e-7  # of a column's usual size squared: what lies less than this outside the rest is not counted on


@dataclass(frozen=True)
class Term:
    """Columns of one effect (``own``) beside those of its rival and whatever else is free with it (``beside``), counted
    among the columns after the baseline's."""

    own: tuple[int, ...]
    beside: tuple[int, ...]


@dataclass(frozen=True)
class Separation(Criterion):
    """-log of what neither the baseline nor the rival can imitate of an effect's columns, a mean over ``terms``.

    The first ``base`` columns are the baseline. With H the Schur complement of the rest, a term of k own columns counts
    log det H(own, beside) - log det H(beside), over 2 k: a mean of logarithms, in which no unit and no size matters.
    """

    base: int
    terms: tuple[Term, ...]

    name: ClassVar[str] = "separation"

    def values(self, G: Array) -> Array:
        H = self._outside(G)[0]
        parts = [_logdet(H, term.own + term.beside) - _logdet(H, term.beside) for term in self.terms]
        weights = [-0.5 / (len(term.own) * len(self.terms)) for term in self.terms]
        return np.tensordot(weights, np.array(parts), 1)

    def gradient(self, G: Array) -> tuple[float, Array]:
        H, X = self._outside(G)
        slope = np.zeros_like(H)
        for term in self.terms:
            weight = -0.5 / (len(term.own) * len(self.terms))
            for sign, chosen in ((1.0, term.own + term.beside), (-1.0, term.beside)):
                at = np.ix_(chosen, chosen)
                slope[at] += sign * weight * np.linalg.inv(H[at])
        outer = -X @ slope
        return float(self.values(G)), np.block([[X @ slope @ X.T, outer], [outer.T, slope]])

    def _outside(self, G: Array) -> tuple[Array, Array]:
        """H (..., c, c), the products of the columns' parts outside the baseline, and X (..., b, c), what is inside it."""
        b, size = self.base, G.shape[-1] * RIDGE
        inside = G[..., :b, b:]
        X = np.linalg.solve(G[..., :b, :b] + size * np.eye(b), inside)
        c = G.shape[-1] - b
        return G[..., b:, b:] - np.swapaxes(inside, -1, -2) @ X + size * np.eye(c), X


def _logdet(H: Array, chosen: tuple[int, ...]) -> Array:
    """log det (...) of some rows and columns of matrices (..., c, c)."""
    at = list(chosen)
    return np.linalg.slogdet(H[..., at, :][..., at])[1]
