"""The search for a motion: a genetic algorithm finds starting points, and IPOPT follows exact gradients from there."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from physident.excitation.limits.workspace_constraints import workspace_violation
from physident.excitation.search.genetic import evolve
from physident.excitation.search.problem import Problem, Solution, Stage

Array = NDArray[np.float64]
GENERATIONS = 25
STARTS = 5  # of the last generation, improved by one short stage
FINISHED = 2  # of these, improved by all stages
RANKS = 40  # of the last generation, from which starts are taken at equal steps: neighbours end in the same minimum
CATCH_UP = 2.0  # a start is abandoned if it could not catch up at this many times the leader's rate of improvement

# first a soft condition number, to which all singular values contribute, and soft limits: the search can still move far
FIRST = Stage(6.0, 40, 10.0)
LATER = (Stage(6.0, 30, 100.0), Stage(20.0, 60), Stage(60.0, 80), Stage(200.0, 120))


def search(
    problem: Problem,
    seed: int,
    starts: int = STARTS,
    generations: int = GENERATIONS,
    progress: Callable[[float], None] = lambda _: None,
) -> list[Solution]:
    """The solutions found, best first, feasible ones before others. ``progress`` is called with the share that is done."""
    later = later_stages(problem)
    finished = min(FINISHED, starts)
    steps = 2 + starts + len(later) * finished
    population, iterates = _genetic(problem, seed, generations)
    progress(2 / steps)
    picked = np.linspace(0, min(RANKS, len(population) - 1), starts).round().astype(int)
    solutions = []
    for number, rank in enumerate(picked, 3):
        y = population[rank]
        solutions.append(problem.improve(problem.solution(y, (*iterates, y)), FIRST))
        progress(number / steps)
    solutions.sort(key=lambda one: one.cost)
    leader: list[float] = []  # its cost after each stage
    for place in range(finished):
        costs = []
        for number, one in enumerate(_later_solutions(problem, solutions[place], later, leader), 1):
            solutions[place] = one
            costs.append(one.cost)
            progress((2 + starts + place * len(later) + number) / steps)
        leader = costs if not leader or costs[-1] < leader[-1] else leader
    progress(1.0)
    return sorted(solutions, key=lambda one: (not one.feasible, one.cost))


def later_stages(problem: Problem) -> tuple[Stage, ...]:
    """The stages after the first; those with a penalty only where the problem has a workspace."""
    return tuple(stage for stage in LATER if problem.workspace is not None or stage.penalty is None)


def _genetic(problem: Problem, seed: int, generations: int) -> tuple[Array, list[Array]]:
    """The last population (P, n m) of the genetic algorithm, best first, and the best motion of each generation."""
    workspace, best = problem.workspace, []
    population = evolve(
        problem.joints,
        problem.series,
        lambda y: problem.criterion.values(problem.coarse.matrices(y)),
        None if workspace is None else workspace_violation(workspace, problem.series),
        generations,
        seed,
        on_generation=best.append,
    )
    return population, best


def _later_solutions(
    problem: Problem, start: Solution, later: tuple[Stage, ...], leader: list[float]
) -> Iterator[Solution]:
    """The solution after each stage, until it could not catch up with the ``leader``, whose costs these are."""
    solution = start
    for number, stage in enumerate(later):
        solution = problem.improve(solution, stage)
        yield solution
        if leader and solution.cost - CATCH_UP * (leader[number] - leader[-1]) > leader[-1]:
            return
