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
from physident.excitation.workspace import Workspace

Array = NDArray[np.float64]
GENERATIONS = 20
STARTS = 5  # of the last generation, improved a little; they then end in the order they are in
FINISHED = 2  # of them, followed to the end
RANKS = 40  # of the last generation, from which starts are taken at equal steps: neighbours end in one place
FIRST, FIRST_ITERATIONS = 6.0, 60  # sharpness of the first stage, where all singular values pull
LATER = ((20.0, 60), (60.0, 80), (200.0, 120))  # sharpness and iterations of the last ones
WITHIN = 1e-5  # relative: how far IPOPT may end beyond a constraint
NEAR = 0.6  # of a limit: rows of the workspace farther away are left out of a stage, and looked at again after it
ROUNDS = 4
LIMIT_NODES = 96  # of a period for joint limits; those of five harmonics are then tightened by 1.3 %


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
    def rows(self) -> Rows:
        """All limits as constraints, those of the joints first."""
        own = self.joints.rows(self.series, self._limit_nodes)
        return own if self.workspace is None else join(own, self.workspace.rows(self.series))

    @property
    def _limit_nodes(self) -> int:
        return max(LIMIT_NODES, 12 * self.series.harmonics)

    @property
    def _always(self) -> NDArray[np.bool_]:
        """Rows that no stage leaves out: those of the joints, which are cheap."""
        return np.arange(len(self.rows.lower)) < 3 * self.series.n * self._limit_nodes

    def function(self, y: Array, sharpness: float | None) -> tuple[float, Array]:
        """What is made small at free numbers (n m,), and its gradient."""
        criterion = self.criterion
        if sharpness is not None and isinstance(criterion, Condition):
            criterion = replace(criterion, sharpness=sharpness)
        value, slope = criterion.gradient(self.information.matrix(y))
        return value, self.information.pullback(y, slope)

    def improved(self, found: Found, sharpness: float | None, iterations: int) -> Found:
        """The motion after some iterations, or as it was where these did not help."""
        y = found.y
        near = self._always | (self.rows.slack(y) < NEAR)
        for _ in range(ROUNDS):
            y = minimise(lambda at: self.function(at, sharpness), self.rows.only(near), y, iterations).y
            slack = self.rows.slack(y)
            if (slack[~near] >= -WITHIN).all():
                break
            near |= slack < NEAR
        after = self.judged(y)
        return min(found, after, key=lambda one: (max(one.excess, WITHIN), one.value))

    def judged(self, y: Array) -> Found:
        """The criterion's value and how far limits are exceeded."""
        return Found(y, float(self.criterion.values(self.information.matrix(y))), self.rows.excess(y))


@dataclass(frozen=True, eq=False)
class Found:
    """Free numbers ``y``, the criterion's ``value``, and by how much of a limit the worst one is exceeded."""

    y: Array
    value: float
    excess: float

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
    steps = 2 + starts + len(LATER) * FINISHED
    fitness = lambda y: problem.criterion.values(problem.coarse.matrices(y))  # noqa: E731
    violation = None if problem.workspace is None else problem.workspace.violation(problem.series)
    population = evolve(problem.joints, problem.series, fitness, violation, generations, seed)
    progress(2 / steps)
    picked = np.linspace(0, min(RANKS, len(population) - 1), starts).round().astype(int)
    found = []
    for k, rank in enumerate(picked):
        found.append(problem.improved(problem.judged(population[rank]), FIRST, FIRST_ITERATIONS))
        progress((3 + k) / steps)
    found.sort(key=lambda one: (not one.feasible, one.value))
    for place in range(min(FINISHED, len(found))):
        for k, (sharpness, iterations) in enumerate(LATER):
            found[place] = problem.improved(found[place], sharpness, iterations)
            progress((3 + starts + place * len(LATER) + k) / steps)
    return sorted(found, key=lambda one: (not one.feasible, one.value))
