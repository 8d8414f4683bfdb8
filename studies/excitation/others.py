"""The same problem by other ways: a genetic algorithm alone, SLSQP with finite differences, IPOPT from random starts."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

import physident as pid
from physident.excitation.criterion.criterion import Condition
from physident.excitation.limits.joint_limits import JointLimits
from physident.excitation.motion.series import Series
from physident.excitation.search.genetic import evolve
from physident.excitation.search.problem import Problem, Stage
from physident.excitation.search.search import later_stages
from physident.excitation.task import Task, task_of

Array = NDArray[np.float64]
HARMONICS, BASE_FREQUENCY = 5, 0.15
FULL = Stage(6.0, 60)


class TimeUp(Exception):
    """The time that a method was given is over."""


def problem_of(robot: pid.Robot) -> tuple[Task, Problem]:
    """The thesis' problem: condition number within the limits of position, velocity and acceleration."""
    task, series = task_of(robot), Series(robot.n, HARMONICS, BASE_FREQUENCY)
    nodes = task.nodes(series)
    information, coarse = task.information(series, nodes), task.information(series, nodes // 2)
    return task, Problem(series, Condition(), information, coarse, JointLimits.of(robot), None)


def genetic_alone(robot: pid.Robot, seconds: float, seed: int = 0) -> dict[str, float]:
    """The genetic algorithm until its processor time is over."""
    task, problem = problem_of(robot)
    start, best, generations = time.process_time(), [np.inf, np.zeros(0)], [0]

    def fitness(y: Array) -> Array:
        if time.process_time() - start > seconds:
            raise TimeUp
        values = problem.criterion.values(problem.information.matrices(y))
        generations[0] += 1
        if values.min() < best[0]:
            best[:] = [values.min(), y[values.argmin()].copy()]
        return values

    wall = time.perf_counter()
    with suppress(TimeUp):
        evolve(problem.joints, problem.series, fitness, None, 10**6, seed)
    motion = problem.series.trajectory(best[1])  # pyright: ignore[reportArgumentType]
    assert motion.violations(robot) == []
    found = task.condition(problem.series, motion)
    return {
        "condition": found,
        "processor_seconds": seconds,
        "seconds": time.perf_counter() - wall,
        "generations": generations[0],
    }


def finite_differences(robot: pid.Robot, seconds: float, seed: int = 0) -> dict[str, float]:
    """scipy's SLSQP with finite differences of the objective, from random motions, until its processor time is over."""
    task, problem = problem_of(robot)
    rows = problem.joint_constraints
    J = np.zeros((len(rows.lower), problem.series.size))
    J[rows.pattern[:, 0], rows.pattern[:, 1]] = rows.jacobian(np.zeros(problem.series.size))
    inside = {
        "type": "ineq",
        "fun": lambda y: np.concatenate([1 - rows.value(y), 1 + rows.value(y)]),
        "jac": lambda y: np.concatenate([-J, J]),
    }
    start, wall, best, runs = time.process_time(), time.perf_counter(), [np.inf, np.zeros(0)], 0

    def function(y: Array) -> float:
        if time.process_time() - start > seconds:
            raise TimeUp
        value = float(problem.criterion.values(problem.information.matrix(y)))
        if value < best[0] and rows.violation(y) < 1e-6:
            best[:] = [value, y.copy()]
        return value

    try:
        while True:
            motion = pid.random_trajectory(robot, seed + runs, HARMONICS, BASE_FREQUENCY)
            runs += 1
            minimize(
                function,
                problem.series.numbers(motion),
                method="SLSQP",
                constraints=[inside],
                options={"maxiter": 1000},
            )
    except TimeUp:
        pass
    found = task.condition(problem.series, problem.series.trajectory(best[1]))  # pyright: ignore[reportArgumentType]
    return {"condition": found, "processor_seconds": seconds, "seconds": time.perf_counter() - wall, "starts": runs}


def random_starts(robot: pid.Robot, count: int) -> dict[str, list[float]]:
    """IPOPT with exact gradients from random motions, all stages for each."""
    task, problem = problem_of(robot)
    conditions, seconds = [], []
    for seed in range(count):
        start = time.process_time()
        motion = pid.random_trajectory(robot, seed, HARMONICS, BASE_FREQUENCY)
        found = problem.solution(problem.series.numbers(motion))
        for stage in (FULL, *later_stages(problem)):
            found = problem.improve(found, stage)
        conditions.append(task.condition(problem.series, problem.series.trajectory(found.y)))
        seconds.append(time.process_time() - start)
    return {"condition": conditions, "processor_seconds": seconds}


def gradient_error(robot: pid.Robot, seeds: int) -> float:
    """Largest relative difference of the exact gradient along random directions from fourth-order differences."""
    _, problem = problem_of(robot)
    worst = 0.0
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        y = problem.series.numbers(pid.random_trajectory(robot, seed, HARMONICS, BASE_FREQUENCY))
        d = rng.standard_normal(y.size)
        function: Callable[[Array], float] = lambda x: problem.objective(x, FULL)[0]  # noqa: E731
        slope = float(problem.objective(y, FULL)[1]() @ d)
        near, far = ((function(y + h * d) - function(y - h * d)) / (2 * h) for h in (1e-4, 2e-4))
        worst = max(worst, abs((4 * near - far) / 3 / slope - 1))
    return worst
