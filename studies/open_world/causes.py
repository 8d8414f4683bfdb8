"""Effects of the catalogue to hide: on which joints, with what shape, and how large they may be and still be that arm's."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from studies.open_world.scale import Scale
from tests.truth import ArmTruth, HiddenEffect

Rng = np.random.Generator
Joints = tuple[int, ...]
TIERS = {"weak": (2.0, 4.0), "middle": (10.0, 20.0), "strong": (30.0, 60.0)}  # % of held-out RMS that an oracle removes
ONCE = frozenset({"contact", "dropped_load"})  # happens in one recording alone, the first


@dataclass(frozen=True, eq=False)
class Ground:
    """What an effect is scaled to: the arm, its sizes, and how long its recordings last [s]."""

    arm: ArmTruth
    scale: Scale
    duration: float


@dataclass(frozen=True)
class Kind:
    """An effect: its joints (None: this arm has no place for it), the largest size up, the largest down (0: only up), its shape."""

    joints: Callable[[Ground, Rng], Joints | None]
    up: Callable[[Ground, Joints, dict[str, Any]], float]
    down: Callable[[Ground, Joints], float] = lambda _g, _j: 0.0
    shape: Callable[[Ground, Joints, Rng], dict[str, Any]] = lambda _g, _j, _r: {}


def draw(effect: str, ground: Ground, rng: Rng) -> HiddenEffect | None:
    """An effect somewhere, of the largest size, its sign drawn; None where this arm has no place for it."""
    kind = KINDS[effect]
    joints = kind.joints(ground, rng)
    if joints is None:
        return None
    shape = kind.shape(ground, joints, rng)
    fall = kind.down(ground, joints)
    size = -fall if fall and rng.random() < 0.5 else kind.up(ground, joints, shape)
    return HiddenEffect(effect=effect, joints=joints, size=float(size), shape=shape)


def scaled(hidden: HiddenEffect, factor: float) -> HiddenEffect:
    """The same effect, larger or smaller."""
    shape = dict(hidden.shape)
    if "viscous" in shape:
        shape["viscous"] *= factor
    return replace(hidden, size=hidden.size * factor, shape=shape)


def _any(g: Ground, rng: Rng) -> Joints:
    return (int(rng.integers(1, g.arm.joints + 1)),)


def _turning(g: Ground, rng: Rng) -> Joints:
    return (int(rng.choice(np.flatnonzero(~g.scale.prismatic))) + 1,)


def _whole(_g: Ground, _r: Rng) -> Joints:
    return ()


def _inner(g: Ground, rng: Rng) -> Joints:
    return (int(rng.integers(1, g.arm.joints)),)


def _neighbours(g: Ground, rng: Rng) -> Joints | None:
    """Two joints in a row of which neither slides: a sum of radians and metres is no motion of a gear."""
    first = [j for j in range(g.arm.joints - 1) if not g.scale.prismatic[j : j + 2].any()]
    if not first:
        return None
    j = int(rng.choice(first)) + 1
    return (j, j + 1)


def _rotor(factor: float) -> Callable[..., float]:
    return lambda g, j, *_: factor * g.arm.rotor_inertia[j[0] - 1]


def _coulomb(factor: float) -> Callable[..., float]:
    return lambda g, j, *_: factor * g.arm.friction.coulomb[j[0] - 1]


def _viscous(factor: float) -> Callable[..., float]:
    return lambda g, j, *_: factor * g.arm.friction.viscous[j[0] - 1]


def _torque(factor: float) -> Callable[..., float]:
    return lambda g, j, *_: factor * g.scale.torque[j[0] - 1]


def _most(value: float) -> Callable[..., float]:
    return lambda *_: value


def _power(g: Ground, j: Joints, shape: dict[str, Any]) -> float:
    """Three times the viscous friction at the joint's top speed."""
    k = j[0] - 1
    top = g.arm.top_speed[k]
    return 3.0 * g.arm.friction.viscous[k] * top / top ** shape["exponent"]


def _stiffness(g: Ground, j: Joints, shape: dict[str, Any]) -> float:
    return 2.0 * g.arm.friction.coulomb[j[0] - 1] / shape["slip"]


def _spring(g: Ground, j: Joints, _: dict[str, Any]) -> float:
    k = j[0] - 1
    return 2.0 * g.scale.torque[k] / (g.arm.upper[k] - g.arm.lower[k])


def _soft(g: Ground, j: Joints, _: dict[str, Any]) -> float:
    """The joint then swings at seven hertz behind its gear [rad/(N m)]."""
    return 1 / (g.scale.inertia[j[0] - 1] * (2 * np.pi * 7.0) ** 2)


def _push(g: Ground, _j: Joints, _s: dict[str, Any]) -> float:
    turning = ~g.scale.prismatic
    return 2.0 * g.scale.torque[turning].max() / g.scale.reach


def _between(rng: Rng, low: float, high: float) -> float:
    """Drawn evenly on a logarithmic scale."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _speed(g: Ground, j: Joints, rng: Rng) -> dict[str, Any]:
    return {"stribeck_speed": _between(rng, 0.03, 0.2) * g.arm.top_speed[j[0] - 1]}


def _exponent(_g: Ground, _j: Joints, rng: Rng) -> dict[str, Any]:
    return {"exponent": float(rng.uniform(0.35, 0.7) if rng.random() < 0.5 else rng.uniform(1.5, 3.0))}


def _slip(g: Ground, j: Joints, rng: Rng) -> dict[str, Any]:
    return {"slip": _between(rng, 0.002, 0.025) * g.arm.top_speed[j[0] - 1]}


def _warmth(_g: Ground, _j: Joints, rng: Rng) -> dict[str, Any]:
    time = _between(rng, 4.0, 15.0)
    return {"time": time} if rng.random() < 0.7 else {"time": time, "rise": float(rng.uniform(8.0, 20.0))}


def _warmest(_g: Ground, _j: Joints, shape: dict[str, Any]) -> float:
    return 1.5 / shape.get("rise", 1.0)


def _wet(g: Ground, j: Joints, rng: Rng) -> dict[str, Any]:
    k = [joint - 1 for joint in j]
    return {"viscous": float(rng.uniform(0.0, 2.0) * g.arm.friction.viscous[k].mean())}


def _line(_g: Ground, _j: Joints, rng: Rng) -> dict[str, Any]:
    return {"order": float(rng.integers(1, 41)), "phase": float(rng.uniform(0, 2 * np.pi))}


def _held(g: Ground, _j: Joints, rng: Rng) -> dict[str, Any]:
    """A load beside the tool's frame, as far from it as a tenth of the arm's reach."""
    com = g.scale.tool + g.scale.reach / 10 * rng.uniform((-1, -1, -0.2), (1, 1, 1.6))
    return {"com": tuple(float(x) for x in com), "radius": 0.04 + 0.02 * g.scale.reach}


def _way(_g: Ground, _j: Joints, rng: Rng) -> dict[str, Any]:
    return {"direction": float(rng.uniform(0, 2 * np.pi))}


def _touch(g: Ground, _j: Joints, rng: Rng) -> dict[str, Any]:
    start = float(rng.uniform(0.15, 0.65) * g.duration)
    way = rng.standard_normal(3)
    way /= np.linalg.norm(way)
    return {"start": start, "end": start + float(rng.uniform(0.8, 3.2)), "direction": tuple(float(x) for x in way)}


def _mass(share: float) -> Callable[..., float]:
    return lambda g, *_: share * g.scale.mass


KINDS: dict[str, Kind] = {
    "rotor_inertia": Kind(_any, _rotor(3.0), _rotor(0.8)),
    "viscous_friction": Kind(_any, _viscous(3.0), _viscous(0.6)),
    "coulomb_friction": Kind(_any, _coulomb(2.0), _coulomb(0.6)),
    "friction_asymmetry": Kind(_any, _viscous(0.6), _viscous(0.6)),
    "stribeck_friction": Kind(_any, _coulomb(2.0), shape=_speed),
    "nonlinear_viscous_friction": Kind(_any, _power, shape=_exponent),
    "load_dependent_friction": Kind(_any, _most(0.6)),
    "presliding_hysteresis": Kind(_any, _stiffness, shape=_slip),
    "warm_up": Kind(_any, _warmest, shape=_warmth),
    "coupled_friction": Kind(_neighbours, _coulomb(2.0), shape=_wet),
    "torque_constant": Kind(_any, _most(0.5), _most(0.4)),
    "torque_offset": Kind(_any, _torque(1.0), _torque(1.0)),
    "time_delay": Kind(_whole, _most(0.04)),
    "torque_ripple": Kind(_turning, _torque(1.0), shape=_line),
    "joint_spring": Kind(_any, _spring),
    "joint_elasticity": Kind(_turning, _soft),
    "payload": Kind(_whole, _mass(0.5), shape=_held),
    "link_inertia": Kind(_inner, _mass(0.35)),
    "gravity_tilt": Kind(_whole, _most(0.3), shape=_way),
    "joint_zero_offset": Kind(_turning, _most(0.12), _most(0.12)),
    "contact": Kind(_whole, _push, shape=_touch),
}
