"""A session: several motions to record, so that a diagnosis can hold recordings out and compare speeds and loads."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from physident.arguments import checked
from physident.dynamics.model import Model
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.excitation.design import Limits
from physident.excitation.design_trajectory import check_counts, design_trajectory
from physident.excitation.limits.joint_limits import joint_margins
from physident.excitation.limits.workspace import CLEARANCE, Workspace
from physident.excitation.motion.trajectory import Trajectory
from physident.excitation.session.first import assumed_noise, first_questions, noise_of
from physident.excitation.session.loads import with_load
from physident.excitation.session.plan import Budget, plan_session
from physident.excitation.session.questions import OpenQuestion
from physident.excitation.session.session import Leg, Session
from physident.recordings.checks import refuse_duplicates
from physident.recordings.load import Recordings, as_recordings
from physident.recordings.preparation import prepare
from physident.robots.robot import Robot
from physident.threads import one_thread

SHORTEST = 15.0  # s of a recording: room for blocks of ten correlation lengths and for the filter's ends


@one_thread
def design_session(
    source: Robot | Model | Estimate,
    load: float | None = None,
    motions: int = 2,
    speeds: Sequence[float] = (1.0, 0.5),
    seed: int = 0,
    limits: Limits = "all",
    base_frequency: float = 0.15,
    table: float | None = 0.0,
    clearance: float = CLEARANCE,
    meshes: str | Path | None = None,
    progress: Callable[[float], None] = lambda _: None,
    minutes: float | None = None,
    questions: Sequence[OpenQuestion] | None = None,
    noise: float | None = None,
    repeat: Recordings = (),
    **settings: Any,
) -> Session:
    """Design several motions at two or more speeds, without and with a ``load`` [kg] at the tool, and one to hold out.

    From four recordings on, a diagnosis leaves each recording out once. Two ``speeds`` (shares of the designed one) separate
    the laws of friction, and a known load fixes the scale of the torques. Every leg lasts at least 15 s. The load is a point
    mass at the tool, and loaded legs respect the torque limits with it. ``settings`` are passed to ``design_trajectory``.

    With ``minutes``, the session is planned instead: of many motions that keep every limit, it has those that within that time
    answer most of ``questions``, by default whether each effect of the catalogue is there; ``noise`` [N m|N] is the RMS of the
    torque noise after the filter, where ``source`` is no estimate. It begins with the motions of recordings to ``repeat``: made again, they
    show what has changed beside anything that a model lacks.

    Raises InputError for a load or speeds that cannot be used, fewer than two motions, and a loaded leg beyond a limit.
    """
    if minutes is not None:
        budget = Budget(
            minutes=minutes,
            load=load,
            limits=limits,
            table=table,
            clearance=clearance,
            meshes=meshes,
            seed=seed,
            **settings,
        )
        return _planned(source, budget, questions, noise, repeat, progress)
    if repeat != ():
        raise InputError(
            "repeat was given without minutes; expected both, because only a planned session repeats motions"
        )
    check_counts(motions=motions)
    if motions < 2 or len(speeds) < 2 or not all(0 < s <= 1 for s in speeds) or len(set(speeds)) < len(speeds):
        raise InputError(
            f"motions is {motions} and speeds are {speeds}; expected two or more motions at two or more different speeds, above 0 and at most 1"
        )
    if load is not None and not (math.isfinite(load) and load > 0):
        raise InputError(f"load is {load} kg, expected a positive mass, or None for no load")
    count = motions + 1
    designs = tuple(
        checked(design_trajectory)(
            source, limits=limits, base_frequency=base_frequency, seed=seed + k, table=table, clearance=clearance, meshes=meshes,
            progress=lambda share, k=k: progress((k + share) / count), **settings,
        )
        for k in range(count)
    )  # fmt: skip
    legs = []
    for loaded in (False,) if load is None else (False, True):
        for speed in speeds:
            for k, design in enumerate(designs[:-1]):
                name = f"motion{k + 1}_{round(100 * speed)}percent{'_loaded' if loaded else ''}"
                legs.append(_leg(name, design.trajectory, speed, loaded=loaded, holdout=False))
    legs.append(_leg("holdout", designs[-1].trajectory, speeds[0], loaded=False, holdout=True))
    if load is not None and limits == "all":
        _check_loaded(source, load, legs, table, clearance, meshes)
    return Session(tuple(legs), designs)


def _planned(
    source: Robot | Model | Estimate,
    budget: Budget,
    questions: Sequence[OpenQuestion] | None,
    noise: float | None,
    repeat: Recordings,
    progress: Callable[[float], None],
) -> Session:
    """The session that was planned for some questions, or for the first visit to an arm."""
    model = (
        source.model if isinstance(source, Estimate) else Model.nominal(source) if isinstance(source, Robot) else source
    )
    if noise is not None and not (math.isfinite(noise) and noise > 0):
        raise InputError(f"noise is {noise}, expected a positive torque [N m], the RMS after the filter")
    known = isinstance(source, Estimate) and noise is None and bool(source.sigma.any())
    torque_noise, words = noise_of(source) if known else assumed_noise(model, noise)  # pyright: ignore[reportArgumentType]
    asked = first_questions(model) if questions is None else questions
    recordings = as_recordings(repeat, model.robot)
    refuse_duplicates(recordings)
    # only their motion counts: currents need no gains
    moved = [one.with_default_drive_gains((1.0,) * one.q.shape[1]) for one in recordings]
    again = [prepare(one, torque_noise.filter) for one in moved]
    return plan_session(model, asked, torque_noise, budget, noise_words=words, progress=progress, repeat=again)


def slowed(trajectory: Trajectory, speed: float) -> Trajectory:
    """The same path at a share of the speed, over as many periods."""
    return replace(trajectory, base_frequency=trajectory.base_frequency * speed, duration=trajectory.duration / speed)


def _leg(name: str, trajectory: Trajectory, speed: float, *, loaded: bool, holdout: bool) -> Leg:
    """The motion at a share of its speed, repeated until it is long enough."""
    slow = slowed(trajectory, speed)
    period = 1 / slow.base_frequency
    repeated = replace(slow, duration=max(1, math.ceil(SHORTEST / period - 1e-9)) * period)
    return Leg(name, repeated, speed, loaded, holdout)


def _check_loaded(
    source: Robot | Model | Estimate, load: float, legs: list[Leg], table: float | None, clearance: float, meshes: Any
) -> None:
    """Raises InputError where a loaded leg exceeds a limit."""
    arm = (
        source.model if isinstance(source, Estimate) else Model.nominal(source) if isinstance(source, Robot) else source
    )
    robot, heavy = arm.robot, with_load(arm, load)
    workspace = Workspace.of(heavy, table, clearance, meshes)
    for leg in legs:
        if not leg.loaded:
            continue
        for margin in [*joint_margins(robot, leg.trajectory), *workspace.margins(leg.trajectory)]:
            if not margin.margin > 0:
                raise InputError(
                    f"{leg.name}: with {load:g} kg the {margin.limit} of {margin.where} reaches {margin.reached:.4g} {margin.unit}, allowed is {margin.allowed:.4g}; expected a lighter load"
                )
