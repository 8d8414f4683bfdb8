"""What a search is to solve: a criterion of a motion, made small within limits, and a motion that was found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.excitation.criterion.criterion import Condition, Criterion
from physident.excitation.criterion.information import Information
from physident.excitation.limits.joint_limits import JointLimits
from physident.excitation.limits.walls import NODES as WALL_NODES
from physident.excitation.limits.walls import Walls
from physident.excitation.limits.workspace import Workspace
from physident.excitation.motion.series import Series
from physident.excitation.search.nlp import Rows, join, minimise

Array = NDArray[np.float64]
DEAR = 20.0  # what exceeding a limit by its own size costs, in units of the criterion
WITHIN = 1e-5  # relative: how far IPOPT may end beyond a constraint
NEAR = 0.6  # of a limit: rows of the workspace farther away are left out of a stage, and looked at again after it
ROUNDS = 4
RESERVE = 0.02  # of a limit: a penalty begins before it is reached
LIMIT_NODES = 96  # of a period for joint limits; those of five harmonics are then tightened by 1.3 %


@dataclass(frozen=True)
class Stage:
    """A run of IPOPT: the ``sharpness`` of the condition number, at most so many ``iterations``, and the weight of the
    ``penalty`` by which the workspace's limits are held, None where they are constraints."""

    sharpness: float
    iterations: int
    penalty: float | None = None


@dataclass(frozen=True, eq=False)
class Problem:
    """A motion of a ``series`` to find: ``criterion`` of its ``information`` made small within limits; ``coarse`` is the
    information the genetic algorithm looks at."""

    series: Series
    criterion: Criterion
    information: Information
    coarse: Information
    joints: JointLimits
    workspace: Workspace | None

    @cached_property
    def joint_rows(self) -> Rows:
        """The limits of the joints as constraints."""
        return self.joints.rows(self.series, max(LIMIT_NODES, 12 * self.series.harmonics))

    @cached_property
    def walls(self) -> Rows | None:
        """The limits of the workspace as constraints."""
        return None if self.workspace is None else Walls(self.workspace, self.series).rows()

    @cached_property
    def rows(self) -> Rows:
        """All limits, those of the joints first."""
        return self.joint_rows if self.walls is None else join(self.joint_rows, self.walls)

    def function(self, y: Array, stage: Stage) -> tuple[float, Callable[[], Array]]:
        """What a stage makes small at free numbers (n m,), and what returns its gradient."""
        criterion = self.criterion
        if isinstance(criterion, Condition):
            criterion = replace(criterion, sharpness=stage.sharpness)
        value, slope = criterion.gradient(self.information.matrix(y))
        if self.walls is None or stage.penalty is None:
            return value, lambda: self.information.pullback(y, slope)
        beyond, outward = self.walls.penalty(y, RESERVE)
        weight = stage.penalty / WALL_NODES
        return value + weight * beyond, lambda: self.information.pullback(y, slope) + weight * outward

    def improved(self, found: Found, stage: Stage) -> Found:
        """The motion after a stage, with the way there, or as it was where that did not help."""
        way: list[Array] = []
        if stage.penalty is not None or self.walls is None:
            y = minimise(lambda at: self.function(at, stage), self.joint_rows, found.y, stage.iterations, way.append)
        else:
            y = self._constrained(found.y, stage, way.append)
        return min(found, self.judged(y, (*found.way, *way)), key=lambda one: one.cost)

    def _constrained(self, y: Array, stage: Stage, passed: Callable[[Array], None]) -> Array:
        """The motion after a stage with those rows of the workspace that come near their limit, and any it then meets."""
        always = np.arange(len(self.rows.lower)) < len(self.joint_rows.lower)
        near = always | (self.rows.slack(y) < NEAR)
        for _ in range(ROUNDS):
            y = minimise(lambda at: self.function(at, stage), self.rows.only(near), y, stage.iterations, passed)
            slack = self.rows.slack(y)
            if (slack[~near] >= -WITHIN).all():
                break
            near |= slack < NEAR
        return y

    def judged(self, y: Array, way: tuple[Array, ...] = ()) -> Found:
        """The criterion's value and how far limits are exceeded; ``way`` led there."""
        value, excess = float(self.criterion.values(self.information.matrix(y))), self.rows.excess(y)
        return Found(y, value, excess, value + DEAR * max(0.0, excess - WITHIN), way)


@dataclass(frozen=True, eq=False)
class Found:
    """Free numbers ``y`` (n m,), the criterion's ``value``, by how much of a limit the worst one is exceeded, what the motion
    ``cost``s with that, and the ``way`` that the search went to it, (n m,) after each iteration."""

    y: Array
    value: float
    excess: float
    cost: float
    way: tuple[Array, ...] = ()

    @property
    def feasible(self) -> bool:
        """Whether every limit holds."""
        return self.excess <= WITHIN
