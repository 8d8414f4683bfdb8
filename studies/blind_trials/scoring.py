"""What a diagnosis of a blind trial is worth: right cause and joints, class, value, gain - or rightly nothing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.dynamics.regressor import Regressor, build_regressor
from physident.estimation.estimate import as_estimate
from physident.estimation.identify import prepare_all
from studies.blind_trials.arms import FILTER, Taken
from studies.blind_trials.cases import Hidden
from studies.blind_trials.sizing import filtered, oracle
from studies.blind_trials.trial import Prepared

Array = NDArray[np.float64]
BY_TORQUE = ("coupled_friction", "link_inertia", "warm_up", "torque_ripple", "contact", "stribeck_friction",
             "nonlinear_viscous_friction", "presliding_hysteresis")  # fmt: skip


@dataclass(frozen=True)
class Score:
    """``first``: the cause in first place is the hidden one, alone or in a class; ``listed``: the finding in first place is, whatever its
    grade; ``alone``: without a rival; ``named``: every hidden cause is named; ``others``: causes beyond them; ``size`` of the first cause's class; ``error`` [%]
    of the value, or of the torque where a shape decides; ``gain`` [%] of the oracle's."""

    first: bool
    listed: bool
    alone: bool
    named: bool
    others: int
    size: int
    error: float | None
    gain: float | None
    told: str
    verdict: str
    seconds: float
    unseen: bool


def score(prepared: Prepared, diagnosis: pid.Diagnosis, seconds: float) -> Score:
    """Compare a diagnosis of the changed recordings with what was hidden."""
    hidden = prepared.trial.hidden
    keys = [(h.effect, h.joints) for h in hidden]
    found = [(f.effect, f.joints) for f in diagnosis.causes]
    classes = [_class(f) for f in diagnosis.causes]
    first = bool(classes) and any(key in classes[0] for key in keys)
    listed = any(key in own for own in map(_class, diagnosis.findings[:1]) for key in keys)
    named = all(any(key in own for own in classes) for key in keys)
    others = sum(not any(key in own for key in keys) for own in classes)
    error = gain = None
    if len(hidden) == 1 and keys[0] in found:
        error = value_error(prepared, hidden[0], diagnosis)
    if first and len(hidden) == 1 and hidden[0].effect != "contact":
        gain = gain_of_oracle(prepared, diagnosis)
    unseen = any((u.effect, u.joints) == keys[0] for u in diagnosis.unseen)
    told = "; ".join(_text(f) for f in diagnosis.causes) or "nothing"
    return Score(
        first, listed, first and len(classes[0]) == 1, named, others, len(classes[0]) if classes else 0, error, gain, told,
        diagnosis.verdict, seconds, unseen,
    )  # fmt: skip


def _class(f: Any) -> set[tuple[str, tuple[int, ...]]]:
    return {(f.effect, f.joints), *((r.effect, r.joints) for r in f.rivals)}


def _text(f: Any) -> str:
    names = [(f.effect, f.joints), *((r.effect, r.joints) for r in f.rivals)]
    return " or ".join(f"{effect} {','.join(map(str, joints))}".strip() for effect, joints in names)


def value_error(prepared: Prepared, hidden: Hidden, diagnosis: pid.Diagnosis) -> float:
    """By how much [%] the finding's value is off; by torque on the held-out motion where a shape or several values decide."""
    (finding,) = [f for f in diagnosis.causes if (f.effect, f.joints) == (hidden.effect, hidden.joints)]
    size, _ = hidden.doses()
    values = {v.name: v.change for v in finding.parameters}
    if hidden.effect in BY_TORQUE:
        return _torque_error(prepared, hidden, diagnosis)
    if hidden.effect == "payload":
        return 100 * abs(values["mass"] / size - 1)
    if hidden.effect == "gravity_tilt":
        angle = dict(hidden.shape)["direction"]
        truth = 9.81 * np.sin(size) * np.array([np.cos(angle), np.sin(angle)])
        return float(100 * np.linalg.norm(np.array([values["x"], values["y"]]) - truth) / np.linalg.norm(truth))
    return 100 * abs(finding.parameters[0].change / size - 1)


def _torque_error(prepared: Prepared, hidden: Hidden, diagnosis: pid.Diagnosis) -> float:
    """Torque of the finding's change against the hidden torque, after the filter, on the motion that shows it."""
    held: Taken = prepared.changed[0 if hidden.effect == "contact" else -1]
    assert diagnosis.estimate is not None
    model = diagnosis.estimate.model
    signals = prepare_all(model.robot, [held.recording], FILTER)
    own = [
        effect for effect in model.effects if effect.name == hidden.effect and effect.joints in (None, hidden.joints)
    ]
    (effect,) = own[-1:]
    mine = [i for i, e in enumerate(e for e in model.effects for _ in e.columns(model.robot)) if e is effect]
    before = prepared.model.model if isinstance(prepared.model, pid.Estimate) else prepared.model
    old = {c.name: v for c, v in zip(before.columns, before.theta, strict=True)}
    change = [model.theta[i] - old.get(model.columns[i].name, 0.0) for i in mine]
    regressor = build_regressor(model.robot, [effect], signals, FILTER, model=model)
    truth = filtered([held.alone])
    rows = np.isin(np.round(truth.time, 6), np.round(regressor.time, 6))
    error, hidden_torque = regressor.predict(np.array(change)) - truth.torque[rows], truth.torque[rows]
    if prepared.trial.question == "missing":
        error, hidden_torque = (_beyond(truth, rows, torque) for torque in (error, hidden_torque))
    return float(100 * np.linalg.norm(error) / np.linalg.norm(hidden_torque))


def _beyond(truth: Regressor, rows: NDArray[np.bool_], torque: Array) -> Array:
    """What the ordinary model, refitted, cannot imitate of a torque (M, n): more of it belongs to no single effect."""
    left = np.empty_like(torque)
    for j, own in enumerate(truth.joints):
        Y = own.values[rows]
        left[:, j] = torque[:, j] - Y @ np.linalg.lstsq(Y, torque[:, j], rcond=1e-6)[0]
    return left


def gain_of_oracle(prepared: Prepared, diagnosis: pid.Diagnosis) -> float:
    """The extended model's reduction of RMS on the held-out recording [%] of the oracle's, on the joint that shows it."""
    trial, held = prepared.trial, prepared.changed[-1].recording
    assert diagnosis.estimate is not None
    model = prepared.model
    if trial.question == "missing":
        model = pid.identify(pid.load_robot("ur5"), [t.recording for t in prepared.changed[:2]], filter=FILTER)
    gain = pid.compare(as_estimate(model, FILTER), diagnosis.estimate, [held])
    best = oracle(trial.question, prepared.model, prepared.changed, trial.hidden)
    return float(100 * gain.reduction[trial.joint - 1] / best.reduction[trial.joint - 1])
