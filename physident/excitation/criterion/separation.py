"""How well a motion separates two effects, as a function of its information matrix."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.excitation.criterion.criterion import Criterion

Array = NDArray[np.float64]
RIDGE = 1e-7  # of a column's mean square: a smaller part outside the other columns counts as zero


@dataclass(frozen=True)
class Term:
    """The columns of one ``effect`` and those of its ``rival``, as indices after the baseline's columns."""

    effect: tuple[int, ...]
    rival: tuple[int, ...]


@dataclass(frozen=True)
class Separation(Criterion):
    """-log of the part of an effect's columns that neither the baseline nor the rival can imitate, a mean over ``terms``.

    The first ``baseline`` columns are the baseline. With H the Schur complement of the other columns, a term whose effect
    has k columns is (log det H(effect, rival) - log det H(rival)) / (2 k). A mean of logarithms does not depend on units.
    """

    baseline: int
    terms: tuple[Term, ...]

    name: ClassVar[str] = "separation"

    def values(self, G: Array) -> Array:
        H = self._outside(G)[0]
        parts = [_logdet(H, term.effect + term.rival) - _logdet(H, term.rival) for term in self.terms]
        weights = [-0.5 / (len(term.effect) * len(self.terms)) for term in self.terms]
        return np.tensordot(weights, np.array(parts), 1)

    def gradient(self, G: Array) -> tuple[float, Array]:
        H, X = self._outside(G)
        slope = np.zeros_like(H)
        for term in self.terms:
            weight = -0.5 / (len(term.effect) * len(self.terms))
            for sign, chosen in ((1.0, term.effect + term.rival), (-1.0, term.rival)):
                at = np.ix_(chosen, chosen)
                slope[at] += sign * weight * np.linalg.inv(H[at])
        outer = -X @ slope
        return float(self.values(G)), np.block([[X @ slope @ X.T, outer], [outer.T, slope]])

    def _outside(self, G: Array) -> tuple[Array, Array]:
        """H (..., c, c), the products of the columns' parts outside the baseline, and X (..., b, c), the baseline's part."""
        b, size = self.baseline, G.shape[-1] * RIDGE
        inside = G[..., :b, b:]
        X = np.linalg.solve(G[..., :b, :b] + size * np.eye(b), inside)
        c = G.shape[-1] - b
        return G[..., b:, b:] - np.swapaxes(inside, -1, -2) @ X + size * np.eye(c), X


def _logdet(H: Array, chosen: tuple[int, ...]) -> Array:
    """log det (...) of some rows and columns of matrices (..., c, c)."""
    at = list(chosen)
    return np.linalg.slogdet(H[..., at, :][..., at])[1]
