"""Causes that no law of the catalogue describes, each on one joint and of a stated share of its torque; and causes that one does."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from studies.open_world.background import BentFriction
from studies.open_world.causes import KINDS, Ground, draw, scaled
from studies.open_world.outside_laws import CubicCable, GasSpring, TightSpot
from studies.open_world.scale import prismatic, scale_of
from tests.truth import ArmTruth, Disturbance, HiddenEffect, Motion

Array = NDArray[np.float64]
Rng = np.random.Generator
SHARE = (0.1, 0.4)  # of its joint's RMS torque that a cause is
OUTSIDE = ("tight_spot", "cubic_cable", "gas_spring", "friction_curve", "two_cogs")
VARIABLES = {"friction_curve": "velocity"}  # that a cause depends on, where it is not position
INSIDE = (
    "stribeck_friction", "nonlinear_viscous_friction", "load_dependent_friction", "torque_ripple", "joint_spring",
    "friction_asymmetry", "presliding_hysteresis", "coupled_friction", "torque_constant",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class TwoCogs(Disturbance):
    """Cogging of a motor and of its gear: ``size`` (n,) [N m] times two waves of other ``orders`` [1/rad], of which the second is
    0.7 times the first."""

    size: Array
    orders: tuple[float, float]
    phase: float

    def resist(self, time: float, q: Array, v: Array) -> Array:
        """Torque (n,) [N m]."""
        first, second = self.orders
        return self.size * (np.sin(first * q) + 0.7 * np.sin(second * q + self.phase))


Cause = TightSpot | CubicCable | GasSpring | BentFriction | TwoCogs


def outside(kind: str, arm: ArmTruth, motions: list[Motion], rng: Rng) -> tuple[Cause, int]:
    """A cause of a kind, of a random share of its joint's torque along motions, and its joint (index)."""
    turning = np.flatnonzero(~prismatic(arm.urdf))
    joint = 1 if kind == "gas_spring" and 1 in turning else int(rng.choice(turning))
    unit = np.eye(arm.joints)[joint]
    made = _of_size_one(kind, arm, motions, joint, unit, rng)
    size = float(rng.uniform(*SHARE)) * scale_of(arm).torque[joint] / _rms(made, motions, joint)
    return replace(made, size=size * unit), joint


def _of_size_one(kind: str, arm: ArmTruth, motions: list[Motion], joint: int, unit: Array, rng: Rng) -> Cause:
    q = np.concatenate([_states(motion)[0][:, joint] for motion in motions])
    low, high = float(q.min()), float(q.max())
    place, room = float(rng.uniform(low + 0.3 * (high - low), high - 0.3 * (high - low))), high - low
    if kind == "tight_spot":
        return TightSpot(unit, place, float(rng.uniform(0.05, 0.12)) * room, 0.05 * float(arm.top_speed[joint]))
    if kind == "cubic_cable":
        return CubicCable(unit, place)
    if kind == "gas_spring":
        return GasSpring(unit, place, float(rng.uniform(1.2, 3.0)))
    if kind == "friction_curve":
        hump = float(rng.uniform(0.1, 0.3)) * arm.top_speed
        return BentFriction(unit, hump, np.full(arm.joints, float(rng.uniform(-0.3, 0.3))))
    first = float(rng.uniform(3.0, 7.0))
    return TwoCogs(unit, (first, first * float(rng.uniform(1.4, 1.9))), float(rng.uniform(0, 2 * np.pi)))


def inside(number: int, arm: ArmTruth, motions: list[Motion], able: frozenset[str], rng: Rng) -> HiddenEffect | None:
    """An effect of the catalogue that this arm and its plant can have, at 0.3 of the largest size; None where it has no place."""
    names = [name for name in INSIDE if name in able and name in KINDS]
    hidden = draw(names[number % len(names)], Ground(arm, scale_of(arm), motions[0].duration), rng)
    return None if hidden is None else scaled(hidden, 0.3)


def torque(cause: Cause, joint: int, q: Array, v: Array) -> Array:
    """The torque (N,) [N m] of a cause at positions and velocities (N,) of its joint."""
    states = np.zeros((2, len(q), len(cause.size)))
    states[0, :, joint], states[1, :, joint] = q, v
    return np.array([cause.resist(0.0, *pair)[joint] for pair in zip(*states, strict=True)])


def _states(motion: Motion) -> tuple[Array, Array, Array]:
    return motion.states(np.arange(0.0, motion.duration, 0.02))


def _rms(cause: Cause, motions: list[Motion], joint: int) -> float:
    parts = [_states(motion) for motion in motions]
    q, v = (np.concatenate([part[k][:, joint] for part in parts]) for k in (0, 1))
    return float(np.sqrt(np.mean(torque(cause, joint, q, v) ** 2)))
