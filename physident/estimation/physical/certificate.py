"""The proof of an estimate, computed from the problem and the cones alone: feasible, stationary, complementary.

Whatever a solver says of itself is not asked. With f convex, f(u) - sum <multiplier, cone value> bounds the optimum
from below once the Lagrangian's gradient vanishes, so that complementarity is the duality gap.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Certificate:
    """What is proved about an answer.

    ``stationarity``: the largest gradient left of the Lagrangian over the size of its terms (dual residual); ``primal``:
    the largest violation of a cone over the size of its terms; ``gap``: duality gap over the objective or, where that is larger, the size of its terms; ``eigenvalues``:
    the smallest of each link's pseudo-inertia over the largest. ``condition`` of the scaled regressor; ``determined``:
    how many base parameters the data decided; ``iterations`` of the estimator.
    """

    stationarity: float
    condition: float
    determined: int
    iterations: int
    primal: float = 0.0
    gap: float = 0.0
    eigenvalues: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class Optimality:
    """Residuals of the optimality conditions at one answer, each relative to the size of its terms."""

    primal: float
    dual: float
    gap: float


@dataclass(frozen=True, eq=False)
class Multipliers:
    """Dual witnesses: ``rows`` (m,) >= 0, positive semidefinite ``matrices``, ``equal`` (k,) of either sign."""

    rows: Array
    matrices: tuple[Array, ...]
    equal: Array

    def projected(self) -> Multipliers:
        """The nearest multipliers that lie in the dual cones: what a solver returned need not, exactly."""
        matrices = []
        for matrix in self.matrices:
            values, vectors = np.linalg.eigh((matrix + matrix.T) / 2)
            matrices.append((vectors * np.maximum(values, 0.0)) @ vectors.T)
        return Multipliers(np.maximum(self.rows, 0.0), tuple(matrices), self.equal)


def check_optimality(
    gradient: Array,
    objective: float,
    sizes: Array,
    rows: tuple[Array, Array],
    matrices: list[tuple[Array, Array]],
    equal: tuple[Array, Array],
    u: Array,
    multipliers: Multipliers,
) -> Optimality:
    """Residuals of min f(u) subject to A u + b >= 0, M_i u + B_i positive semidefinite, E u = t.

    Coordinates are of order one, so that violations are relative to at least that. ``gradient`` (p,) of f at ``u`` and its ``sizes`` (p,), what each component could at most be; ``objective``, the size of f(u)'s terms;
    ``rows`` (A, b), ``matrices`` [(M_i, B_i)], ``equal`` (E, t).
    """
    y = multipliers.projected()
    (A, b), (E, t) = rows, equal
    slack = A @ u + b
    primal = [-slack / np.maximum(np.abs(A) @ np.abs(u) + np.abs(b), 1.0)]
    primal.append(np.abs(E @ u - t) / np.maximum(np.abs(E) @ np.abs(u) + np.abs(t), 1.0))
    left = gradient - A.T @ y.rows + E.T @ y.equal
    size = sizes + np.abs(A).T @ y.rows + np.abs(E).T @ np.abs(y.equal)
    gap = float(y.rows @ slack)
    for (M, B), Y in zip(matrices, y.matrices, strict=True):
        S = M @ u + B
        values = np.linalg.eigvalsh(S)
        primal.append(-values[:1] / max(np.abs(values).max(), 1.0))
        left = left - np.einsum("ijp,ij->p", M, Y)
        size = size + np.einsum("ijp,ij->p", np.abs(M), np.abs(Y))
        gap += float(np.sum(S * Y))
    return Optimality(
        float(np.concatenate([np.ravel(x) for x in primal]).max(initial=0.0)),
        float((np.abs(left) / np.maximum(size, 1e-300)).max()),
        abs(gap) / max(abs(objective), 1e-300),
    )
