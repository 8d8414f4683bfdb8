"""Physically consistent drive gains: the same equations, with each linearisation solved over the physical cones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.effects.effect import Column, Effect
from physident.errors import NotSolvedError
from physident.estimation.drive_gains.equations import LONGEST_STEP, GainEquations, GainSolution
from physident.estimation.payload.load_regressor import load_columns, solid_load
from physident.estimation.physical.cones import Cones, MatrixInequality, physical_cones
from physident.estimation.physical.coordinates import Coordinates
from physident.estimation.physical.prior import NoPrior
from physident.estimation.physical.problem import PhysicalProblem
from physident.estimation.physical.semidefinite_program import SemidefiniteProgram
from physident.estimation.weighting import Compressed
from physident.robots.inertia import pseudo_inertia
from physident.robots.robot import Robot

Array = NDArray[np.float64]
MAX_ITERATIONS = 50
SETTLED = 1e-5  # largest change of a gain's logarithm, limited by the solver's accuracy


def solve_on_cones(
    equations: GainEquations, robot: Robot, effects: Sequence[Effect], start: GainSolution
) -> GainSolution:
    """Gauss-Newton from ``start``; raises NotSolvedError where it does not settle or a step cannot be proved optimal."""
    p, r, n = len(equations.base.columns), equations.base.r, robot.n
    gains = tuple(Column(f"drive_gain_{j}", "-", j, "drive_gain") for j in range(1, n + 1))
    columns = (*equations.base.columns, *load_columns(n + 1), *gains)
    arm_nominal = np.concatenate([effect.nominal(robot) for effect in effects])
    nominal = np.concatenate([arm_nominal, solid_load(start.load[0], start.load[1:4]), np.zeros(n)])
    K = np.zeros((r + 10 + n, len(columns)))
    K[:r, :p], K[r:, p:] = equations.base.grouping, np.eye(10 + n)
    coordinates, cones = Coordinates.around(nominal, columns), _cones(robot, effects, equations.mass)
    program = SemidefiniteProgram(PhysicalProblem(K, coordinates, cones, NoPrior()))
    solution = start
    for _ in range(MAX_ITERATIONS):
        u = program.solve(_data(equations, solution), 0.0).u
        b = K @ coordinates.T @ u
        step = np.concatenate([np.delete(b[: r + 10], r) - solution.x, b[r + 10 :]])
        longest = float(np.abs(step[equations.size :]).max())
        solution = equations.after_step(solution, step * min(1.0, LONGEST_STEP / longest))
        if longest < SETTLED:
            return solution
    raise NotSolvedError(f"physical drive gains did not settle in {MAX_ITERATIONS} iterations; use method tls")


def _data(equations: GainEquations, solution: GainSolution) -> Compressed:
    """The linearised equations in the unknowns themselves: base parameters, the load's ten, the step of log gains."""
    A, b = equations.linearised(solution)
    r = equations.base.r
    b = b + A[:, : equations.size] @ solution.x
    A = np.insert(A, r, 0.0, axis=1)  # the mass is known: its torque is on the other side already
    R = np.linalg.qr(np.column_stack([A, b]), mode="r")
    k = A.shape[1]
    factor = np.zeros((k + 1, k + 1))
    factor[: len(R)] = R[: k + 1]
    return Compressed(factor[:k, :k], factor[:k, k], float(factor[k, k] ** 2), equations.regressor.torque.size)


def _cones(robot: Robot, effects: Sequence[Effect], mass: float) -> Cones:
    """The arm's cones; the load is a rigid body of the known mass, the gains are free."""
    arm = physical_cones(robot, effects)
    p = arm.rows.shape[1]
    total = p + 10 + robot.n

    def wide(block: Array) -> Array:
        return np.concatenate([block, np.zeros((*block.shape[:-1], total - p))], axis=-1)

    load = np.zeros((4, 4, total))
    load[:, :, p : p + 10] = np.stack([pseudo_inertia(unit) for unit in np.eye(10)], axis=-1)
    matrices = [MatrixInequality(wide(m.map), m.offset, m.label, m.link) for m in arm.matrices]
    matrices.append(MatrixInequality(load, np.zeros((4, 4)), "the load is not a rigid body", robot.n + 1))
    known = np.zeros((1, total))
    known[0, p] = 1.0
    labels = (*arm.labels, "the load's mass differs from the known one")
    return Cones(
        rows=wide(arm.rows),
        offsets=arm.offsets,
        matrices=tuple(matrices),
        equal=known,
        targets=np.array([mass]),
        labels=labels,
    )
