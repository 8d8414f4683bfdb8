"""Designing a motion: the one along which a model's parameters show best."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.errors import InputError, NotSolvedError
from physident.estimation.estimate import Estimate
from physident.excitation.criterion.criterion import Criterion, make_criterion
from physident.excitation.limits.joint_limits import JointLimits
from physident.excitation.limits.margins import Margin, joint_margins, workspace_margins
from physident.excitation.limits.workspace import CLEARANCE, Workspace
from physident.excitation.motion.series import Series
from physident.excitation.motion.trajectory import Trajectory
from physident.excitation.search.problem import Found, Problem
from physident.excitation.search.search import GENERATIONS, STARTS, search
from physident.excitation.task import CHECKED, Task, task_of
from physident.identifiability.manipulability import Manipulability, measure_manipulability
from physident.robots.robot import Robot

COARSE_NODES = 24  # what the genetic algorithm looks at
Limits = Literal["all", "joint"]
LIMITS = ("all", "joint")
TRIED = 3  # of the motions found, until one passes the check on many instants


@dataclass(frozen=True, eq=False)
class Design:
    """A designed motion and what is known about it.

    ``condition``: cond(Y) over 1,000 instants of a period of ``columns`` columns, weighted as ``weighting`` says;
    ``value`` the criterion's. ``margins`` to every limit; ``excluded`` pairs of links that are not kept apart. ``starts``:
    the criterion's value where each start ended, best first. ``way`` (K, n m): the series' free numbers after each iteration
    that led to the motion. ``seconds`` on the clock, ``processor_seconds`` of work.
    """

    trajectory: Trajectory
    criterion: str
    value: float
    condition: float
    columns: int
    weighting: str
    limits: str
    margins: tuple[Margin, ...]
    excluded: tuple[str, ...]
    manipulability: Manipulability
    starts: tuple[float, ...]
    task: Task
    way: NDArray[np.float64]
    generations: int
    seed: int
    seconds: float
    processor_seconds: float

    @property
    def active(self) -> tuple[Margin, ...]:
        """The limits that decided the motion."""
        return tuple(one for one in self.margins if one.active)

    @cached_property
    def progress(self) -> tuple[float, ...]:
        """The condition number, as ``condition`` has it, after each iteration that led to the motion: of the best motion of
        each of the ``generations``, of the one that IPOPT began from, and after each of its iterations."""
        t = self.trajectory
        return self.task.conditions(Series(t.n, t.harmonics, t.base_frequency), self.way)

    def as_dict(self) -> dict[str, Any]:
        """Everything, as JSON can hold it (schema physident.design/1)."""
        plain = (
            "criterion",
            "value",
            "condition",
            "columns",
            "weighting",
            "limits",
            "seed",
            "seconds",
            "processor_seconds",
        )
        return {
            "schema": "physident.design/1",
            **{key: getattr(self, key) for key in plain},
            "margins": [asdict(one) for one in self.margins],
            "excluded_pairs": list(self.excluded),
            "manipulability": self.manipulability.as_dict(),
            "starts": list(self.starts),
            "generations": self.generations,
            "progress": list(self.progress),
            "trajectory": self.trajectory.as_dict(),
        }

    def __repr__(self) -> str:
        from physident.excitation.design_text import design_text

        return design_text(self)


def design_trajectory(
    source: Robot | Model | Estimate,
    criterion: str = "condition",
    limits: Limits = "all",
    harmonics: int = 5,
    base_frequency: float = 0.15,
    periods: int = 1,
    seed: int = 0,
    table: float | None = 0.0,
    clearance: float = CLEARANCE,
    meshes: str | Path | None = None,
    starts: int = STARTS,
    generations: int = GENERATIONS,
    progress: Callable[[float], None] = lambda _: None,
) -> Design:
    """The motion, at rest at both ends, along which all parameters of a robot's rigid body, or of a model, show best.

    ``criterion``: "condition" (cond of the regressor), "d_optimal" (volume of the confidence ellipsoid), "a_optimal"
    (mean square error). ``limits``: "joint" (position, velocity, acceleration) or "all", which adds torque by the
    nominal model, tool speed, a ``table`` [m] high in the base frame (None: no table) and the arm's own links, kept
    ``clearance`` [m] apart. Fourier series of ``harmonics`` of ``base_frequency`` [Hz], repeated ``periods`` times. A genetic algorithm
    of ``generations`` begins, IPOPT ends ``starts`` of its motions; the same ``seed`` gives the same motion. Source: thesis eq.
    3.54-3.60. Raises InputError for settings or shapes that cannot be used, NotSolvedError where no motion within the
    limits was found, naming the limit.
    """
    task, judged = task_of(source), make_criterion(criterion)
    began = time.perf_counter(), time.process_time()
    arm = (
        Model.nominal(source) if isinstance(source, Robot) else task.model
    )  # a robot's torque is all it states of itself
    problem = stated(task, limits, harmonics, base_frequency, table, clearance, meshes, judged, arm)
    check_counts(periods=periods, starts=starts, generations=generations)
    found = search(problem, seed, starts, generations, progress)
    return described(task, problem, found, limits, periods, seed, generations, began)


def stated(
    task: Task, limits: str, harmonics: int, base_frequency: float, table: float | None, clearance: float,
    meshes: str | Path | None, criterion: Criterion, arm: Model,
) -> Problem:  # fmt: skip
    """The problem that a search is to solve, torques by ``arm``; raises InputError for settings that cannot be used."""
    robot = arm.robot
    if limits not in LIMITS:
        raise InputError(f"limits is {limits!r}, expected one of {', '.join(LIMITS)}")
    joints = JointLimits.of(robot)
    joints.refuse_stuck()
    series = Series(robot.n, harmonics, base_frequency)
    workspace = Workspace.of(arm, table, clearance, meshes) if limits == "all" else None
    nodes = task.nodes(series)
    coarse = task.information(series, max(nodes // 2, COARSE_NODES))
    return Problem(series, criterion, task.information(series, nodes), coarse, joints, workspace)


def check_counts(**counts: int) -> None:
    """Raises InputError for a count below one."""
    for name, count in counts.items():
        if not isinstance(count, int | np.integer) or count < 1:
            raise InputError(f"{name} is {count}, expected a whole number, 1 or more")


def described(
    task: Task, problem: Problem, found: list[Found], limits: str, periods: int, seed: int, generations: int,
    began: tuple[float, float],
) -> Design:  # fmt: skip
    """The best motion found with its margins; raises NotSolvedError where a limit is not met, naming it."""
    robot, series = task.model.robot, problem.series
    tried = []
    for one in found[:TRIED]:
        trajectory = series.trajectory(one.y, periods)
        margins = joint_margins(robot, trajectory)
        if problem.workspace is not None:
            margins += workspace_margins(problem.workspace, trajectory)
        tried.append((one, trajectory, margins))
        if all(margin.margin > 0 for margin in margins):
            break
    else:
        raise _unmet(tried[0][2])
    best, trajectory, margins = tried[-1]
    states = trajectory.states(np.arange(CHECKED) / CHECKED * series.period)
    return Design(
        trajectory, problem.criterion.name, best.value, task.condition(series, trajectory), len(task.chosen), task.weighting,
        limits, tuple(margins), problem.workspace.excluded if problem.workspace else (),
        measure_manipulability(robot, states.q), tuple(one.value for one in found if one.feasible),
        task, np.array([*best.way[:-1], best.y]), generations, seed,
        time.perf_counter() - began[0], time.process_time() - began[1],
    )  # fmt: skip


def _unmet(margins: list[Margin]) -> NotSolvedError:
    """The error that names the limit which is missed most."""
    worst = min(margins, key=lambda one: one.margin / max(abs(one.allowed), 1e-3))
    return NotSolvedError(
        f"no motion within the limits was found: {worst.limit} of {worst.where} reaches {worst.reached:.4g} {worst.unit},"
        f" allowed is {worst.allowed:.4g} {worst.unit}; expected limits that leave room (or another --seed, --base-frequency)"
    )
