"""What a diagnosis is worth: the right cause and joints, nothing beside them, the right value - or rightly nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import physident as pid
from studies.open_world.claims import Key, claims
from studies.open_world.sizing import residual_rms
from studies.open_world.taken import Taken
from studies.open_world.trial import Scene, Trial
from studies.open_world.value import interval, value_error
from studies.open_world.world import OutsideCause

Array = NDArray[np.float64]
NAMES = {  # what the kinds of background of both worlds are, or are functions of
    **dict.fromkeys(("CrossTalk", "Crosstalk"), "torque_crosstalk"),
    **dict.fromkeys(("Cable", "Cogging", "DressPack", "WanderingCogging"), "learned_position"),
    **dict.fromkeys(("BentFriction", "ThickeningGrease"), "learned_velocity"),
    "WanderingZero": "learned_time",
}
LAWS = {  # effects of the catalogue whose own description names the thing, though not its exact shape
    **dict.fromkeys(("Cable", "DressPack"), "joint_spring"),
    **dict.fromkeys(("Cogging", "WanderingCogging"), "torque_ripple"),
}
MEANT_FOR = {
    "sensor_lag": "torque_delay"
}  # causes outside that an effect of the catalogue is meant for, though by another law
FALLS = 1.05  # breakaway over sliding friction from which a velocity law's dip is worth a name


@dataclass(frozen=True)
class Score:
    """Of a diagnosis of hidden effects of the catalogue.

    ``first``: the first cause, or its class of rivals, is a hidden one; ``alone``: without a rival; ``size`` of its class;
    ``named``: every hidden effect is a cause; ``others``: false causes beside them, each joint of a finding counted;
    ``own``: causes that are true of the arm's friction and were not hidden; ``lesser``: a hidden effect is listed as less than a cause. ``error`` [%] of
    the value, and the ends of its 95 % ``interval`` in units of the true value, where one value decides; ``gain`` [%] of held-out RMS on the
    joint that shows it. ``told`` in words.
    """

    first: bool
    alone: bool
    size: int
    named: bool
    others: int
    own: int
    lesser: bool
    error: float | None
    interval: tuple[float, float] | None
    gain: float | None
    told: str
    verdict: str


@dataclass(frozen=True)
class OutsideScore:
    """Of a diagnosis of a cause outside of the catalogue: ``wrong``: a false name is given as a cause; ``variable``: a learned curve of
    the right variable is, on a right joint, None where no variable is right; ``joint``: whatever is told is on a right joint;
    ``described``: there is a description on some joint; ``right_description``: on a right joint; ``silent``: neither name nor
    description. ``gain`` [%] as above."""

    wrong: bool
    variable: bool | None
    joint: bool
    described: bool
    right_description: bool
    silent: bool
    gain: float | None
    told: str
    described_as: str
    verdict: str


@dataclass(frozen=True)
class TwinScore:
    """Of a diagnosis of clean recordings: causes that are ``false``, and ones that are true of the arm's friction (``own``)."""

    false: int
    own: int
    described: bool
    told: str
    verdict: str


def score(scene: Scene, trial: Trial, changed: Sequence[Taken], diagnosis: Any) -> Score:
    """Compare a diagnosis of changed recordings with what was hidden."""
    causes, rest = split(diagnosis)
    keys: list[Key] = [(h.effect, h.joints) for h in trial.hidden]
    own = true_of(scene) | _background(scene, LAWS)
    found = [claims(f) for f in causes]
    strange = [c for c in found if any(_any(claim, keys) or not _any(claim, own) for claim in c)]
    right = [claim for c in strange[:1] for claim in c if _any(claim, keys)]
    everything = [claim for c in found for claim in c]
    exact = [f for f in causes if len(keys) == 1 and any(keys[0] == k for k in _told_keys(f))]
    return Score(
        first=bool(right),
        alone=bool(right) and len(right[0]) == 1,
        size=len(right[0]) if right else 0,
        named=all(any(k in claim for claim in everything) for k in keys),
        others=sum(not _any(claim, keys) and not _any(claim, own) for claim in everything),
        own=sum(not _any(claim, keys) and _any(claim, own) for claim in everything),
        lesser=any(_any(claim, keys) for f in rest for claim in claims(f)),
        error=value_error(scene, trial, changed, exact[0], diagnosis) if exact else None,
        interval=interval(trial, exact[0]) if exact else None,
        gain=gain(scene, trial, changed, diagnosis),
        told=told(diagnosis),
        verdict=diagnosis.verdict,
    )


def _any(claim: set[Key], keys: Iterable[Key]) -> bool:
    return any(key in claim for key in keys)


def _told_keys(finding: Any) -> list[Key]:
    """The effect on each joint that a finding names, without rivals."""
    bare = SimpleNamespace(effect=finding.effect, joints=finding.joints, rivals=())
    return [key for claim in claims(bare) for key in claim]


def score_outside(
    scene: Scene, trial: Trial, cause: OutsideCause, changed: Sequence[Taken], diagnosis: Any, twin: Callable[[], Any]
) -> OutsideScore:
    """Judge a diagnosis of recordings in which something acts that has no name in the catalogue; ``twin`` gives that of the arm without it."""
    causes, rest = split(diagnosis)
    seen = cause.joints or (trial.joint,)  # what acts on the whole arm is looked for where it shows most
    curves = {(name, (j,)) for name in _curves(cause) for j in seen}
    names = curves | {(MEANT_FOR[cause.kind], (j,)) for j in seen if cause.kind in MEANT_FOR}
    own = true_of(scene) | names | _laws_beside(scene, cause, causes, twin)
    false = [f for f in causes if not all(_any(claim, own) for claim in claims(f))]
    right = [f for f in causes if any(_any(claim, names) for claim in claims(f))]
    described, words = descriptions(diagnosis)
    placed = {j for f in (*false, *right, *rest) for j in f.joints} | set(described)
    return OutsideScore(
        wrong=bool(false),
        variable=bool(right) if curves else None,
        joint=any(j in placed for j in seen),
        described=bool(described or right or rest),
        right_description=any(j in described or any(j in f.joints for f in (*right, *rest)) for j in seen),
        silent=not (false or right or described or rest),
        gain=gain(scene, trial, changed, diagnosis),
        told=told(diagnosis),
        described_as=words,
        verdict=diagnosis.verdict,
    )


def _laws_beside(scene: Scene, cause: OutsideCause, causes: Sequence[Any], twin: Callable[[], Any]) -> set[Key]:
    """Names of the arm's background that are true beside a cause from outside.

    Where that cause does not act, every one. Where it does, the name may be a wrong one of the cause: it is the background's if the arm
    without the cause is given it too.
    """
    laws = _background(scene, LAWS)
    beside = {key for key in laws if cause.joints and not set(key[1]) & set(cause.joints)}
    doubtful = laws - beside
    if not any(_any(claim, doubtful) for f in causes for claim in claims(f)):
        return beside
    return beside | doubtful & {key for f in split(twin())[0] for claim in claims(f) for key in claim}


def _curves(cause: OutsideCause) -> set[str]:
    """The learned effects that describe a cause from outside rightly: a curve of its variable; what is tight in places is friction there."""
    if cause.variable == "other":
        return set()
    if cause.kind == "tight_spot":
        return {"learned_position_friction"}
    # what a drive or a sensor makes of its torque, and what a gear makes of its load
    return {"learned_load", "learned_torque"} if cause.variable == "load" else {f"learned_{cause.variable}"}


def score_twin(scene: Scene, diagnosis: Any) -> TwinScore:
    """Judge a diagnosis of recordings in which nothing was hidden."""
    causes, rest = split(diagnosis)
    own = true_of(scene) | _background(scene, LAWS)
    everything = [claim for f in causes for claim in claims(f)]
    true = sum(_any(claim, own) for claim in everything)
    described, _ = descriptions(diagnosis)
    return TwinScore(len(everything) - true, true, bool(described or rest), told(diagnosis), diagnosis.verdict)


def split(diagnosis: Any) -> tuple[list[Any], list[Any]]:
    """Findings that are causes, and those that are graded as less."""
    grades = [getattr(f, "grade", "cause") for f in diagnosis.findings]
    causes = [f for f, grade in zip(diagnosis.findings, grades, strict=True) if grade == "cause"]
    return causes, [f for f, grade in zip(diagnosis.findings, grades, strict=True) if grade != "cause"]


def true_of(scene: Scene) -> set[Key]:
    """Effects of the catalogue that nobody hid and that yet are true of the arm.

    To a model that was identified in the cold, or that knows the arm as it is there, friction that fell in the warmth is a change. A
    model that never saw the arm misses its background, its bristles, and the dip of breakaway, which friction of every kind has.
    """
    own = _fell(scene)
    if scene.question == "different":
        return own
    own |= _background(scene, NAMES)
    friction, joints = scene.bench.arm.friction, range(1, scene.bench.arm.joints + 1)
    dips = [j for j in joints if friction.breakaway[j - 1] > FALLS * friction.coulomb[j - 1]]
    own |= {(name, (j,)) for j in dips for name in ("stribeck_friction", "learned_velocity")}
    if friction.kind == "bristle":
        own |= {("presliding_hysteresis", (j,)) for j in joints}
    return own


def _fell(scene: Scene) -> set[Key]:
    """What friction that fell in the warmth is called, where the model knows it from the cold."""
    if scene.refitted or not any(scene.warmer(k) > 0 for k in range(2)):
        return set()
    fell = [j for j, share in enumerate(scene.bench.arm.friction.per_degree, 1) if share > 0]
    own: set[Key] = {(name, (j,)) for j in fell for name in ("coulomb_friction", "viscous_friction")}
    return own | ({("friction_level", ())} if fell else set())


def _background(scene: Scene, names: Mapping[str, str]) -> set[Key]:
    """What the background of a model's own recordings is called, joint by joint."""
    if scene.question == "different":
        return set()
    own: set[Key] = set()
    for one in scene.bench.arm.background:
        name = names.get(type(one).__name__)
        if name is not None:
            own |= {(name, (int(j) + 1,)) for j in np.flatnonzero(getattr(one, "size", 0.0))}
    return own


def descriptions(diagnosis: Any) -> tuple[tuple[int, ...], str]:
    """Joints on which structure is described without a name, and the words."""
    structured = diagnosis.structured or diagnosis.may_hide
    words = "; ".join(f"{r.joint}: {r.description}" for r in structured)
    return tuple(r.joint for r in structured), words


def told(diagnosis: Any) -> str:
    """All findings in one line, with the grade of those that are less than causes."""
    return "; ".join(_text(f) for f in diagnosis.findings) or "nothing"


def gain(scene: Scene, trial: Trial, changed: Sequence[Taken], diagnosis: Any) -> float | None:
    """Reduction of RMS [%] by the extended model on the held-out recording, on the joint that shows the cause most."""
    if diagnosis.estimate is None:
        return None
    held = [changed[-1]]
    model = scene.model
    if scene.refitted:
        runs = [t.recording for t in changed[:2]]
        model = pid.identify(scene.bench.robot, runs, filter=scene.bench.filter)
    before = residual_rms(scene.bench, model, held)
    after = residual_rms(scene.bench, diagnosis.estimate, held)
    joint = trial.joint - 1
    return float(100 * (1 - after[joint] / before[joint]))


def _text(f: Any) -> str:
    """A finding with its rivals, what it takes and leaves [%] and its stability, in brackets where it is less than a cause."""
    names = [(f.effect, f.joints), *((r.effect, r.joints) for r in f.rivals)]
    text = " or ".join(f"{effect} {','.join(map(str, joints))}".strip() for effect, joints in names)
    if getattr(f, "takes_percent", None) is not None:
        stability = "" if f.stability is None else f", stability {f.stability:.2f}"
        text += f" [takes {f.takes_percent:.0f}, leaves {f.leaves_percent:.0f}{stability}]"
    grade = getattr(f, "grade", "cause")
    return text if grade == "cause" else f"({grade}: {text})"
