"""One hidden arm, recorded in sessions of one minute until every hidden effect is named alone with its value: three ways."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.diagnosis.next_session.plan import plan_next
from physident.excitation.limits.robot_limits import with_limits
from physident.excitation.motion.motion import Motion
from physident.excitation.session.pieces import LENGTH, cell_of, make_pieces
from physident.excitation.session.plan import Budget
from studies.open_world.bench import CACHE, DURATION, Bench, bench, identified
from studies.open_world.causes import Ground, draw, scaled
from studies.open_world.scale import scale_of
from studies.open_world.scoring import split
from studies.open_world.sizing import pilot, residual_rms, strength
from studies.open_world.taken import Unsound, take
from tests.truth import HiddenEffect

Array = NDArray[np.float64]
Way = Literal["planned", "random", "designed"]
WAYS: tuple[Way, ...] = ("planned", "random", "designed")
SESSIONS = 4  # of a minute, at most
PIECES = 4  # of a session: three to diagnose and one held out
GROUP = 25  # the set of arms, which no other study uses
WITHIN = 10.0  # % of a value
RATE = 125.0  # Hz of every recording after the change: a session is diagnosed within a minute of processor time
REST = 0.4  # s at standstill at both ends of a recording
TARGET = (10.0, 40.0)  # % of a recording's RMS that an oracle would remove
# effects whose value is one number, so that a tenth of it has one meaning
PLAIN = ("coulomb_friction", "viscous_friction", "rotor_inertia", "load_dependent_friction", "torque_constant", "torque_offset",
         "joint_spring", "payload", "friction_asymmetry", "joint_zero_offset", "time_delay")  # fmt: skip
POOL = 12  # motions to plan from
TRIES = 40  # draws of a hidden effect


@dataclass(frozen=True, eq=False)
class Resting:
    """A motion as the plants take it, with rest at both ends."""

    motion: Motion

    @property
    def duration(self) -> float:
        """How long it lasts [s]."""
        return self.motion.duration + 2 * REST

    def states(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities, accelerations (N, n) at times (N,) [s]."""
        s = self.motion.states(np.asarray(time) - REST)
        return s.q, s.v, s.a


@dataclass(frozen=True, eq=False)
class HiddenArm:
    """An arm of the open world, before pinocchio's plant, with the effects that are hidden in it, and where it may move."""

    index: int
    one: Bench
    hidden: tuple[HiddenEffect, ...]
    estimate: pid.Estimate
    robot: pid.Robot

    def record(self, name: str, motion: Motion, seed: int) -> pid.Recording:
        """A recording of the arm; from disk where it was made before."""
        path = folder_of(self.index) / name
        one = self.one
        taken = take(path, one.plant, one.arm, Resting(motion), one.sensors, seed, 0.0, self.hidden, (), known=False)
        return taken.recording


def folder_of(index: int) -> Path:
    """Where the recordings of an arm are kept."""
    return CACHE / "active" / f"arm{index:02d}"


def hidden_arm(index: int) -> HiddenArm:
    """The arm of an index with one to three effects in turn, each as strong as the target says on an ordinary motion."""
    place = 2 * index  # the even ones stand before pinocchio's plant
    one = bench("first", GROUP, place)
    one = replace(one, sensors=replace(one.sensors, rate=RATE))
    path = folder_of(index) / "healthy.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    identified("first", GROUP, place).save(path)
    estimate = pid.load_estimate(path)
    rng = np.random.default_rng([GROUP, index, 1])
    ground = Ground(one.arm, scale_of(one.arm), DURATION)
    healthy = one.record(folder_of(index) / "healthy", 10 * index, 0.0)
    noise = residual_rms(one, estimate, [healthy])
    hidden: list[HiddenEffect] = []
    for _ in range(TRIES):
        if len(hidden) == 1 + index % 3:
            break
        plain = [known for known in PLAIN if known != "payload" or one.arm.joints > 2]  # two show no mass by itself
        name = str(rng.choice([known for known in plain if known not in {h.effect for h in hidden}]))
        guess = draw(name, ground, rng)
        if guess is None:
            continue
        seen = float(np.max(pilot(one, guess, 10 * index, 0.0, False) / noise))
        factor = strength(float(rng.uniform(*TARGET))) / max(seen, 1e-9)
        hidden += [scaled(guess, factor)] if factor < 1 else []
    arm = one.arm
    bounds = {"lower": arm.lower, "upper": arm.upper, "speed": arm.top_speed, "acceleration": arm.top_acceleration}
    text = " ".join(f"{key}={','.join(repr(float(v)) for v in values)}" for key, values in bounds.items())
    return HiddenArm(index, one, tuple(hidden), estimate, with_limits(one.robot, text))


def run_arm(index: int, way: Way, sessions: int = SESSIONS) -> dict[str, Any]:
    """The sessions of one way: after how many minutes every effect is named alone with its value, and what was named falsely."""
    begun = time.process_time()
    row: dict[str, Any] = {"arm": index, "way": way, "minutes": None, "false": [], "history": []}
    try:
        arm = hidden_arm(index)
        row |= {
            "name": arm.one.arm.name,
            "friction": arm.one.arm.friction.kind,
            "hidden": [asdict(h) for h in arm.hidden],
        }
        fitted: list[pid.Recording] = []
        found: pid.Diagnosis | None = None
        for number in range(1, sessions + 1):
            motions = _motions(arm, way, number, found)
            recorded = [
                arm.record(f"{way}_{number}_{k}", motion, 100_000 * index + 1000 * WAYS.index(way) + 10 * number + k)
                for k, motion in enumerate(motions)
            ]
            fitted += recorded[:-1]
            found = pid.diagnose_motion(arm.estimate, fitted, recorded[-1:])
            right, false = judged(arm.hidden, found)
            row["history"].append({"session": number, "right": right, "false": false})
            row["false"] += [one for one in false if one not in row["false"]]
            if all(right):
                row["minutes"] = number
                break
    except (pid.PhysidentError, Unsound) as refusal:
        row["refused"] = f"{type(refusal).__name__}: {refusal}"
    return row | {"seconds": time.process_time() - begun}


def _motions(arm: HiddenArm, way: Way, number: int, found: pid.Diagnosis | None) -> list[Motion]:
    """The motions of a session of a minute, the last of them held out."""
    seed = 1000 * arm.index + 10 * number
    if way == "designed":
        model = replace(arm.estimate, model=replace(arm.estimate.model, robot=arm.robot))
        design = pid.design_trajectory(
            model, limits="joint", base_frequency=1 / LENGTH, seed=seed, starts=1, generations=10
        )
        return [design.trajectory] * PIECES
    limited = replace(arm.estimate.model, robot=arm.robot)
    if way == "random":
        cell = cell_of(limited, None, "joint", None, 0.02, None, seed)
        pieces = make_pieces(cell, POOL, False, seed)
        order = np.random.default_rng([seed, 2]).permutation([k for k, p in enumerate(pieces) if p.kind == "fourier"])
        return [pieces[k].motion for k in order[:PIECES]]
    budget = Budget(minutes=PIECES * LENGTH / 60, limits="joint", table=None, seed=seed, pool=POOL)
    if found is None:
        estimate = replace(arm.estimate, model=limited)
        session = pid.design_session(
            estimate, minutes=budget.minutes, limits="joint", table=None, seed=seed, pool=POOL,
            repeat=[source.path for source in estimate.sources],
        )  # fmt: skip
    else:
        extended = None if found.extended is None else replace(found.extended, robot=arm.robot)
        session = plan_next(replace(found, model=limited, extended=extended), budget)
    legs = sorted(session.legs, key=lambda leg: leg.holdout)
    return [leg.trajectory for leg in legs]


def judged(hidden: tuple[HiddenEffect, ...], found: pid.Diagnosis) -> tuple[list[bool], list[str]]:
    """For each hidden effect, whether it is named alone with its value within a tenth; and causes that nobody hid."""
    causes, _ = split(found)
    right = [any(_is(truth, f) and _alone(f) and _value_fits(truth, f) for f in causes) for truth in hidden]
    false = []
    for finding in causes:
        for joint in finding.joints or (0,):
            if not any(t.effect == finding.effect and (not t.joints or joint in t.joints) for t in hidden):
                false.append(f"{finding.effect} {joint}".strip())
    return right, false


def _alone(finding: Any) -> bool:
    """Whether no rival is left that some motion could tell apart."""
    return all(rival.inseparable for rival in finding.rivals)


def _is(truth: HiddenEffect, finding: Any) -> bool:
    return finding.effect == truth.effect and set(truth.joints) <= set(finding.joints)


def _value_fits(truth: HiddenEffect, finding: Any) -> bool:
    """Whether the first parameter on the effect's joint changed by the hidden size, to a tenth."""
    mine = [p for p in finding.parameters if not truth.joints or p.joint == truth.joints[0]]
    return bool(mine) and 100 * abs(mine[0].change / truth.size - 1) <= WITHIN
