"""Recordings at standstill: compare measured torque with modelled gravity and the breakaway torque.

At standstill, static friction takes any value up to the breakaway torque, so only a larger difference contradicts the
model.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.at_rest.poses import AtRest, Pose
from physident.dynamics.model import Model
from physident.effects.effect import Effect
from physident.errors import InputError
from physident.estimation.dry_friction.row_weights import creep
from physident.estimation.estimate import Estimate
from physident.recordings.checks import check_effort, refuse_duplicates
from physident.recordings.load import Recordings, as_recordings
from physident.recordings.preparation import prepare
from physident.recordings.recording import Recording
from physident.recordings.rows import typical_step
from physident.recordings.signals import Filter, Signals
from physident.robots.robot import Robot
from physident.threads import one_thread

Array = NDArray[np.float64]
SLIDING = 0.03  # rad/s|m/s: whatever remembers has settled into sliding


def is_at_rest(recordings: Sequence[Recording]) -> bool:
    """Whether no joint moves in any of some recordings."""
    return bool(recordings) and all(_signals(recording).moving is None for recording in recordings)


@one_thread
def diagnose_at_rest(model: Estimate | Model, recordings: Recordings) -> AtRest:
    """Compare the torques of recordings at standstill with a model's gravity and breakaway torque.

    Raises InputError for a recording with motion or one that came twice, another number of joints, torques far beyond the
    robot's limits, or currents without gains.
    """
    arm = model.model if isinstance(model, Estimate) else model
    recordings = as_recordings(recordings, arm.robot, model.layout if isinstance(model, Estimate) else None)
    if not recordings:
        raise InputError("no recordings given, expected at least one of an arm at rest")
    refuse_duplicates(recordings)
    poses = []
    for recording in recordings:
        if recording.n != arm.robot.n:
            raise InputError(f"{recording.source}: {recording.n} joints, but robot {arm.robot.name} has {arm.robot.n}")
        gained = recording.with_default_drive_gains(model.drive_gains if isinstance(model, Estimate) else None)
        if _signals(gained).moving is not None:
            raise InputError(
                f"{recording.source}: the arm moves; expected recordings that stand still, or all with motion"
            )
        check_effort([gained], arm.robot)
        q = gained.q.mean(axis=0)
        gravity, std = _gravity(model, q)
        poses.append(
            Pose(recording.source, recording.duration, q, gained.torque.mean(axis=0), gravity, std, breakaway(arm, q))
        )
    return AtRest(tuple(poses), arm.robot.joint_names, arm.robot.torque_units)


def breakaway(model: Model, q: Array) -> Array:
    """Breakaway torque (n,) [N m|N] of each joint at a position (n,): the model's friction at a slow creep."""
    robot = model.robot
    at_once = [(effect, theta) for effect, theta in _parts(model) if effect.pointwise]
    alone = Model(robot, tuple(e for e, _ in at_once), np.concatenate([theta for _, theta in at_once]))
    slow = np.diag(creep(model))
    forth, back = alone.torque(_states(q, slow)), alone.torque(_states(q, -slow))
    result = np.diag(forth - back) / 2
    for effect, theta in _parts(model):
        if not effect.pointwise:
            result = result + _with_memory(effect, theta, robot)
    return np.maximum(result, 0.0)


def _with_memory(effect: Effect, theta: Array, robot: Robot) -> Array:
    """Friction (n,) of an effect whose value depends on the motion before, once that has settled."""
    friction = effect.friction(robot, np.array([SLIDING]))[:, 0] * theta
    result = np.zeros(robot.n)
    for column, value in zip(effect.columns(robot), friction, strict=True):
        result[column.joint - 1] += value
    return result


def _gravity(model: Estimate | Model, q: Array) -> tuple[Array, Array]:
    """Torque (n,) [N m|N] of a model that stands still without friction, and its standard error from the model's."""
    arm = model.model if isinstance(model, Estimate) else model
    still = arm.refer(_states(q, np.zeros((1, arm.robot.n))))
    Y, start = np.zeros((arm.robot.n, len(arm.theta))), 0
    for effect, theta in _parts(arm):
        if effect.pointwise:
            for (row, column), entry in zip(effect.pattern(arm.robot), effect.values(arm.robot, still), strict=True):
                Y[row, start + column] += entry[0]
        start += len(theta)
    std = np.zeros(arm.robot.n)
    if isinstance(model, Estimate):
        rows = Y[:, model.base.independent]
        std = np.sqrt(np.maximum(np.einsum("jr,rs,js->j", rows, model.covariance, rows), 0.0))
    return Y @ arm.theta, std


def _parts(model: Model) -> list[tuple[Effect, Array]]:
    """Each effect with its own parameters (k,)."""
    sizes = [len(effect.columns(model.robot)) for effect in model.effects]
    return list(zip(model.effects, np.split(model.theta, np.cumsum(sizes)[:-1]), strict=True))


def _states(q: Array, v: Array) -> Signals:
    return Signals.of_states(np.tile(q, (len(v), 1)), v, np.zeros_like(v))


def _signals(recording: Recording) -> Signals:
    """A recording's signals, to see whether it moves: currents need no gains for that."""
    rate = 1 / typical_step(recording.time)
    bare = recording.effort_kind == "current" and recording.drive_gains is None
    unit = recording.with_drive_gains([1.0] * recording.n) if bare else recording
    return prepare(unit, Filter(cutoff=min(Filter().cutoff, 0.3 * rate)))
