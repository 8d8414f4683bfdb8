"""Friction of a joint as a function of its velocity alone. Positive parameters oppose the motion.

A single parameter may be negative in a physical model; the sum of a joint's friction may not push it.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from physident.effects.effect import Array, Cone, Effect, Shape, nonnegative
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

SMOOTHING = 0.01  # rad/s: of the size of a velocity's noise


def smooth_sign(v: Array, width: float = SMOOTHING) -> Array:
    """tanh(v / width), the one smooth sign everywhere; ``v`` and ``width`` in the same unit [rad/s|m/s]."""
    return np.tanh(v / width)


@dataclass(frozen=True)
class VelocityFriction(Effect):
    """Friction that is a function of a joint's own velocity: a subclass gives ``law``, once for every use of it."""

    @abstractmethod
    def law(self, robot: Robot, v: Array) -> Array:
        """Friction (k, N) [N m|N] of each unit of each parameter at velocities (k, N) [rad/s|m/s]."""

    def values(self, robot: Robot, signals: Signals) -> Array:
        return self.law(robot, signals.v.T[self.active(robot)])

    def friction(self, robot: Robot, speeds: Array) -> Array:
        return self.law(robot, np.tile(speeds, (len(self.active(robot)), 1)))


@dataclass(frozen=True)
class ViscousFriction(VelocityFriction):
    """tau_j = Fv_j v_j; Fv in N m s/rad (thesis eq. 3.42)."""

    name: ClassVar[str] = "viscous_friction"
    unit: ClassVar[str] = "N m s/rad"
    signature: ClassVar[str] = "grows with speed"
    rivals: ClassVar[str] = "coulomb_friction: two speeds separate them"

    def law(self, robot: Robot, v: Array) -> Array:
        return v


@dataclass(frozen=True)
class CoulombFriction(VelocityFriction):
    """tau_j = Fc_j sgn v_j with sgn v = tanh(v / smoothing); Fc in N m (thesis eq. 3.42).

    ``smoothing`` [rad/s] is of the size of the velocity's noise. Nominal: the motor's friction times the gear ratio,
    mean of both directions, where the robot states its drives.

    A smooth sign creeps under a constant load. ``presliding`` [rad|m] above zero makes a simulated joint stick instead:
    the torque is Fc z, dz/dt = (v - abs(v) z) / presliding, which reaches Fc after that distance and holds any smaller
    load at rest (Dahl, "A solid friction model" (1968)). Its column in a regressor stays the smooth sign.
    """

    smoothing: float = SMOOTHING
    presliding: float = 0.0

    name: ClassVar[str] = "coulomb_friction"
    unit: ClassVar[str] = "N m"
    signature: ClassVar[str] = "a step at each reversal"
    rivals: ClassVar[str] = "load_dependent_friction: vary the load"

    def __post_init__(self) -> None:
        if not (np.isfinite(self.smoothing) and self.smoothing > 0):
            raise InputError(f"coulomb_friction: smoothing is {self.smoothing}, expected a positive speed [rad/s]")
        if not (np.isfinite(self.presliding) and self.presliding >= 0):
            raise InputError(f"coulomb_friction: presliding is {self.presliding}, expected a distance [rad], or 0")

    def law(self, robot: Robot, v: Array) -> Array:
        return smooth_sign(v, self.smoothing)

    def nominal(self, robot: Robot) -> Array:
        if robot.drives is None:
            return np.zeros(len(self.active(robot)))
        forces = [d.gear_ratio * (d.motor_friction[0] - d.motor_friction[1]) / 2 for d in robot.drives]
        return np.array([forces[j] for j in self.active(robot)])

    def state_size(self, robot: Robot) -> int:
        return len(self.active(robot)) if self.presliding else 0

    def state_rate(self, robot: Robot, signals: Signals, state: Array) -> Array:
        v = signals.v.T[self.active(robot)]
        return (v - np.abs(v) * state) / self.presliding if self.presliding else state

    def torque_at(self, robot: Robot, signals: Signals, state: Array, load: Array) -> Array:
        return state if self.presliding else self.values(robot, signals)


@dataclass(frozen=True)
class FrictionAsymmetry(VelocityFriction):
    """tau_j = c_j abs(v_j): the viscous slope differs by direction, by 2 c; c in N m s/rad."""

    name: ClassVar[str] = "friction_asymmetry"
    unit: ClassVar[str] = "N m s/rad"
    signature: ClassVar[str] = "the slope over speed differs by direction"
    rivals: ClassVar[str] = "torque_offset: both directions at equal speed; standstill shows nothing, stiction hides it"

    def law(self, robot: Robot, v: Array) -> Array:
        return np.abs(v)


@dataclass(frozen=True)
class StribeckFriction(VelocityFriction):
    """tau_j = Fs_j sgn(v_j) exp(-(v_j / vs)^2); Fs in N m, the Stribeck ``velocity`` vs in rad/s. Cone: Fs >= 0.

    Source: Armstrong-Helouvry, Dupont, Canudas de Wit, "A survey of models ... for machines with friction" (1994), eq. 5.
    """

    velocity: tuple[float, ...] | None = None

    name: ClassVar[str] = "stribeck_friction"
    unit: ClassVar[str] = "N m"
    shapes: ClassVar = (Shape("velocity", "rad/s", (0.02, 0.035, 0.06, 0.1, 0.17, 0.3, 0.5)),)
    signature: ClassVar[str] = "a bump below 0.1 rad/s"
    rivals: ClassVar[str] = (
        "presliding_hysteresis: goes with distance, not speed; a filter on one side only imitates it"
    )

    def law(self, robot: Robot, v: Array) -> Array:
        return smooth_sign(v) * np.exp(-((v / self.shape(robot, "velocity")[:, None]) ** 2))

    def cones(self, robot: Robot) -> tuple[Cone, ...]:
        """Breaking away takes at least as much as sliding."""
        return (nonnegative(len(self.active(robot))),)


@dataclass(frozen=True)
class NonlinearViscousFriction(VelocityFriction):
    """tau_j = c_j sgn(v_j) abs(v_j)^a; c in N m (s/rad)^a, the ``exponent`` a: 0.5 is concave, 2 and 3 are convex."""

    exponent: tuple[float, ...] | None = None

    name: ClassVar[str] = "nonlinear_viscous_friction"
    unit: ClassVar[str] = "N m (s/rad)^a"
    shapes: ClassVar = (Shape("exponent", "1", (0.3, 0.5, 0.7, 1.5, 2.0, 3.0)),)
    signature: ClassVar[str] = "a bent friction curve"
    rivals: ClassVar[str] = "warm_up: repeat at one speed"

    def law(self, robot: Robot, v: Array) -> Array:
        return np.sign(v) * np.abs(v) ** self.shape(robot, "exponent")[:, None]
