"""The kinds of causes outside the catalogue, each drawn for one arm."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from studies.open_world_second import channel_causes as channel
from studies.open_world_second import joint_causes as joint
from studies.open_world_second import tool_causes as tool
from studies.open_world_second.outside import Outside, Variable, measured
from studies.open_world_second.structure import STRUCTURES
from studies.open_world_second.survey import Survey, survey
from tests.truth import ArmTruth

Array = NDArray[np.float64]
Drawn = tuple[Variable, Any, float]
"""What a cause goes with, the disturbance at size 0, and the largest size in the disturbance's own unit."""


def draw(name: str, arm: ArmTruth, rng: np.random.Generator) -> Outside:
    """A cause of the named kind on an arm; KeyError for an unknown name."""
    usual = survey(arm)
    if name in STRUCTURES:
        return STRUCTURES[name](arm, usual, rng)
    variable, disturbance, ceiling = KINDS[name](arm, usual, rng)
    return measured(name, variable, disturbance, ceiling, usual)


def _rubber_stop(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j, side = _any(arm, rng), float(rng.choice([-1.0, 1.0]))
    edge = usual.quantile(j, 0.5 + side * rng.uniform(0.1, 0.3))
    spread = usual.spread(j)
    cause = joint.RubberStop(joint=j, size=0.0, edge=edge, side=side, rounding=0.02 * spread)
    return "position", cause, 30 * usual.load[j] / spread


def _chipped_tooth(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j = _any(arm, rng)
    pitch = usual.spread(j) * rng.uniform(0.2, 0.5)
    wide = pitch * rng.uniform(0.04, 0.1)
    at = usual.quantile(j, rng.uniform(0.3, 0.7))
    return "position", joint.ChippedTooth(joint=j, size=0.0, at=at, wide=wide, pitch=pitch), 3 * usual.load[j]


def _resonant_speed(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j = _any(arm, rng)
    speeds = np.abs(np.concatenate([part.v[:, j] for part in usual.stretches]))
    critical = float(np.quantile(speeds[speeds > 0.02 * arm.top_speed[j]], rng.uniform(0.4, 0.75)))
    cause = joint.ResonantSpeed(joint=j, size=0.0, critical=critical, wide=critical * rng.uniform(0.15, 0.35))
    return "velocity", cause, 3 * usual.load[j]


def _dragging_brake(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j = _any(arm, rng)
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
    j = _any(arm, rng)
    cause = joint.RelaxingSeal(joint=j, size=0.0, memory=float(rng.uniform(0.3, 2.0)))
    return "velocity", cause, 50 * usual.load[j] / usual.spread(j)


def _stirred_fluid(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    return "velocity", tool.StirredFluid(urdf=arm.urdf, tool=arm.tool, size=0.0), 500.0


def _magnetic_drag(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    places = _places(arm, usual)
    normal = _way(rng)
    through = places[int(rng.integers(len(places)))]
    reach = float(np.std((places - through) @ normal) * rng.uniform(0.3, 0.8))
    cause = tool.MagneticDrag(
        urdf=arm.urdf, tool=arm.tool, size=0.0, through=through, normal=normal, reach=max(reach, 0.03)
    )
    return "velocity", cause, 2000.0


def _taut_cord(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    places = _places(arm, usual)
    anchor = places.mean(axis=0) + rng.uniform(0.8, 1.6) * np.ptp(places, axis=0).max() * _way(rng)
    lengths = np.linalg.norm(places - anchor, axis=1)
    slack = float(np.quantile(lengths, rng.uniform(0.2, 0.6)))
    cause = tool.TautCord(urdf=arm.urdf, tool=arm.tool, size=0.0, anchor=anchor, slack=slack, rounding=0.01)
    return "position", cause, 2000.0


def _pulsating_tool(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    frequency, phase = float(rng.uniform(0.5, 3.0)), float(rng.uniform(0, 2 * np.pi))
    cause = tool.PulsatingTool(urdf=arm.urdf, tool=arm.tool, size=0.0, way=_way(rng), frequency=frequency, phase=phase)
    return "time", cause, 500.0


def _rocking_floor(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    slow, slower = rng.uniform(4, 8), rng.uniform(8, 18)
    first, second = rng.uniform(0, 2 * np.pi, 2)
    cause = tool.RockingFloor(
        urdf=arm.urdf,
        links=arm.links,
        size=0.0,
        periods=(float(slow), float(slower)),
        phases=(float(first), float(second)),
    )
    return "time", cause, 0.12


def _transducer_hysteresis(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j = _any(arm, rng)
    return "load", channel.TransducerHysteresis(joint=j, size=0.0), 0.5 * usual.load[j]


def _skewed_clock(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    return "time", channel.SkewedClock(size=0.0), 0.012


def _frozen_samples(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    begins = np.sort(rng.uniform(0.5, 40, int(rng.integers(25, 50))))
    return "time", channel.FrozenSamples(begins=tuple(begins.tolist()), size=0.0), 0.6


def _gain_step(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    return "time", channel.GainStep(joint=_any(arm, rng), size=0.0, at=float(rng.uniform(4, 9))), 0.6


def _eccentric_gear(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j = _any(arm, rng)
    per_turn = float(2 * np.pi / usual.spread(j) * rng.uniform(0.6, 1.8))
    cause = channel.EccentricGear(joint=j, size=0.0, per_turn=per_turn, phase=float(rng.uniform(0, 2 * np.pi)))
    return "position", cause, 0.5


def _hot_magnets(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j = _any(arm, rng)
    cause = channel.HotMagnets(joint=j, size=0.0, usual=float(usual.load[j]), memory=float(rng.uniform(2, 12)))
    return "load", cause, 0.5


def _coarse_torque(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j = _any(arm, rng)
    return "load", channel.CoarseTorque(joint=j, size=0.0), 1.5 * usual.load[j]


def _coupled_drives(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    j = _any(arm, rng)
    source = j - 1 if j else 1
    return "load", channel.CoupledDrives(joint=j, source=source, size=0.0), usual.load[j] / usual.load[source]


def _sagging_supply(arm: ArmTruth, usual: Survey, rng: np.random.Generator) -> Drawn:
    power = np.concatenate([(part.torque * part.v).sum(axis=1) for part in usual.stretches])
    half = float(np.quantile(power[power > 0], rng.uniform(0.3, 0.7)))
    return "other", channel.SaggingSupply(joint=_any(arm, rng), size=0.0, half=half), 0.5


def _any(arm: ArmTruth, rng: np.random.Generator) -> int:
    return int(rng.integers(arm.joints))


def _way(rng: np.random.Generator) -> Array:
    """A random direction (3,)."""
    way = rng.normal(size=3)
    return way / np.linalg.norm(way)


def _places(arm: ArmTruth, usual: Survey) -> Array:
    """Where the tool goes (N, 3) [m] on the survey."""
    poses = np.concatenate([part.q[::10] for part in usual.stretches])
    return np.array([tool.tool_at(arm.urdf, arm.tool, q)[0] for q in poses])


KINDS: dict[str, Callable[[ArmTruth, Survey, np.random.Generator], Drawn]] = {
    "rubber_stop": _rubber_stop,
    "chipped_tooth": _chipped_tooth,
    "resonant_speed": _resonant_speed,
    "dragging_brake": _dragging_brake,
    "relaxing_seal": _relaxing_seal,
    "stirred_fluid": _stirred_fluid,
    "magnetic_drag": _magnetic_drag,
    "taut_cord": _taut_cord,
    "pulsating_tool": _pulsating_tool,
    "rocking_floor": _rocking_floor,
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
NAMES = (*KINDS, *STRUCTURES)
