"""Causes between the joint and the file, drawn for an arm."""

from __future__ import annotations

import numpy as np

from studies.open_world_second import channel_causes as channel
from studies.open_world_second.outside import Draw, Drawn, any_joint
from studies.open_world_second.survey import Survey
from tests.truth import ArmTruth


def _transducer_hysteresis(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j = any_joint(arm, rng)
    return "load", channel.TransducerHysteresis(joint=j, size=0.0), 0.5 * usual.load[j]


def _skewed_clock(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    return "time", channel.SkewedClock(size=0.0), 0.012


def _frozen_samples(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    begins = np.sort(rng.uniform(0.5, 40, int(rng.integers(25, 50))))
    return "time", channel.FrozenSamples(begins=tuple(begins.tolist()), size=0.0), 0.6


def _gain_step(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    return "time", channel.GainStep(joint=any_joint(arm, rng), size=0.0, at=float(rng.uniform(4, 9))), 0.6


def _eccentric_gear(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j = any_joint(arm, rng)
    per_turn = float(2 * np.pi / usual.spread(j) * rng.uniform(0.6, 1.8))
    cause = channel.EccentricGear(joint=j, size=0.0, per_turn=per_turn, phase=float(rng.uniform(0, 2 * np.pi)))
    return "position", cause, 0.5


def _hot_magnets(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j = any_joint(arm, rng)
    cause = channel.HotMagnets(joint=j, size=0.0, usual=float(usual.load[j]), memory=float(rng.uniform(2, 12)))
    return "load", cause, 0.5


def _coarse_torque(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j = any_joint(arm, rng)
    return "load", channel.CoarseTorque(joint=j, size=0.0), 1.5 * usual.load[j]


def _coupled_drives(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j = any_joint(arm, rng)
    source = j - 1 if j else 1
    return "load", channel.CoupledDrives(joint=j, source=source, size=0.0), usual.load[j] / usual.load[source]


def _sagging_supply(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    power = np.concatenate([np.maximum(part.torque * part.v, 0).sum(axis=1) for part in usual.stretches])
    half = float(np.quantile(power[power > 0], rng.uniform(0.3, 0.7)))
    return "other", channel.SaggingSupply(joint=any_joint(arm, rng), size=0.0, half=half), 0.5


CHANNEL_KINDS: dict[str, Draw] = {
    "transducer_hysteresis": _transducer_hysteresis,
    "skewed_clock": _skewed_clock,
    "frozen_samples": _frozen_samples,
    "gain_step": _gain_step,
    "eccentric_gear": _eccentric_gear,
    "hot_magnets": _hot_magnets,
    "coarse_torque": _coarse_torque,
    "coupled_drives": _coupled_drives,
    "sagging_supply": _sagging_supply,
}
