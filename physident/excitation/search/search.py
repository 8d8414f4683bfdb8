"""The search for a motion: a genetic algorithm finds where to start, IPOPT follows exact gradients to the end."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from physident.excitation.limits.walls import Walls
from physident.excitation.search.genetic import evolve
from physident.excitation.search.problem import Found, Problem, Stage

Array = NDArray[np.float64]
GENERATIONS = 25
STARTS = 5  # of the last generation, improved a little; they then end in the order they are in
FINISHED = 2  # of them, followed to the end
RANKS = 40  # of the last generation, from which starts are taken at equal steps: neighbours end in one place
HOPE = 2.0  # a start is given up that would stay behind if it still gained so many times what the best then did

# a soft condition number, which all singular values pull on, and soft walls first: both leave the search room to move
FIRST = Stage(6.0, 40, 10.0)
LATER = (Stage(6.0, 30, 100.0), Stage(20.0, 60), Stage(60.0, 80), Stage(200.0, 120))


def search(
    problem: Problem,
    seed: int,
    starts: int = STARTS,
    generations: int = GENERATIONS,
    progress: Callable[[float], None] = lambda _: None,
) -> list[Found]:
    """The motions found, best first, feasible ones before others. ``progress`` hears the share that is done."""
    later = stages_of(problem)
    finished = min(FINISHED, starts)
    steps = 2 + starts + len(later) * finished
    population, way = _evolved(problem, seed, generations)
    progress(2 / steps)
    picked = np.linspace(0, min(RANKS, len(population) - 1), starts).round().astype(int)
    found = []
    for number, rank in enumerate(picked, 3):
        y = population[rank]
        found.append(problem.improved(problem.judged(y, (*way, y)), FIRST))
        progress(number / steps)
    found.sort(key=lambda one: one.cost)
    best: list[float] = []
    for place in range(finished):
        costs = []
        for number, one in enumerate(_finish(problem, found[place], later, best), 1):
            found[place] = one
            costs.append(one.cost)
            progress((2 + starts + place * len(later) + number) / steps)
        best = costs if not best or costs[-1] < best[-1] else best
    progress(1.0)
    return sorted(found, key=lambda one: (not one.feasible, one.cost))


def stages_of(problem: Problem) -> tuple[Stage, ...]:
    """The stages after the first that change something of a problem."""
    return tuple(stage for stage in LATER if problem.walls is not None or stage.penalty is None)


def _evolved(problem: Problem, seed: int, generations: int) -> tuple[Array, list[Array]]:
    """The last population (P, n m) of the genetic algorithm, best first, and the best motion of each generation."""
    space, way = problem.workspace, []
    population = evolve(
        problem.joints,
        problem.series,
        lambda y: problem.criterion.values(problem.coarse.matrices(y)),
        None if space is None else Walls(space, problem.series).violation(),
        generations,
        seed,
        passed=way.append,
    )
    return population, way


def _finish(problem: Problem, one: Found, later: tuple[Stage, ...], best: list[float]) -> Iterator[Found]:
    """The motion after each stage, until it is given up behind one that cost ``best`` after the same stages."""
    for number, stage in enumerate(later):
        one = problem.improved(one, stage)
        yield one
        if best and one.cost - HOPE * (best[number] - best[-1]) > best[-1]:
            return
