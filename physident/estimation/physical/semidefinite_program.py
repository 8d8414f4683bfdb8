"""The semidefinite program (SDP) of a physical fit, stated in cvxpy and solved by Clarabel.

The tall regressor never comes here. Only its QR factor does, as a parameter of a program that is canonicalised once
(disciplined parametrised programming), so that a refit with other data or another prior weight takes milliseconds.
"""

from __future__ import annotations

import warnings
from typing import Any

import cvxpy as cp
import cvxpy.error
import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from physident.errors import NotSolvedError
from physident.estimation.physical.certificate import Multipliers, Optimality
from physident.estimation.physical.coordinates import SQUARES, TRACES, UNITS
from physident.estimation.physical.prior import TIE_BREAK, TIE_BREAK_OTHERS, NoPrior
from physident.estimation.physical.problem import Answer, PhysicalProblem
from physident.estimation.weighting import Compressed

Array = NDArray[np.float64]
# tried in turn: near the tip of a cone, rounding may rule out the first tolerance; without the solver's own scaling and
# with steps that stay farther from the cones' boundary, an answer on many of them at once can still be proved
SETTINGS: tuple[dict[str, Any], ...] = (
    *({"tol_gap_abs": t, "tol_gap_rel": t, "tol_feas": t} for t in (1e-9, 1e-8, 1e-7)),
    {"tol_gap_abs": 1e-9, "tol_gap_rel": 1e-9, "tol_feas": 1e-9, "equilibrate_enable": False, "max_step_fraction": 0.9},
    {
        "tol_gap_abs": 1e-8,
        "tol_gap_rel": 1e-8,
        "tol_feas": 1e-8,
        "static_regularization_constant": 1e-11,
        "max_step_fraction": 0.9,
        "max_iter": 500,
    },
)
MIN_GIVE = 1e-6  # relative to its row: a constraint that must give by more is in conflict
# primal: half the margin by which the cones are tightened, so that the answer lies inside the cones themselves; dual: a
# gap of 1e-8 leaves a gradient of its square root
REQUIRED = Optimality(primal=5e-7, dual=1e-3, gap=5e-6)
LOWER = [(i, j) for i in range(4) for j in range(i + 1)]


class SemidefiniteProgram:
    """A ``PhysicalProblem``, compiled once for any data and strength of its prior; see ``solve``."""

    def __init__(self, problem: PhysicalProblem) -> None:
        self.problem = problem
        self.proven = 0  # the setting whose answer was proved last
        r, p = problem.KT.shape
        self.u, b = cp.Variable(p), cp.Variable(r)
        self.R, self.z, self.strength = cp.Parameter((r, r)), cp.Parameter(r), cp.Parameter(nonneg=True)
        divergence, divergence_constraints = self._divergence()
        tie_break = np.where(problem.other_coordinates, np.sqrt(TIE_BREAK_OTHERS), 0.0)
        objective = (
            0.5 * cp.sum_squares(self.R @ b - self.z)
            + self.strength * divergence
            + 0.5 * cp.sum_squares(cp.multiply(tie_break, self.u - problem.coordinates.nominal))
        )
        (A, offset), (E, target) = problem.rows, problem.equalities
        self.row_constraint: list[Any] = [sparse.csr_array(A) @ self.u + offset >= 0] if len(A) else []
        self.equal_constraint: list[Any] = [E @ self.u == target] if len(E) else []
        self.matrix_constraints = [_semidefinite(M, self.u, B) for M, B in problem.explicit_matrices]
        constraints = [*self.row_constraint, *self.equal_constraint, *self.matrix_constraints]
        grouping = sparse.csr_array(np.where(np.abs(problem.KT) > 1e-13 * np.abs(problem.KT).max(), problem.KT, 0.0))
        self.program = cp.Problem(
            cp.Minimize(objective), [b == grouping @ self.u, *constraints, *divergence_constraints]
        )

    def _divergence(self) -> tuple[cp.Expression, list[cp.Constraint]]:
        """The prior's divergence from the nominal links, and the constraints that define it."""
        links = self.problem.coordinates.links
        places = [k for _, link in links for k in range(link.start, link.stop)]
        count = len(links)
        if not count:
            return cp.Constant(0.0), []
        if not self.problem.entropic:
            weights = np.sqrt(np.tile(SQUARES, count))
            return 0.5 * cp.sum_squares(cp.multiply(weights, (self.u - self.problem.coordinates.nominal)[places])), []
        # log det X >= sum log diag(Z) for [[X, Z], [Z^T, diag Z]] positive semidefinite, Z lower triangular
        Z = cp.Variable(10 * count)
        diagonal = [10 * i + k for i in range(count) for k, (row, column) in enumerate(LOWER) if row == column]
        constraints = []
        for i, (_, link) in enumerate(links):
            both = cp.hstack([self.u[link], Z[10 * i : 10 * i + 10]])
            constraints.append(_semidefinite(_log_det_map(), both, np.zeros((8, 8))))
        return np.tile(TRACES, count) @ self.u[places] - cp.sum(cp.log(Z[diagonal])) - 4.0 * count, constraints

    def solve(self, data: Compressed, strength: float) -> Answer:
        """The optimum for some data and strength of the prior, with its proof.

        Raises NotSolvedError where the problem has no optimum, or the solver's answer fails its proof.
        """
        scale = 1 / np.sqrt(data.rows)
        strength = TIE_BREAK if isinstance(self.problem.prior, NoPrior) else strength
        if not (np.isfinite(data.R).all() and np.isfinite(data.z).all()):  # cvxpy's own answer depends on its version
            raise NotSolvedError(self._advice("unbounded"))
        self.R.value, self.z.value = data.R * scale, data.z * scale
        self.strength.value = strength
        reason = ""
        settings = sorted(range(len(SETTINGS)), key=lambda k: k != self.proven)  # what served last is tried first
        for k in settings:  # an answer that fails its proof is as good as none
            status = self._run(SETTINGS[k])
            if status not in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE) or self.u.value is None:  # its proof decides
                reason = reason or self._advice(status)
                continue
            u, multipliers = np.asarray(self.u.value), self._multipliers()
            found = self.problem.optimality(u, multipliers, data, strength)
            if found.primal <= REQUIRED.primal and found.dual <= REQUIRED.dual and found.gap <= REQUIRED.gap:
                self.proven = k
                return Answer(u, strength, multipliers, found)
            reason = (
                f"the solver's answer fails its proof (violation {found.primal:.1e}, gradient {found.dual:.1e}, gap {found.gap:.1e});"
                " try another prior weight, or method='wls' to see which joint's data are at fault"
            )
        raise NotSolvedError(reason)

    def _multipliers(self) -> Multipliers:
        return Multipliers(
            rows=_duals(self.row_constraint),
            matrices=tuple(np.asarray(c.dual_value) for c in self.matrix_constraints),
            equalities=_duals(self.equal_constraint),
        )

    def _run(self, setting: dict[str, Any]) -> str:
        """The status that the solver reports; its answer is checked elsewhere."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # an inexact answer is an error here, not a warning
            try:
                self.program.solve(solver=cp.CLARABEL, **setting)
            except cvxpy.error.SolverError as error:
                return f"failed ({error})"
        return str(self.program.status)

    def _advice(self, status: str) -> str:
        if "unbounded" in status:
            return "the fit has no minimum (unbounded): the recordings contain extremely large values; inspect them"
        if names := conflicting_constraints(self.problem):
            return f"no arm satisfies all constraints: {'; '.join(names)}; loosen or drop one of these bounds"
        return (
            f"the solver ended with status {status}, not optimal; try another prior weight, or inspect the recordings"
        )


def conflicting_constraints(problem: PhysicalProblem) -> list[str]:
    """Labels of the constraints that must give so that all can be met, by an elastic program; empty where they can be met."""
    (A, offset), (E, target) = problem.rows, problem.equalities
    u = cp.Variable(len(problem.coordinates.nominal))
    gives, constraints, labels = [], [], list(problem.cones.labels)
    if len(A):
        gives.append(cp.Variable(len(A), nonneg=True))
        constraints.append(A @ u + offset + gives[-1] >= 0)
    if len(E):
        gives.append(cp.Variable(len(E), nonneg=True))
        constraints.append(cp.abs(E @ u - target) <= gives[-1])
    for inequality, (M, B) in zip(problem.cones.matrices, problem.matrices, strict=True):
        gives.append(cp.Variable(1, nonneg=True))
        constraints.append(_semidefinite(M, u, B, gives[-1]))
        labels.append(inequality.label)
    elastic = cp.Problem(cp.Minimize(cp.sum(cp.hstack(gives))), constraints)
    elastic.solve(solver=cp.CLARABEL)
    if elastic.status != cp.OPTIMAL:
        return []
    sizes = np.concatenate([np.ravel(np.asarray(give.value)) for give in gives])
    names = [label for label, size in zip(labels, sizes, strict=True) if size > MIN_GIVE]
    return list(dict.fromkeys(names))


def _duals(constraints: list[Any]) -> Array:
    """The multipliers of one vector constraint, or none."""
    return np.concatenate([np.zeros(0), *(np.ravel(c.dual_value) for c in constraints)])


def _semidefinite(M: Array, x: cp.Expression, B: Array, give: cp.Expression | float = 0.0) -> cp.Constraint:
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
