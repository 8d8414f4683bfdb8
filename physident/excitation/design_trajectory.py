"""Design the motion that excites all parameters of a robot or of a model best."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from physident.dynamics.model import Model
from physident.errors import InputError, NotSolvedError, did_you_mean
from physident.estimation.estimate import Estimate
from physident.excitation.criterion.criterion import Criterion, make_criterion
from physident.excitation.design import LIMITS, Design, Limits
from physident.excitation.limits.joint_limits import JointLimits, joint_margins
from physident.excitation.limits.limit import Margin
from physident.excitation.limits.workspace import CLEARANCE, Workspace
from physident.excitation.motion.series import Series
from physident.excitation.motion.trajectory import Trajectory
from physident.excitation.search.problem import Problem, Solution
from physident.excitation.search.search import GENERATIONS, STARTS, search
from physident.excitation.task import CHECKED, Task, task_of
from physident.identifiability.manipulability import measure_manipulability
from physident.robots.robot import Robot
from physident.threads import one_thread

COARSE_NODES = 24  # fewest instants of a period for the genetic algorithm
MOST = 10_000  # of periods, starts and generations: more would take days
MAX_CHECKED = 3  # solutions that are checked on many instants, until one passes


@dataclass(frozen=True, kw_only=True)
class Settings:
    """The settings of a design that all criteria share; see ``design_trajectory``."""

    limits: Limits
    harmonics: int
    base_frequency: float
    periods: int
    seed: int
    table: float | None
    clearance: float
    meshes: str | Path | None
    starts: int
    generations: int

    def __post_init__(self) -> None:
        if self.limits not in LIMITS:
            raise InputError(
                f"limits is {self.limits!r}, expected one of {', '.join(LIMITS)}{did_you_mean(self.limits, LIMITS)}"
            )
        check_counts(periods=self.periods, starts=self.starts, generations=self.generations)


@one_thread
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
    """Design a motion, at rest at both ends, that excites all parameters of a robot's rigid body, or of a model, best.

    ``criterion``: "condition" (condition number of the regressor), "d_optimal" (volume of the confidence ellipsoid) or
    "a_optimal" (mean square error). ``limits``: "joint" (position, speed, acceleration), or "all", which adds the torque of
    the nominal model, the tool speed, a ``table`` [m] high in the base frame (None: no table) and self-collision with a
    ``clearance`` [m]. The motion is a Fourier series of ``harmonics`` of ``base_frequency`` [Hz], repeated ``periods``
    times. ``meshes`` is the folder of the URDF's mesh packages. A genetic algorithm of ``generations`` finds the starting
    points, and IPOPT improves ``starts`` of them; the same ``seed`` gives the same motion. ``progress`` is called with the
    share that is done. Source: thesis eq. 3.54-3.60.

    Raises InputError for settings or collision geometry that cannot be used, and NotSolvedError where no motion within the
    limits was found, with the limit.
    """
    settings = Settings(
        limits=limits, harmonics=harmonics, base_frequency=base_frequency, periods=periods, seed=seed, table=table,
        clearance=clearance, meshes=meshes, starts=starts, generations=generations,
    )  # fmt: skip
    task = task_of(source)
    # the torque of a bare robot is that of its nominal model, although only the rigid body is excited
    arm = Model.nominal(source) if isinstance(source, Robot) else task.model
    return solve_design(settings, task, task, make_criterion(criterion), arm, progress)


def solve_design(
    settings: Settings,
    task: Task,
    reported: Task,
    criterion: Criterion,
    arm: Model,
    progress: Callable[[float], None],
) -> Design:
    """The best motion by a criterion of a ``task``; its condition number is that of the ``reported`` task.

    Torques for the limits are those of ``arm``. Raises InputError and NotSolvedError as ``design_trajectory``.
    """
    wall, processor = time.perf_counter(), time.process_time()
    problem = _problem(settings, task, criterion, arm)
    solutions = search(problem, settings.seed, settings.starts, settings.generations, progress)
    best, trajectory, margins = _checked(problem, solutions, settings.periods)
    series = problem.series
    states = trajectory.states(np.arange(CHECKED) / CHECKED * series.period)
    return Design(
        trajectory=trajectory,
        criterion=criterion.name,
        value=best.value,
        condition=reported.condition(series, trajectory),
        columns=len(reported.chosen),
        weighting=reported.weighting,
        limits=settings.limits,
        margins=tuple(margins),
        excluded=problem.workspace.self_collision.excluded if problem.workspace else (),
        manipulability=measure_manipulability(arm.robot, states.q),
        starts=tuple(one.value for one in solutions if one.feasible),
        task=reported,
        iterates=np.array([*best.iterates[:-1], best.y]),
        generations=settings.generations,
        seed=settings.seed,
        seconds=time.perf_counter() - wall,
        processor_seconds=time.process_time() - processor,
    )


def check_counts(**counts: int) -> None:
    """Raises InputError for a count below one."""
    for name, count in counts.items():
        if not isinstance(count, int | np.integer) or not 1 <= count <= MOST:
            raise InputError(f"{name} is {count}, expected a whole number from 1 to {MOST}")


def _problem(settings: Settings, task: Task, criterion: Criterion, arm: Model) -> Problem:
    joints = JointLimits.of(arm.robot)
    joints.check_movable()
    series = Series(arm.robot.n, settings.harmonics, settings.base_frequency)
    workspace = None
    if settings.limits == "all":
        workspace = Workspace.of(arm, settings.table, settings.clearance, settings.meshes)
    nodes = task.nodes(series)
    coarse = task.information(series, max(nodes // 2, COARSE_NODES))
    return Problem(series, criterion, task.information(series, nodes), coarse, joints, workspace)


def _checked(problem: Problem, solutions: list[Solution], periods: int) -> tuple[Solution, Trajectory, list[Margin]]:
    """The first solution whose margins are all positive; raises NotSolvedError where none of the best is."""
    first: list[Margin] = []
    for solution in solutions[:MAX_CHECKED]:
        trajectory = problem.series.trajectory(solution.y, periods)
        margins = joint_margins(problem.information.model.robot, trajectory)
        if problem.workspace is not None:
            margins += problem.workspace.margins(trajectory)
        if all(margin.margin > 0 for margin in margins):
            return solution, trajectory, margins
        first = first or margins
    worst = min(first, key=lambda one: one.margin / max(abs(one.allowed), 1e-3))
    raise NotSolvedError(
        f"no motion within the limits was found: {worst.limit} of {worst.where} reaches {worst.reached:.4g} {worst.unit},"
        f" allowed is {worst.allowed:.4g} {worst.unit}; expected wider limits, or another --seed or --base-frequency"
    )
