"""One trial: an arm without any other physics outside of the catalogue, a cause, and what the diagnosis makes of it."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.effects.learned.curve import LearnedCurve
from studies.learned.causes import OUTSIDE, VARIABLES, Cause, inside, outside, torque
from studies.open_world import motions as motions_of
from studies.open_world.arms import arm
from studies.open_world.bench import DURATION
from studies.open_world.sensors import Sensors
from studies.open_world.taken import Taken, Unsound, take
from studies.open_world.world import FirstWorld
from tests.plant.open_plant import PinocchioPlant
from tests.truth import ArmTruth, Disturbance, HiddenEffect, Motion

Array = NDArray[np.float64]
RUNS = 3  # diagnosed; one more is held out
TRIES = 8
STRETCH = 2.0  # s that a stretch of the held-out recording lasts at least
FAST = 10.0  # rad/s, at which every friction has turned
SEEN = 25  # rows near a point of a curve from which on the recordings have been there


def judge(job: tuple[str, int]) -> dict[str, Any]:
    """The row of a trial of a kind, "outside" or "inside", and number."""
    kind, number = job
    for attempt in range(TRIES):
        seed = 100_000 * (kind == "inside") + 1000 * attempt + number
        try:
            row = _outside(number, seed) if kind == "outside" else _inside(number, seed)
        except Unsound:
            continue
        if row is not None:
            return {"kind": kind, "number": number, **row}
    raise RuntimeError(f"{kind} {number}: no draw of {TRIES} can be simulated")


class Bench:
    """An arm, its instruments, and its motions, from a seed."""

    def __init__(self, seed: int, folder: Path) -> None:
        self.seed, self.folder, self.plant = seed, folder, PinocchioPlant()
        self.arm: ArmTruth = _plain(arm(seed))
        self.sensors: Sensors = FirstWorld().sensors(seed)
        rng = np.random.default_rng([seed, 71])
        self.motions: list[Motion] = [motions_of.fourier(self.arm, rng, DURATION, 0.8) for _ in range(RUNS + 1)]
        (folder / "robot.urdf").write_text(self.arm.urdf, encoding="utf-8")
        self.robot = pid.load_robot(folder / "robot.urdf")
        self.filter = pid.Filter(5.0 if self.sensors.rate < 125 else 8.0)

    def record(
        self, tag: str, effects: tuple[HiddenEffect, ...] = (), disturbances: tuple[Disturbance, ...] = ()
    ) -> list[pid.Recording]:
        """All recordings of the arm with something hidden in it; the last is held out."""
        taken: list[Taken] = [
            take(self.folder / f"{tag}{k}", self.plant, self.arm, motion, self.sensors, 10 * self.seed + k, 0.0, effects, disturbances, False)
            for k, motion in enumerate(self.motions)
        ]  # fmt: skip
        return [one.recording for one in taken]


def _plain(whole: ArmTruth) -> ArmTruth:
    """An arm whose friction and links the default model describes: nothing is missing from it but what a trial hides."""
    friction = replace(whole.friction, kind="dry", breakaway=whole.friction.coulomb, per_degree=np.zeros(whole.joints))
    return replace(whole, background=(), friction=friction)


def _outside(number: int, seed: int) -> dict[str, Any] | None:
    name = OUTSIDE[number % len(OUTSIDE)]
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(seed, Path(folder))
        cause, joint = outside(name, bench.arm, bench.motions, np.random.default_rng([seed, 73]))
        runs, clean = bench.record("changed", disturbances=(cause,)), bench.record("clean")
    found, model = _diagnosed(bench, runs)
    oracle = pid.identify(bench.robot, clean[:-1], filter=bench.filter)
    errors = [float(pid.validate(m, [held]).rms[joint]) for m, held in ((model, runs[-1]), (oracle, clean[-1]))]
    variable = VARIABLES.get(name, "position")
    causes = [f for f in found.findings if f.grade != "hint"]
    right = [f for f in causes if f.joints == (joint + 1,) and pid.CATALOGUE[f.effect].variable == variable]
    return {
        "cause": name,
        "joint": joint + 1,
        "variable": variable,
        "named": [[f.effect, list(f.joints), f.grade] for f in found.findings],
        "right": bool(right) and next(f for f in causes if joint + 1 in f.joints) in right,
        "learned": any(pid.CATALOGUE[f.effect].family is pid.Family.LEARNED for f in right),
        "wrong_cause": any(f.grade == "cause" and f not in right for f in found.findings),
        "curve_percent": _apart(bench.robot, model.model, variable, cause, joint, runs[:-1]),
        "before": float(found.before.rms[joint]),
        "after": errors[0],
        "oracle": errors[1],
        "after_where_recorded": _where_recorded(model, joint, runs),
        "oracle_where_recorded": _where_recorded(oracle, joint, clean),
    }


def _inside(number: int, seed: int) -> dict[str, Any] | None:
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(seed, Path(folder))
        rng = np.random.default_rng([seed, 79])
        hidden = inside(number, bench.arm, bench.motions, bench.plant.effects, rng)
        if hidden is None:
            return None
        runs = bench.record("changed", effects=(hidden,))
    found, _ = _diagnosed(bench, runs)
    learned = [f for f in found.findings if pid.CATALOGUE[f.effect].family is pid.Family.LEARNED]
    return {
        "cause": hidden.effect,
        "joints": list(hidden.joints),
        "named": [[f.effect, list(f.joints), f.grade] for f in found.findings],
        "learned_cause": any(f.grade == "cause" for f in learned),
        "found": any(f.effect == hidden.effect and f.grade == "cause" for f in found.findings),
    }


def _diagnosed(bench: Bench, runs: list[pid.Recording]) -> tuple[pid.Diagnosis, pid.Estimate]:
    """What the diagnosis says is missing from a model of the same recordings, and the extended model."""
    estimate = pid.identify(bench.robot, runs[:-1], filter=bench.filter)
    found = pid.diagnose_motion(estimate, runs[:-1], runs[-1:])
    return found, found.estimate or estimate


def _where_recorded(model: pid.Estimate, joint: int, runs: list[pid.Recording]) -> float | None:
    """RMS [N m|N] of a joint over those stretches of the held-out recording in which it is where the others were; None
    where these are too short."""
    q, held = np.concatenate([run.q[:, joint] for run in runs[:-1]]), runs[-1]
    inside = (held.q[:, joint] >= q.min()) & (held.q[:, joint] <= q.max())
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
    stretches = [slice(*map(int, pair)) for pair in edges.reshape(-1, 2)]
    parts = [held.part(s) for s in stretches if held.time[s.stop - 1] - held.time[s.start] >= STRETCH]
    return float(pid.validate(model, parts).rms[joint]) if parts else None


def _apart(
    robot: pid.Robot, model: pid.Model, variable: str, cause: Cause, joint: int, runs: list[pid.Recording]
) -> float | None:
    """The largest distance [% of its range] of the learned curve from the truth where recordings were, but for what the model's
    other parameters take as well: an offset, gravity; Coulomb and viscous friction. None without such a curve."""
    curves = [(e, theta) for e, theta in model.effect_parameters() if isinstance(e, LearnedCurve)]
    own = [(e, theta) for e, theta in curves if joint in e.active(robot) and e.variable == variable]
    if not own:
        return None
    effect, theta = own[0]
    x, values, _ = effect.curve(robot, theta, effect.active(robot).index(joint))
    if variable == "velocity":
        true, visited = (
            torque(cause, joint, np.zeros(len(x)), x),
            [np.gradient(run.q[:, joint], run.time) for run in runs],
        )
        others = np.column_stack([np.ones(len(x)), x, np.sign(x)])
    else:
        true, visited = torque(cause, joint, x, np.full(len(x), FAST)), [run.q[:, joint] for run in runs]
        others = np.column_stack([np.ones(len(x)), *([np.sin(x), np.cos(x)] if _weighs(robot, joint) else [])])
    every = np.sort(np.concatenate(visited))
    near = (x[-1] - x[0]) / 50
    seen = np.searchsorted(every, x + near) - np.searchsorted(every, x - near) > SEEN
    apart = (values - true)[seen]
    apart = apart - others[seen] @ np.linalg.lstsq(others[seen], apart, rcond=None)[0]
    return float(100 * np.abs(apart).max() / np.ptp(true[seen]))


def _weighs(robot: pid.Robot, joint: int) -> bool:
    """Whether a link's weight loads a joint, so that gravity takes a part of any torque over its position."""
    q = np.random.default_rng(0).uniform(-1, 1, (20, robot.n))
    still = np.zeros_like(q)
    load = pid.Model.nominal(robot, ["rigid_body"]).torque(pid.Signals.of_states(q, still, still))
    return bool(np.abs(load[:, joint]).max() > 1e-9 * np.abs(load).max())
