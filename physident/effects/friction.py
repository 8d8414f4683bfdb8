"""Friction of a joint as a function of its velocity alone. Positive parameters oppose the motion.

A single parameter may be negative in a physical model, but the sum of all friction of a joint must not drive it.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from physident.effects.classification import Family, JointTerm
from physident.effects.effect import Array, Cone, Effect, ShapeParameter, nonnegative
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

SMOOTHING = 0.01  # rad/s: about the noise of a measured velocity
SMOOTH_SIGN_SOURCE = f"np.tanh(v / {SMOOTHING})"  # ``smooth_sign`` in exported code


def smooth_sign(v: Array, width: float = SMOOTHING) -> Array:
    """The smooth sign tanh(v / width) that all effects use; ``v`` and ``width`` in the same unit [rad/s|m/s]."""
    return np.tanh(v / width)


@dataclass(frozen=True)
class VelocityFriction(Effect):
    """Friction that is a function of the joint's velocity alone; a subclass implements ``law``."""

    family: ClassVar[Family] = Family.FRICTION

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
    formulas: ClassVar[tuple[str, ...]] = ("v",)
    signature: ClassVar[str] = "grows with speed"
    mistaken_for: ClassVar[str] = "coulomb_friction: two speeds separate them"

    def law(self, robot: Robot, v: Array) -> Array:
        return v

    def joint_terms(self, robot: Robot, theta: Array) -> tuple[JointTerm, ...]:
        return tuple(JointTerm((j,), damping=float(Fv)) for j, Fv in zip(self.active(robot), theta, strict=True))


@dataclass(frozen=True)
class CoulombFriction(VelocityFriction):
    """tau_j = Fc_j sgn v_j with sgn v = tanh(v / smoothing); Fc in N m (thesis eq. 3.42).

    ``smoothing`` [rad/s] is about the noise of the velocity. Nominal: the motor's friction times the gear ratio, mean of
    both directions, where the robot states its drives.

    A joint with a smooth sign creeps under a constant load. ``presliding`` [rad|m] above zero makes a simulated joint
    stick instead: the torque is Fc z, dz/dt = (v - abs(v) z) / presliding, which reaches Fc after that distance and
    carries any smaller load at standstill (Dahl, "A solid friction model" (1968)). The regressor keeps the smooth sign.
    """

    smoothing: float = SMOOTHING
    presliding: float = 0.0

    name: ClassVar[str] = "coulomb_friction"
    unit: ClassVar[str] = "N m"
    label: ClassVar[str] = "Coulomb friction"
    formulas: ClassVar[tuple[str, ...]] = ("np.tanh(v / {smoothing})",)
    signature: ClassVar[str] = "a step at each reversal"
    mistaken_for: ClassVar[str] = "load_dependent_friction: vary the load"

    def __post_init__(self) -> None:
        super().__post_init__()
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

    def joint_terms(self, robot: Robot, theta: Array) -> tuple[JointTerm, ...]:
        return tuple(JointTerm((j,), dry=float(Fc)) for j, Fc in zip(self.active(robot), theta, strict=True))


@dataclass(frozen=True)
class FrictionAsymmetry(VelocityFriction):
    """tau_j = c_j abs(v_j): the viscous slope differs by direction, by 2 c; c in N m s/rad."""

    name: ClassVar[str] = "friction_asymmetry"
    unit: ClassVar[str] = "N m s/rad"
    formulas: ClassVar[tuple[str, ...]] = ("np.abs(v)",)
    signature: ClassVar[str] = "the slope over speed differs by direction"
    mistaken_for: ClassVar[str] = (
        "torque_offset: compare both directions at equal speed; standstill shows nothing, because stiction hides it"
    )

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
    label: ClassVar[str] = "Stribeck friction"
    shape_parameters: ClassVar = (ShapeParameter("velocity", "rad/s", (0.02, 0.035, 0.06, 0.1, 0.17, 0.3, 0.5)),)
    formulas: ClassVar[tuple[str, ...]] = (f"{SMOOTH_SIGN_SOURCE} * np.exp(-((v / {{velocity}}) ** 2))",)
    signature: ClassVar[str] = "a bump below 0.1 rad/s"
    mistaken_for: ClassVar[str] = (
        "presliding_hysteresis: follows distance, not speed; filtering the signals but not the torque imitates it"
    )

    def law(self, robot: Robot, v: Array) -> Array:
        return smooth_sign(v) * np.exp(-((v / self.shape_values(robot, "velocity")[:, None]) ** 2))

    def cones(self, robot: Robot) -> tuple[Cone, ...]:
        """The breakaway torque is at least the sliding friction."""
        return (nonnegative(len(self.active(robot))),)


@dataclass(frozen=True)
class NonlinearViscousFriction(VelocityFriction):
    """tau_j = c_j sgn(v_j) abs(v_j)^a; c in N m (s/rad)^a, the ``exponent`` a: 0.5 is concave, 2 and 3 are convex."""

    exponent: tuple[float, ...] | None = None

    name: ClassVar[str] = "nonlinear_viscous_friction"
    unit: ClassVar[str] = "N m (s/rad)^a"
    shape_parameters: ClassVar = (ShapeParameter("exponent", "1", (0.3, 0.5, 0.7, 1.5, 2.0, 3.0)),)
    formulas: ClassVar[tuple[str, ...]] = ("np.sign(v) * np.abs(v) ** {exponent}",)
    signature: ClassVar[str] = "friction over speed is a curve, not a line"
    mistaken_for: ClassVar[str] = "warm_up: repeat a motion at the same speed later"

    def law(self, robot: Robot, v: Array) -> Array:
        return np.sign(v) * np.abs(v) ** self.shape_values(robot, "exponent")[:, None]
