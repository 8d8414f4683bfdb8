"""Design the motion that covers what a learned curve has not seen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.learned.curve import LearnedCurve
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.excitation.coverage import Coverage, Covered
from physident.excitation.criterion.covering import Covering
from physident.excitation.design import Limits
from physident.excitation.design_trajectory import Settings, solve_design
from physident.excitation.limits.workspace import CLEARANCE
from physident.excitation.motion.trajectory import random_trajectory
from physident.excitation.search.search import GENERATIONS, STARTS
from physident.excitation.task import Task, task_of
from physident.recordings.signals import Signals
from physident.threads import one_thread

Array = NDArray[np.float64]
MOTIONS = 16  # random ones, whose load says how large a joint's load gets
INSTANTS = 200  # of each


@one_thread
def design_covering(
    estimate: Estimate,
    effect: str,
    joint: int | None = None,
    limits: Limits = "all",
    harmonics: int = 5,
    base_frequency: float = 0.1,
    periods: int = 2,
    seed: int = 0,
    table: float | None = 0.0,
    clearance: float = CLEARANCE,
    meshes: str | Path | None = None,
    starts: int = STARTS,
    generations: int = GENERATIONS,
    progress: Callable[[float], None] = lambda _: None,
) -> Coverage:
    """Design a motion that goes where the curves of a learned ``effect`` have not been, on one ``joint`` (from 1) or all it is on.

    Each curve is continued over all that its joint can reach: its limits of position or speed, or the loads of random motions.
    The motion is the one after which least is left open of it, given what the estimate knows where it was recorded (D-optimal
    with prior knowledge). The other arguments are those of ``design_trajectory``.

    Raises InputError where the model has no such curve, for a curve over time, which every motion covers, and for settings that
    cannot be used; NotSolvedError where no motion within the limits was found.
    """
    settings = Settings(
        limits=limits, harmonics=harmonics, base_frequency=base_frequency, periods=periods, seed=seed, table=table,
        clearance=clearance, meshes=meshes, starts=starts, generations=generations,
    )  # fmt: skip
    arm, general = estimate.model, task_of(estimate)
    curves = _curves(arm, effect, joint)
    motions = _random_states(arm)
    wide = [_continued(arm, curve, motions) for curve in curves]
    counts = [len(curve.columns(arm.robot)) for curve in wide]
    first = sum(len(one.columns(arm.robot)) for one in arm.effects)
    scale = np.concatenate([_sizes(arm, curve) for curve in wide])
    task = Task(
        arm,
        (*arm.effects, *wide),
        np.arange(first, first + sum(counts)),
        scale,
        general.weights,
        "by the curves' prior",
    )
    known = np.eye(sum(counts))
    for k, pair in enumerate(zip(curves, wide, strict=True)):
        at = slice(sum(counts[:k]), sum(counts[: k + 1]))
        known[at, at] += _known(estimate, *pair)
    design = solve_design(settings, task, general, Covering(known), arm, progress)
    time = np.arange(INSTANTS * periods) / INSTANTS / base_frequency
    states = arm.refer(replace(design.trajectory.states(time), rate=INSTANTS * base_frequency))
    return Coverage(
        effect=effect,
        design=design,
        covered=tuple(_covered(arm, *pair, states) for pair in zip(curves, wide, strict=True)),
    )


def _curves(model: Model, name: str, joint: int | None) -> list[LearnedCurve]:
    """The model's curves of a name, one for each joint."""
    found = [
        curve.of_joint(model.robot, k)
        for curve in model.effects
        if isinstance(curve, LearnedCurve) and curve.name == name
        for k, j in enumerate(curve.active(model.robot))
        if joint in (None, j + 1)
    ]
    if not found:
        has = sorted(
            {
                f"{e.name} on joint {j + 1}"
                for e in model.effects
                if isinstance(e, LearnedCurve)
                for j in e.active(model.robot)
            }
        )
        place = "" if joint is None else f" on joint {joint}"
        raise InputError(
            f"the model has no learned curve {name}{place}; expected {' or '.join(has) or 'a model with a learned effect'}"
        )
    if found[0].variable == "time":
        raise InputError(
            f"{name} is a curve over time, which every motion covers; expected a curve over position, velocity, torque or load"
        )
    return found


def _random_states(model: Model) -> list[Signals]:
    motions = [random_trajectory(model.robot, seed) for seed in range(MOTIONS)]
    return [model.refer(m.evenly(INSTANTS)) for m in motions]


def _continued(model: Model, curve: LearnedCurve, motions: Sequence[Signals]) -> LearnedCurve:
    """The curve over all that its joint can reach, its range before included."""
    (j,), robot = curve.active(model.robot), model.robot
    values = [x[:, j] for one in motions if (x := curve.quantity(one)) is not None]
    ends = [min(x.min() for x in values), max(x.max() for x in values), *curve.ends(robot)]
    limits = {
        "position": (robot.lower[j], robot.upper[j]),
        "velocity": (-robot.velocity_limit[j], robot.velocity_limit[j]),
    }
    ends += [x for x in limits.get(curve.variable or "", ()) if np.isfinite(x)]
    return replace(curve, low=(float(min(ends)),), high=(float(max(ends)),))


def _known(estimate: Estimate, curve: LearnedCurve, wide: LearnedCurve) -> Array:
    """Information (modes, modes) about a continued curve, in units of its prior, from what the estimate knows of the curve.

    It counts as measured at as many places as it has numbers, each as well as the estimate knows it there beyond the prior.
    """
    robot = estimate.model.robot
    names = [estimate.base.columns[i].name for i in estimate.base.independent]
    places = [names.index(c.name) if c.name in names else -1 for c in curve.columns(robot)]
    size = _sizes(estimate.model, curve)
    covariance = np.diag(size**2)
    kept = [k for k, at in enumerate(places) if at >= 0]
    at = np.array([places[k] for k in kept], dtype=np.intp)
    covariance[np.ix_(kept, kept)] = estimate.covariance[np.ix_(at, at)]
    x = np.linspace(*curve.ends(robot), len(size))
    before = curve.shapes_at(robot, x)  # (S, modes)
    variance = np.einsum("sk,kl,sl->s", before, covariance, before)
    open_ = ((before * size) ** 2).sum(axis=1)
    gained = np.maximum(1 / np.maximum(variance, 1e-12 * open_) - 1 / open_, 0.0)
    after = wide.shapes_at(robot, x) * _sizes(estimate.model, wide)
    return after.T @ (gained[:, None] * after)


def _sizes(model: Model, curve: LearnedCurve) -> Array:
    """Standard deviations (modes,) of a curve's numbers under its prior."""
    sizes = curve.prior_sizes(model.robot)
    assert sizes is not None
    return sizes


def _covered(model: Model, curve: LearnedCurve, wide: LearnedCurve, states: Signals) -> Covered:
    (j,), robot = curve.active(model.robot), model.robot
    x = curve.quantity(states)
    assert x is not None
    before, ends = curve.ends(robot), wide.ends(robot)
    reached = (float(x[:, j].min()), float(x[:, j].max()))
    possible = (
        min(ends[0], reached[0]),
        max(ends[1], reached[1]),
    )  # ends of random motions: a designed one may go beyond
    return Covered(
        joint=j + 1, unit=curve.unit_of_quantity(robot, j), before=before, reached=reached, possible=possible
    )
