"""The proof of an estimate, computed from the problem and the cones alone: feasible, stationary, complementary.

What a solver reports about itself is not used. With f convex, f(u) - sum <multiplier, cone value> is a lower bound of the
optimum once the gradient of the Lagrangian vanishes, so that complementarity is the duality gap.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.estimation.uncertainty import RANK_TOLERANCE

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """What is proved about an estimate.

    ``stationarity``: largest gradient of the Lagrangian relative to the size of its terms (dual residual); ``primal``:
    largest violation of a cone relative to the size of its terms; ``gap``: duality gap relative to the objective or,
    where that is larger, to the size of its terms; ``eigenvalues``: smallest eigenvalue of each link's pseudo-inertia
    over the largest. ``condition`` number of the scaled regressor, without directions that nothing decides; ``determined``: number of base parameters that the
    data determine; ``iterations`` of the estimator.
    """

    stationarity: float
    condition: float
    determined: int
    iterations: int
    primal: float = 0.0
    gap: float = 0.0
    eigenvalues: tuple[float, ...] = ()


def condition_number(singular: NDArray[np.floating]) -> float:
    """The largest over the smallest singular value (k,), which come in descending order, of those that rounding does not decide."""
    return float(singular[0] / singular[singular > RANK_TOLERANCE * singular[0]][-1]) if singular.any() else 1.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Optimality:
    """Residuals of the optimality conditions at one answer, each relative to the size of its terms."""

    primal: float
    dual: float
    gap: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Multipliers:
    """Dual variables: ``rows`` (m,) >= 0, positive semidefinite ``matrices``, ``equalities`` (k,) of either sign."""

    rows: Array
    matrices: tuple[Array, ...]
    equalities: Array

    def projected(self) -> Multipliers:
        """The nearest multipliers inside the dual cones; a solver's own may lie slightly outside."""
        matrices = []
        for matrix in self.matrices:
            values, vectors = np.linalg.eigh((matrix + matrix.T) / 2)
            matrices.append((vectors * np.maximum(values, 0.0)) @ vectors.T)
        return Multipliers(rows=np.maximum(self.rows, 0.0), matrices=tuple(matrices), equalities=self.equalities)


def check_optimality(
    *,
    u: Array,
    multipliers: Multipliers,
    gradient: Array,
    gradient_sizes: Array,
    objective: float,
    rows: tuple[Array, Array],
    matrices: list[tuple[Array, Array]],
    equalities: tuple[Array, Array],
) -> Optimality:
    """Residuals of min f(u) subject to A u + b >= 0, M_i u + B_i positive semidefinite, E u = t.

    ``gradient`` (p,) of f at ``u`` and ``gradient_sizes`` (p,), the size of the terms of each component; ``objective``:
    the size of the terms of f(u). ``rows`` (A, b), ``matrices`` [(M_i, B_i)], ``equalities`` (E, t). Coordinates are of
    order one, so violations are relative to at least one.
    """
    y = multipliers.projected()
    (A, b), (E, t) = rows, equalities
    slack = A @ u + b
    primal = [-slack / np.maximum(np.abs(A) @ np.abs(u) + np.abs(b), 1.0)]
    primal.append(np.abs(E @ u - t) / np.maximum(np.abs(E) @ np.abs(u) + np.abs(t), 1.0))
    lagrangian = gradient - A.T @ y.rows + E.T @ y.equalities
    sizes = gradient_sizes + np.abs(A).T @ y.rows + np.abs(E).T @ np.abs(y.equalities)
    gap = float(y.rows @ slack)
    for (M, B), Y in zip(matrices, y.matrices, strict=True):
        S = M @ u + B
        values = np.linalg.eigvalsh(S)
        primal.append(-values[:1] / max(np.abs(values).max(), 1.0))
        lagrangian = lagrangian - np.einsum("ijp,ij->p", M, Y)
        sizes = sizes + np.einsum("ijp,ij->p", np.abs(M), np.abs(Y))
        gap += float(np.sum(S * Y))
    return Optimality(
        primal=float(np.concatenate([np.ravel(x) for x in primal]).max(initial=0.0)),
        dual=float((np.abs(lagrangian) / np.maximum(sizes, 1e-300)).max()),
        gap=abs(gap) / max(abs(objective), 1e-300),
    )
