"""The search for a motion: a genetic algorithm finds where to start, IPOPT follows exact gradients to the end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.excitation.criterion import Condition, Criterion
from physident.excitation.genetic import evolve
from physident.excitation.information import Information
from physident.excitation.limits import JointLimits
from physident.excitation.nlp import Rows, join, minimise
from physident.excitation.series import Series
from physident.excitation.walls import NODES as WALL_NODES
from physident.excitation.walls import Walls
from physident.excitation.workspace import Workspace

Array = NDArray[np.float64]
GENERATIONS = 25
STARTS = 5  # of the last generation, improved a little; they then end in the order they are in
FINISHED = 2  # of them, followed to the end
RANKS = 40  # of the last generation, from which starts are taken at equal steps: neighbours end in one place
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


# a soft condition number, which all singular values pull on, and soft walls first: both leave the search room to move
FIRST = Stage(6.0, 60, 10.0)
LATER = (Stage(6.0, 30, 100.0), Stage(20.0, 60), Stage(60.0, 80), Stage(200.0, 120))


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

    @property
    def later(self) -> tuple[Stage, ...]:
        """The stages after the first that change something."""
        return tuple(stage for stage in LATER if self.walls is not None or stage.penalty is None)

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
        """The motion after a stage, or as it was where that did not help."""
        if stage.penalty is not None or self.walls is None:
            y = minimise(lambda at: self.function(at, stage), self.joint_rows, found.y, stage.iterations)
        else:
            y = self._constrained(found.y, stage)
        return min(found, self.judged(y), key=lambda one: one.cost)

    def _constrained(self, y: Array, stage: Stage) -> Array:
        """The motion after a stage with those rows of the workspace that come near their limit, and any it then meets."""
        always = np.arange(len(self.rows.lower)) < len(self.joint_rows.lower)
        near = always | (self.rows.slack(y) < NEAR)
        for _ in range(ROUNDS):
            y = minimise(lambda at: self.function(at, stage), self.rows.only(near), y, stage.iterations)
            slack = self.rows.slack(y)
            if (slack[~near] >= -WITHIN).all():
                break
            near |= slack < NEAR
        return y

    def judged(self, y: Array) -> Found:
        """The criterion's value and how far limits are exceeded."""
        value, excess = float(self.criterion.values(self.information.matrix(y))), self.rows.excess(y)
        return Found(y, value, excess, value + DEAR * max(0.0, excess - WITHIN))


@dataclass(frozen=True, eq=False)
class Found:
    """Free numbers ``y``, the criterion's ``value``, by how much of a limit the worst one is exceeded, and what the motion
    ``cost``s with that."""

    y: Array
    value: float
    excess: float
    cost: float

    @property
    def feasible(self) -> bool:
        """Whether every limit holds."""
        return self.excess <= WITHIN


def search(
    problem: Problem,
    seed: int,
    starts: int = STARTS,
    generations: int = GENERATIONS,
    progress: Callable[[float], None] = lambda _: None,
) -> list[Found]:
    """The motions found, best first, feasible ones before others. ``progress`` hears the share that is done."""
    later = problem.later
    steps = 2 + starts + len(later) * min(FINISHED, starts)
    space = problem.workspace
    violation = None if space is None else Walls(space, problem.series).violation()
    population = evolve(
        problem.joints,
        problem.series,
        lambda y: problem.criterion.values(problem.coarse.matrices(y)),
        violation,
        generations,
        seed,
    )
    done = 2
    progress(done / steps)
    picked = np.linspace(0, min(RANKS, len(population) - 1), starts).round().astype(int)
    found = []
    for rank in picked:
        found.append(problem.improved(problem.judged(population[rank]), FIRST))
        progress((done := done + 1) / steps)
    found.sort(key=lambda one: one.cost)
    for place in range(min(FINISHED, starts)):
        for stage in later:
            found[place] = problem.improved(found[place], stage)
            progress((done := done + 1) / steps)
    return sorted(found, key=lambda one: (not one.feasible, one.cost))
