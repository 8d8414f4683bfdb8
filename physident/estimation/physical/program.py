"""The convex program of a physical fit, through cvxpy and Clarabel: this is the only file that imports cvxpy.

The tall regressor never comes here: only its QR factor does, as a parameter of a problem that is canonicalised once
(disciplined parametrised programming), so that a refit with other data or another prior weight takes milliseconds.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import Any

import cvxpy as cp
import cvxpy.error
import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from physident.errors import NotSolvedError
from physident.estimation.physical.certificate import Multipliers, Optimality, check_optimality
from physident.estimation.physical.cones import Cones
from physident.estimation.physical.coordinates import SQUARES, TRACES, UNITS, Coordinates
from physident.estimation.physical.prior import TIE_BREAK, TIE_BREAK_OTHERS, Entropic, NoPrior, Prior
from physident.estimation.weighting import Compressed

Array = NDArray[np.float64]
TOLERANCES = (1e-9, 1e-8, 1e-7)  # asked of the solver in turn: near the tip of a cone rounding may forbid the first
GIVES = 1e-6  # by how much a contradicted bound must give, relative to its row
# primal: half the margin by which the cones are tightened, so that the answer lies inside the cones themselves; dual: a
# gap of 1e-8 leaves a gradient of its square root
PROVED = Optimality(primal=5e-7, dual=1e-3, gap=5e-6)
SIZED_NOISE = 0.5  # what the data term comes to when residuals are as large as their noise
LOWER = [(i, j) for i in range(4) for j in range(i + 1)]


@dataclass(frozen=True, eq=False)
class Answer:
    """Coordinates ``u`` (p,) of the optimum, its multipliers, its proof, and the prior's strength beside the data."""

    u: Array
    strength: float
    multipliers: Multipliers
    optimality: Optimality


class Program:
    """min |R K T u - z|^2 / (2 rows) + strength * divergence(u) over the physical cones.

    ``K`` (r, p) groups parameters to base parameters. Compiled once; ``solve`` takes the data and the strength.
    """

    def __init__(self, K: Array, coordinates: Coordinates, cones: Cones, prior: Prior) -> None:
        self.coordinates, self.cones, self.prior = coordinates, cones, prior
        self.KT = K @ coordinates.T
        self.rows, self.matrices = coordinates.rows(cones), coordinates.matrices(cones)
        self.equal = (cones.equal @ coordinates.T, cones.targets)
        self.entropic = isinstance(prior, Entropic) and len(coordinates.links) > 0
        # a log-determinant keeps its link positive definite: the cone would be stated twice
        self.held = [m.link is not None and self.entropic for m in cones.matrices]
        self.stated = [pair for pair, skip in zip(self.matrices, self.held, strict=True) if not skip]
        self._compile()

    def _compile(self) -> None:
        r, p = self.KT.shape
        self.u, b = cp.Variable(p), cp.Variable(r)
        self.R, self.z, self.strength = cp.Parameter((r, r)), cp.Parameter(r), cp.Parameter(nonneg=True)
        divergence, constraints = self._divergence()
        tie = np.full(p, np.sqrt(TIE_BREAK_OTHERS))
        for _, own in self.coordinates.links:
            tie[own] = 0.0
        objective = (
            0.5 * cp.sum_squares(self.R @ b - self.z)
            + self.strength * divergence
            + 0.5 * cp.sum_squares(cp.multiply(tie, self.u - self.coordinates.nominal))
        )
        (A, offset), (E, target) = self.rows, self.equal
        self.row_constraint: list[Any] = [sparse.csr_array(A) @ self.u + offset >= 0] if len(A) else []
        self.equal_constraint: list[Any] = [E @ self.u == target] if len(E) else []
        self.matrix_constraints = [_psd(M, self.u, B) for M, B in self.stated]
        own = [*self.row_constraint, *self.equal_constraint, *self.matrix_constraints]
        grouping = sparse.csr_array(np.where(np.abs(self.KT) > 1e-13 * np.abs(self.KT).max(), self.KT, 0.0))
        self.problem = cp.Problem(cp.Minimize(objective), [b == grouping @ self.u, *own, *constraints])

    def _divergence(self) -> tuple[cp.Expression, list[cp.Constraint]]:
        own = [k for _, link in self.coordinates.links for k in range(link.start, link.stop)]
        count = len(self.coordinates.links)
        if not count:
            return cp.Constant(0.0), []
        if not self.entropic:
            weights = np.sqrt(np.tile(SQUARES, count))
            return 0.5 * cp.sum_squares(cp.multiply(weights, (self.u - self.coordinates.nominal)[own])), []
        # log det X >= sum log diag(Z) for [[X, Z], [Z^T, diag Z]] positive semidefinite, Z lower triangular
        Z = cp.Variable(10 * count)
        diagonal = [10 * i + k for i in range(count) for k, (row, column) in enumerate(LOWER) if row == column]
        constraints = []
        for i, (_, link) in enumerate(self.coordinates.links):
            both = cp.hstack([self.u[link], Z[10 * i : 10 * i + 10]])
            constraints.append(_psd(_log_det_map(), both, np.zeros((8, 8))))
        return np.tile(TRACES, count) @ self.u[own] - cp.sum(cp.log(Z[diagonal])) - 4.0 * count, constraints

    def solve(self, data: Compressed, strength: float) -> Answer:
        """The optimum with its certificate; raises NotSolvedError where there is none, or none that can be proved."""
        scale = 1 / np.sqrt(data.rows)
        strength = TIE_BREAK if isinstance(self.prior, NoPrior) else strength
        self.R.value, self.z.value = data.R * scale, data.z * scale
        self.strength.value = strength
        status = ""
        for tolerance in TOLERANCES:
            if status != cp.OPTIMAL:
                status = self._run(tolerance)
        if status != cp.OPTIMAL or self.u.value is None:
            raise NotSolvedError(self._advice(status))
        duals = Multipliers(
            _duals(self.row_constraint),
            tuple(np.asarray(c.dual_value) for c in self.matrix_constraints),
            _duals(self.equal_constraint),
        )  # fmt: skip
        u = np.asarray(self.u.value)
        answer = Answer(u, strength, duals, self._prove(u, duals, data, strength))
        found = answer.optimality
        if not (found.primal <= PROVED.primal and found.dual <= PROVED.dual and found.gap <= PROVED.gap):
            raise NotSolvedError(
                f"the solver's answer fails its proof (violation {found.primal:.1e}, gradient {found.dual:.1e}, gap {found.gap:.1e});"
                " try another prior weight, or method='wls' to see which joint's data are at fault"
            )
        return answer

    def _run(self, tolerance: float) -> str:
        """How the solver says it ended; what its answer is worth is measured elsewhere."""
        tolerances = {"tol_gap_abs": tolerance, "tol_gap_rel": tolerance, "tol_feas": tolerance}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # an inexact answer is an error here, not a warning
            try:
                self.problem.solve(solver=cp.CLARABEL, **tolerances)
            except cvxpy.error.SolverError as error:
                return f"failed ({error})"
        return str(self.problem.status)

    def _prove(self, u: Array, duals: Multipliers, data: Compressed, strength: float) -> Optimality:
        """Residuals of the optimality conditions, from the data and the cones, without cvxpy."""
        A = data.R @ self.KT / np.sqrt(data.rows)
        residual = A @ u - data.z / np.sqrt(data.rows)
        square = residual @ residual + data.rest / data.rows
        gradient = A.T @ residual
        # noise-free data: residuals count as at least as large as the noise they are given
        sizes = np.linalg.norm(A, axis=0) * np.sqrt(max(square, 2 * SIZED_NOISE))
        objective = 0.5 * square
        away = u - self.coordinates.nominal
        for _, own in self.coordinates.links:
            if self.entropic:
                X = self.coordinates.link(u, own)
                inverse = np.linalg.inv(X)
                largest = np.eye(4) + np.sqrt(np.outer(np.diag(inverse), np.diag(inverse)))
                gradient[own] += strength * np.einsum("ij,kij->k", np.eye(4) - inverse, UNITS)
                sizes[own] += strength * np.einsum("ij,kij->k", largest, UNITS)
                objective += strength * float(np.trace(X) - np.linalg.slogdet(X)[1] - 4)
            else:
                gradient[own] += strength * SQUARES * away[own]
                sizes[own] += strength * SQUARES * (np.abs(u[own]) + TRACES)
                objective += 0.5 * strength * float(SQUARES @ away[own] ** 2)
        others = np.ones(len(u), dtype=bool)
        for _, own in self.coordinates.links:
            others[own] = False
        gradient[others] += TIE_BREAK_OTHERS * away[others]
        sizes[others] += TIE_BREAK_OTHERS * (np.abs(u) + np.abs(self.coordinates.nominal))[others]
        implied = [(M, np.zeros_like(B)) for (M, B), held in zip(self.matrices, self.held, strict=True) if held]
        every = replace(duals, matrices=(*duals.matrices, *(np.zeros((4, 4)) for _ in implied)))
        size = max(objective, strength, SIZED_NOISE)
        return check_optimality(gradient, size, sizes, self.rows, [*self.stated, *implied], self.equal, u, every)

    def _advice(self, status: str) -> str:
        if "unbounded" not in status and (names := self._contradiction()):
            return f"no arm satisfies all that is asked: {'; '.join(names)}; loosen or drop one of these bounds"
        if "unbounded" in status:
            return "the fit has no minimum (unbounded): the recordings hold values beyond all measure; inspect them"
        return f"the solver ended as {status}, not optimal; try another prior weight, or inspect the recordings"

    def _contradiction(self) -> list[str]:
        """What has to give, at the least, for the cones to meet, by an elastic program; nothing where they do meet."""
        (A, offset), (E, target) = self.rows, self.equal
        u = cp.Variable(len(self.coordinates.nominal))
        gives, constraints, labels = [], [], []
        if len(A):
            gives.append(cp.Variable(len(A), nonneg=True))
            constraints.append(A @ u + offset + gives[-1] >= 0)
        if len(E):
            gives.append(cp.Variable(len(E), nonneg=True))
            constraints.append(cp.abs(E @ u - target) <= gives[-1])
        labels += self.cones.labels
        for matrix, (M, B) in zip(self.cones.matrices, self.matrices, strict=True):
            gives.append(cp.Variable(1, nonneg=True))
            constraints.append(_psd(M, u, B, gives[-1]))
            labels.append(matrix.label)
        elastic = cp.Problem(cp.Minimize(cp.sum(cp.hstack(gives))), constraints)
        elastic.solve(solver=cp.CLARABEL)
        if elastic.status != cp.OPTIMAL:
            return []
        sizes = np.concatenate([np.ravel(np.asarray(give.value)) for give in gives])
        names = [label for label, size in zip(labels, sizes, strict=True) if size > GIVES]
        return list(dict.fromkeys(names))


def _duals(constraints: list[Any]) -> Array:
    """The multipliers of one vector constraint, or none."""
    return np.concatenate([np.zeros(0), *(np.ravel(c.dual_value) for c in constraints)])


def _psd(M: Array, x: cp.Expression, B: Array, give: cp.Expression | float = 0.0) -> cp.Constraint:
    """The constraint that M x + B + give 1 is positive semidefinite, from M (d, d, k)."""
    flat = sparse.csr_array(M.reshape(-1, M.shape[2]))
    return cp.reshape(flat @ x, B.shape, order="C") + B + give * np.eye(len(B)) >> 0


def _log_det_map() -> Array:
    """(8, 8, 20): the matrix [[X, Z], [Z^T, diag Z]] of ten coordinates of X and ten of a lower triangle Z."""
    M = np.zeros((8, 8, 20))
    M[:4, :4, :10] = np.moveaxis(UNITS, 0, 2)
    for k, (i, j) in enumerate(LOWER):
        M[i, 4 + j, 10 + k] = M[4 + j, i, 10 + k] = 1.0
        if i == j:
            M[4 + i, 4 + i, 10 + k] = 1.0
    return M
