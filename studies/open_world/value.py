"""By how much the value of a finding is off, of a single parameter, else of the torque that it stands for; and its interval."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

import physident as pid
from studies.open_world.bench import DEFAULT
from studies.open_world.causes import ONCE
from studies.open_world.taken import Taken
from studies.open_world.trial import Scene, Trial
from tests.truth import HiddenEffect

Array = NDArray[np.float64]
BY_TORQUE = frozenset({"coupled_friction", "link_inertia", "warm_up", "torque_ripple", "contact", "stribeck_friction",
                       "nonlinear_viscous_friction", "presliding_hysteresis"})  # fmt: skip
GRAVITY = 9.81  # m/s^2


def value_error(scene: Scene, trial: Trial, changed: Sequence[Taken], finding: Any, diagnosis: Any) -> float | None:
    """Error [%] of a finding's value; of its torque on the motion that shows it, where a shape or several values decide."""
    (hidden,) = trial.hidden
    if hidden.effect in BY_TORQUE or _single(hidden, finding) is None:
        return _torque_error(scene, hidden, changed, diagnosis)
    if hidden.effect == "gravity_tilt":
        values = {v.name: v.change for v in finding.parameters}
        angle = hidden.shape["direction"]
        truth = GRAVITY * np.sin(hidden.size) * np.array([np.cos(angle), np.sin(angle)])
        return float(100 * np.linalg.norm(np.array([values["x"], values["y"]]) - truth) / np.linalg.norm(truth))
    return float(100 * abs(_single(hidden, finding).change / hidden.size - 1))


def interval(trial: Trial, finding: Any) -> tuple[float, float] | None:
    """The ends of the 95 % interval of a finding's change, in units of the true one; None where more than one value decides."""
    (hidden,) = trial.hidden
    value = _single(hidden, finding)
    if hidden.effect in BY_TORQUE or hidden.effect == "gravity_tilt" or value is None:
        return None
    low, high = sorted(float(end / hidden.size) for end in value.change_interval95)
    return low, high


def _single(hidden: HiddenEffect, finding: Any) -> Any:
    """The value of a finding that the hidden size is one of, a payload's mass or that of the hidden effect's joint; None where none is told."""
    if hidden.effect == "payload":
        return next((v for v in finding.parameters if v.name == "mass"), None)
    return next((v for v in finding.parameters if not hidden.joints or v.joint == hidden.joints[0]), None)


def _torque_error(scene: Scene, hidden: HiddenEffect, changed: Sequence[Taken], diagnosis: Any) -> float | None:
    """Error [%] of the torque of a finding's change, after the filter, in each joint's rows where its hidden torque is determined; None
    where there is no such row."""
    held = changed[0 if hidden.effect in ONCE else -1]
    model = diagnosis.estimate.model
    same = [e for e in model.effects if e.name == hidden.effect and e.joints in (None, hidden.joints)]
    if not same:
        return None
    effect = same[-1]
    mine = [e is effect for e in model.effects for _ in e.columns(model.robot)]
    start = scene.model.model if isinstance(scene.model, pid.Estimate) else scene.model
    before = {c.name: value for c, value in zip(start.columns, start.theta, strict=True)}
    change = [
        value - before.get(c.name, 0.0) for c, value, own in zip(model.columns, model.theta, mine, strict=True) if own
    ]
    filter = scene.bench.filter
    told = pid.build_regressor(model.robot, [effect], [pid.prepare(held.recording, filter)], filter, model=model)
    truth = pid.build_regressor(model.robot, pid.make_effects(DEFAULT), [pid.prepare(held.alone, filter)], filter)
    same_rows = np.isin(np.round(truth.time, 6), np.round(told.time, 6))
    meant, said = truth.torque[same_rows], told.predict(np.array(change))
    open_rows = [np.interp(told.time, held.recording.time, ~np.isfinite(one)) > 0 for one in held.hidden.T]
    pairs = []
    for j, rows in enumerate(truth.joints):
        Y = rows.values[same_rows] if scene.refitted else None
        pairs.append([_beyond(Y, torque)[~open_rows[j]] for torque in (said[:, j] - meant[:, j], meant[:, j])])
    error, size = (np.concatenate(x) for x in zip(*pairs, strict=True))
    if not size.any():  # the torque of the joints that it acts on is open in every row
        return None
    return float(100 * np.linalg.norm(error) / np.linalg.norm(size))


def _beyond(Y: Array | None, torque: Array) -> Array:
    """What a refitted model of columns Y (M, k) cannot imitate of a torque (M,): the rest belongs to no single effect."""
    return torque if Y is None else torque - Y @ np.linalg.lstsq(Y, torque, rcond=1e-6)[0]
