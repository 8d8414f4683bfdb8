"""Causes at one joint, drawn for an arm: where the part is worn, and at what speed or time it matters."""

from __future__ import annotations

import numpy as np

from studies.open_world_second import joint_causes as joint
from studies.open_world_second.outside import Draw, Drawn, any_joint
from studies.open_world_second.survey import Survey
from tests.truth import ArmTruth


def _rubber_stop(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j, side = any_joint(arm, rng), float(rng.choice([-1.0, 1.0]))
    edge = usual.quantile(j, 0.5 + side * rng.uniform(0.05, 0.2))
    spread = usual.spread(j)
    cause = joint.RubberStop(joint=j, size=0.0, edge=edge, side=side, rounding=0.02 * spread)
    return "position", cause, 30 * usual.load[j] / spread


def _chipped_tooth(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j = any_joint(arm, rng)
    pitch = usual.spread(j) * rng.uniform(0.2, 0.5)
    wide = pitch * rng.uniform(0.04, 0.1)
    at = usual.quantile(j, rng.uniform(0.3, 0.7))
    return "position", joint.ChippedTooth(joint=j, size=0.0, at=at, wide=wide, pitch=pitch), 3 * usual.load[j]


def _resonant_speed(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j = any_joint(arm, rng)
    speeds = np.abs(np.concatenate([part.v[:, j] for part in usual.stretches]))
    critical = float(np.quantile(speeds[speeds > 0.02 * arm.top_speed[j]], rng.uniform(0.4, 0.75)))
    cause = joint.ResonantSpeed(joint=j, size=0.0, critical=critical, wide=critical * rng.uniform(0.15, 0.35))
    return "velocity", cause, 3 * usual.load[j]


def _dragging_brake(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j = any_joint(arm, rng)
    cause = joint.DraggingBrake(
        joint=j,
        size=0.0,
        period=float(rng.uniform(6, 14)),
        phase=float(rng.uniform(0, 2 * np.pi)),
        slow=float(0.03 * arm.top_speed[j]),
        per_turn=float(2 * np.pi / usual.spread(j) * rng.uniform(0.5, 2)),
    )
    return "time", cause, 2 * usual.load[j]


def _relaxing_seal(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j = any_joint(arm, rng)
    cause = joint.RelaxingSeal(joint=j, size=0.0, memory=float(rng.uniform(0.3, 2.0)))
    return "velocity", cause, 50 * usual.load[j] / usual.spread(j)


JOINT_KINDS: dict[str, Draw] = {
    "rubber_stop": _rubber_stop,
    "chipped_tooth": _chipped_tooth,
    "resonant_speed": _resonant_speed,
    "dragging_brake": _dragging_brake,
    "relaxing_seal": _relaxing_seal,
}
