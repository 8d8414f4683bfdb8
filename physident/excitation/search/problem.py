"""The nonlinear program of a design: a criterion of a motion, minimised within limits, and its solutions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.excitation.criterion.criterion import Condition, Criterion
from physident.excitation.criterion.information import Information
from physident.excitation.limits.constraints import Constraints, join
from physident.excitation.limits.joint_limits import JointLimits
from physident.excitation.limits.workspace import Workspace
from physident.excitation.limits.workspace_constraints import NODES as WORKSPACE_NODES
from physident.excitation.limits.workspace_constraints import workspace_constraints
from physident.excitation.motion.series import Series
from physident.excitation.search.ipopt import minimise

Array = NDArray[np.float64]
VIOLATION_COST = 20.0  # in units of the criterion, for a violation as large as the limit itself
TOLERANCE = 1e-5  # relative: violation that IPOPT may leave
NEAR_LIMIT = 0.6  # of a limit: constraints with more slack are left out of a stage, and checked after it
MAX_ROUNDS = 4  # of adding constraints that were left out
PENALTY_RESERVE = 0.02  # of a limit: the penalty begins before the limit is reached
JOINT_NODES = 96  # instants of a period for joint limits; those of five harmonics are then tightened by 1.3 %


@dataclass(frozen=True)
class Stage:
    """One run of IPOPT.

    ``sharpness`` of the soft condition number, and the largest number of ``iterations``. ``penalty`` is the weight of a
    penalty on violations of the workspace's limits; None makes these limits constraints.
    """

    sharpness: float
    iterations: int
    penalty: float | None = None


@dataclass(frozen=True, eq=False)
class Solution:
    """A motion that the search found.

    ``y`` (n m,) are its free numbers, ``value`` is the criterion's, ``violation`` the largest relative limit violation, and
    ``cost`` the criterion with that violation's cost. ``iterates`` are the free numbers after each iteration up to here.
    """

    y: Array
    value: float
    violation: float
    cost: float
    iterates: tuple[Array, ...] = ()

    @property
    def feasible(self) -> bool:
        """Whether every limit holds."""
        return self.violation <= TOLERANCE


@dataclass(frozen=True, eq=False)
class Problem:
    """Find the motion of a ``series`` that minimises a ``criterion`` of its ``information`` within all limits.

    ``coarse`` is the information on fewer instants, for the genetic algorithm. ``workspace`` is None where only the
    ``joints``' limits count.
    """

    series: Series
    criterion: Criterion
    information: Information
    coarse: Information
    joints: JointLimits
    workspace: Workspace | None

    @cached_property
    def joint_constraints(self) -> Constraints:
        """The limits of the joints."""
        return self.joints.constraints(self.series, max(JOINT_NODES, 12 * self.series.harmonics))

    @cached_property
    def workspace_constraints(self) -> Constraints | None:
        """The limits of the workspace."""
        return None if self.workspace is None else workspace_constraints(self.workspace, self.series)

    @cached_property
    def constraints(self) -> Constraints:
        """All limits, those of the joints first."""
        if self.workspace_constraints is None:
            return self.joint_constraints
        return join(self.joint_constraints, self.workspace_constraints)

    def objective(self, y: Array, stage: Stage) -> tuple[float, Callable[[], Array]]:
        """What a stage minimises at free numbers (n m,), and a function that returns its gradient."""
        criterion = self.criterion
        if isinstance(criterion, Condition):
            criterion = replace(criterion, sharpness=stage.sharpness)
        value, slope = criterion.gradient(self.information.matrix(y))
        if self.workspace_constraints is None or stage.penalty is None:
            return value, lambda: self.information.pullback(y, slope)
        penalty, penalty_slope = self.workspace_constraints.penalty(y, PENALTY_RESERVE)
        weight = stage.penalty / WORKSPACE_NODES
        return value + weight * penalty, lambda: self.information.pullback(y, slope) + weight * penalty_slope

    def improve(self, start: Solution, stage: Stage) -> Solution:
        """The solution after a stage, with its iterates, or the start where the stage did not improve it."""
        iterates: list[Array] = []
        if stage.penalty is not None or self.workspace_constraints is None:
            y = minimise(
                lambda at: self.objective(at, stage), self.joint_constraints, start.y, stage.iterations, iterates.append
            )
        else:
            y = self._minimise_constrained(start.y, stage, iterates.append)
        return min(start, self.solution(y, (*start.iterates, *iterates)), key=lambda one: one.cost)

    def solution(self, y: Array, iterates: tuple[Array, ...] = ()) -> Solution:
        """The solution at free numbers (n m,): its criterion and its violation."""
        value = float(self.criterion.values(self.information.matrix(y)))
        violation = self.constraints.violation(y)
        return Solution(y, value, violation, value + VIOLATION_COST * max(0.0, violation - TOLERANCE), iterates)

    def _minimise_constrained(self, y: Array, stage: Stage, on_iteration: Callable[[Array], None]) -> Array:
        """The point after a stage with the workspace's constraints near their limit, and any that it then violates."""
        of_joint = np.arange(len(self.constraints.lower)) < len(self.joint_constraints.lower)
        near = of_joint | (self.constraints.slack(y) < NEAR_LIMIT)
        for _ in range(MAX_ROUNDS):
            y = minimise(
                lambda at: self.objective(at, stage), self.constraints.select(near), y, stage.iterations, on_iteration
            )
            slack = self.constraints.slack(y)
            if (slack[~near] >= -TOLERANCE).all():
                break
            near |= slack < NEAR_LIMIT
        return y
