"""What is hidden in a blind trial: an effect, where, its shape, and how strong it may be and still be an arm."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tests.plant.friction import COULOMB, VISCOUS

TIERS = {"weak": (2.0, 4.0), "middle": (10.0, 20.0), "strong": (30.0, 60.0)}  # % of held-out RMS that an oracle removes
QUESTIONS = ("different", "missing", "nominal")
Rng = np.random.Generator


@dataclass(frozen=True)
class Kind:
    """An effect to hide: the plant's ``unit`` magnitude that is scaled, the most of it that an arm can have either way, and
    how its shape is drawn."""

    joints: Callable[[Rng], tuple[int, ...]]
    limit: Callable[[tuple[int, ...]], float]
    signed: bool = False
    lowest: Callable[[tuple[int, ...]], float] | None = None
    shape: Callable[[Rng], dict[str, Any]] = lambda _: {}


def _one(rng: Rng) -> tuple[int, ...]:
    return (int(rng.integers(1, 7)),)


def _arm(_: Rng) -> tuple[int, ...]:
    return ()


def _link(rng: Rng) -> tuple[int, ...]:
    return (int(rng.integers(1, 6)),)


def _pair(rng: Rng) -> tuple[int, ...]:
    first = int(rng.integers(1, 6))
    return (first, first + 1)


def _dry(factor: float) -> Callable[[tuple[int, ...]], float]:
    return lambda joints: factor * COULOMB[joints[0] - 1]


def _wet(factor: float) -> Callable[[tuple[int, ...]], float]:
    return lambda joints: factor * VISCOUS[joints[0] - 1]


def _most(value: float) -> Callable[[tuple[int, ...]], float]:
    return lambda _: value


def _between(rng: Rng, low: float, high: float) -> float:
    """Drawn evenly on a logarithmic scale."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _unit(rng: Rng) -> tuple[float, ...]:
    way = rng.standard_normal(3)
    return tuple(float(x) for x in way / np.linalg.norm(way))


def _touch(rng: Rng) -> dict[str, Any]:
    start = float(rng.uniform(3.0, 13.0))
    return {"start": start, "end": start + 0.5 * int(rng.integers(2, 7)), "direction": _unit(rng)}


def _exponent(rng: Rng) -> dict[str, Any]:
    return {"exponent": float(rng.uniform(0.35, 0.7) if rng.random() < 0.5 else rng.uniform(1.5, 3.0))}


def _warmth(rng: Rng) -> dict[str, Any]:
    return {"time": _between(rng, 4.0, 15.0)} if rng.random() < 0.7 else {"rise": float(rng.uniform(8.0, 20.0))}


KINDS: dict[str, Kind] = {
    "rotor_inertia": Kind(_one, _most(3.0), True, _most(0.1)),
    "viscous_friction": Kind(_one, _wet(3.0), True, _wet(0.4)),
    "coulomb_friction": Kind(_one, _dry(3.0), True, _dry(0.5)),
    "friction_asymmetry": Kind(_one, _wet(0.6), True),
    "stribeck_friction": Kind(_one, _dry(3.0), shape=lambda rng: {"stribeck_speed": _between(rng, 0.04, 0.3)}),
    "nonlinear_viscous_friction": Kind(_one, _wet(3.0), shape=_exponent),
    "load_dependent_friction": Kind(_one, _most(0.6)),
    "presliding_hysteresis": Kind(_one, lambda j: 3.0 * COULOMB[j[0] - 1], shape=lambda rng: {"slip": _between(rng, 0.003, 0.04)}),
    "warm_up": Kind(_one, _most(1.5), shape=_warmth),
    "coupled_friction": Kind(_pair, _dry(3.0), shape=lambda rng: {"viscous": float(rng.uniform(0.0, 1.0))}),
    "torque_constant": Kind(_one, _most(0.5), True),
    "torque_offset": Kind(_one, _most(20.0), True),
    "time_delay": Kind(_arm, _most(0.04)),
    "torque_ripple": Kind(
        _one, _most(15.0), shape=lambda rng: {"order": float(rng.integers(1, 41)), "phase": float(rng.uniform(0, 6.28))}
    ),
    "joint_spring": Kind(_one, _most(30.0)),
    "joint_elasticity": Kind(_one, _most(3e-4)),
    "payload": Kind(_arm, _most(10.0), shape=lambda rng: {"com": tuple(rng.uniform((-0.08, -0.08, 0.06), (0.08, 0.08, 0.22)))}),
    "link_inertia": Kind(_link, _most(6.0)),
    "gravity_tilt": Kind(_arm, _most(0.3), shape=lambda rng: {"direction": float(rng.uniform(0, 6.28))}),
    "joint_zero_offset": Kind(_one, _most(0.12), True),
    "contact": Kind(_arm, _most(150.0), shape=_touch),
}  # fmt: skip


@dataclass(frozen=True)
class Hidden:
    """An effect hidden in an arm: where, how strong, with which shape, as the plant's ``hide`` takes it."""

    effect: str
    joints: tuple[int, ...]
    magnitude: float
    shape: tuple[tuple[str, Any], ...]

    def doses(self, magnitude: float | None = None) -> tuple[float, dict[str, Any]]:
        """Magnitude and settings for the plant, where some grow with the magnitude."""
        size = self.magnitude if magnitude is None else magnitude
        shape = dict(self.shape)
        if self.effect == "presliding_hysteresis":  # the plant takes a stiffness: its level over the distance
            return size / shape["slip"], shape
        if self.effect == "coupled_friction":
            return size, {"viscous": shape["viscous"] * abs(size)}
        if self.effect == "warm_up" and "rise" in shape:
            return size / shape["rise"], shape
        return size, shape


def draw(effect: str, rng: Rng) -> Hidden:
    """An effect somewhere, of the largest magnitude, its sign drawn."""
    kind = KINDS[effect]
    joints = kind.joints(rng)
    sign = -1.0 if kind.signed and rng.random() < 0.5 else 1.0
    size = kind.lowest(joints) if sign < 0 and kind.lowest is not None else kind.limit(joints)
    return Hidden(effect, joints, sign * size, tuple(kind.shape(rng).items()))
