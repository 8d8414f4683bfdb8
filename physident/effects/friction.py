"""Friction of a joint as a function of its velocity alone: positive parameters oppose the motion, their sum must not drive it."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from physident.dynamics.dry_sign import SHARPEST, SMOOTH_SIGN_SOURCE, sign_of_velocity, smooth_sign
from physident.effects.classification import Family, JointTerm, ShapeParameter, Variable, nonnegative
from physident.effects.effect import Array, Cone, Effect, array_source
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

PRESLIDING = 1e-5  # rad|m: below an encoder's step; ten times as much already looks like a delay of the torque


@dataclass(frozen=True)
class VelocityFriction(Effect):
    """Friction that is a function of the joint's velocity alone; a subclass implements ``law``."""

    family: ClassVar[Family] = Family.FRICTION
    variable: ClassVar[Variable | None] = "velocity"
    passive: ClassVar[bool] = True

    @abstractmethod
    def law(self, robot: Robot, v: Array, sign: Array) -> Array:
        """Friction (k, N) [N m|N] of each unit of each parameter at velocities (k, N) [rad/s|m/s] of a ``sign`` (k, N)."""

    def width(self, robot: Robot) -> Array | None:
        """Speeds (k,) [rad/s|m/s] over which its sign turns; None leaves them to the signals."""
        return None

    def values(self, robot: Robot, signals: Signals) -> Array:
        active = self.active(robot)
        return self.law(robot, signals.v.T[active], sign_of_velocity(signals, active, self.width(robot)))

    def friction(self, robot: Robot, speeds: Array) -> Array:
        v = np.tile(speeds, (len(self.active(robot)), 1))
        width = self.width(robot)
        return self.law(robot, v, smooth_sign(v) if width is None else smooth_sign(v, width[:, None]))


def led_by(signals: Signals, lead: float) -> Signals:
    """The signals with the velocities that the joints have after ``lead`` [s] at their accelerations."""
    return replace(signals, v=signals.v + lead * signals.a) if lead else signals


def _check_lead(effect: ViscousFriction | CoulombFriction) -> None:
    if not (np.isfinite(effect.lead) and effect.lead >= 0):
        raise InputError(f"{effect.name}: lead is {effect.lead}, expected a time [s], or 0")


@dataclass(frozen=True)
class ViscousFriction(VelocityFriction):
    """tau_j = Fv_j v_j; Fv in N m s/rad (thesis eq. 3.42). Nominal: a simulator's damping.

    ``lead`` [s] takes the velocity v + lead a: a simulator that damps at the end of each step leads by half a step.
    """

    lead: float = 0.0

    name: ClassVar[str] = "viscous_friction"
    unit: ClassVar[str] = "N m s/rad"
    formulas: ClassVar[tuple[str, ...]] = ("v",)
    signature: ClassVar[str] = "grows with speed"
    mistaken_for: ClassVar[str] = "coulomb_friction: two speeds separate them"

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_lead(self)

    def values(self, robot: Robot, signals: Signals) -> Array:
        # no sign, whose expectation would take a tenth of an identification's time
        return led_by(signals, self.lead).v.T[self.active(robot)]

    def stepped(self, robot: Robot) -> Effect:
        return replace(self, lead=float(robot.damping_lead.max()))

    def numpy_source(self, robot: Robot, theta: Array) -> str | None:
        source = super().numpy_source(robot, theta)
        return source.replace("* v", f"* (v + {self.lead!r} * a)") if self.lead and source else source

    def law(self, robot: Robot, v: Array, sign: Array) -> Array:
        return v

    def nominal(self, robot: Robot) -> Array:
        return robot.damping[self.active(robot)]

    def joint_terms(self, robot: Robot, theta: Array) -> tuple[JointTerm, ...]:
        return tuple(JointTerm((j,), damping=float(Fv)) for j, Fv in zip(self.active(robot), theta, strict=True))


@dataclass(frozen=True)
class CoulombFriction(VelocityFriction):
    """tau_j = Fc_j sgn v_j, at rest any torque up to Fc_j; Fc in N m (thesis eq. 3.42).

    In recordings sgn v is its expectation under the noise of the velocity, and at rest it passes from the sign before to the sign
    after. ``smoothing`` [rad/s], one value or one a joint, is the width over which the arm's own friction turns, zero where it is
    dry; None lets ``identify`` find it, and is dry elsewhere. Of single states sgn v is tanh(v / smoothing), at least 0.001 rad/s. Nominal: the motor's friction times the gear ratio, mean of both directions, where the robot states its
    drives, or a simulator's dry friction.

    A simulated joint sticks: its torque is Fc z, dz/dt = (v - abs(v) z) / presliding, which reaches Fc after the distance
    ``presliding`` [rad|m] and carries any smaller load at standstill (Dahl, "A solid friction model" (1968)). With zero it
    follows the sign, and creeps under a constant load.

    ``lead`` [s] takes the sign of v + lead a: a simulator whose dry friction is a constraint that stops the joint within this
    time turns the friction before the velocity changes sign.
    """

    smoothing: float | tuple[float, ...] | None = None
    presliding: float = PRESLIDING
    lead: float = 0.0

    name: ClassVar[str] = "coulomb_friction"
    unit: ClassVar[str] = "N m"
    label: ClassVar[str] = "Coulomb friction"
    settings_by_joint: ClassVar[tuple[str, ...]] = ("smoothing",)
    dry: ClassVar[bool] = True
    signature: ClassVar[str] = "a step at each reversal"
    mistaken_for: ClassVar[str] = "load_dependent_friction: vary the load"

    def __post_init__(self) -> None:
        super().__post_init__()
        widths = self.smoothing if isinstance(self.smoothing, tuple) else (self.smoothing or 0.0,)
        if not (np.isfinite(widths).all() and min(widths) >= 0):
            raise InputError(f"coulomb_friction: smoothing is {self.smoothing}, expected speeds [rad/s], or 0")
        if not (np.isfinite(self.presliding) and self.presliding >= 0):
            raise InputError(f"coulomb_friction: presliding is {self.presliding}, expected a distance [rad], or 0")
        _check_lead(self)

    def values(self, robot: Robot, signals: Signals) -> Array:
        return super().values(robot, led_by(signals, self.lead))

    def law(self, robot: Robot, v: Array, sign: Array) -> Array:
        return sign

    def width(self, robot: Robot) -> Array | None:
        if self.smoothing is None:
            return None
        count = len(self.active(robot))
        widths = self.smoothing if isinstance(self.smoothing, tuple) else (self.smoothing,)
        if len(widths) not in (1, count):
            raise InputError(f"coulomb_friction: smoothing has {len(widths)} values, expected 1 or {count}")
        return np.broadcast_to(np.array(widths, dtype=float), (count,))

    def transition(self, robot: Robot) -> Array | None:
        widths, own = np.zeros(robot.n), self.width(robot)
        if own is None:
            return None
        widths[self.active(robot)] = own
        return widths

    @classmethod
    def search_options(
        cls, robot: Robot, joints: tuple[int, ...], signals: Sequence[Signals]
    ) -> Sequence[CoulombFriction]:
        """As wide as the signals' sign turns."""
        widths = signals[0].transition if signals else None
        return [cls(joints=joints, smoothing=None if widths is None else tuple(float(widths[j - 1]) for j in joints))]

    def numpy_source(self, robot: Robot, theta: Array) -> str:
        gains, widths = np.zeros(robot.n), np.zeros(robot.n) if (own := self.transition(robot)) is None else own
        gains[self.active(robot)] = theta
        widths = np.maximum(widths, SHARPEST)
        velocity = f"(v + {self.lead!r} * a)" if self.lead else "v"
        return f"{array_source(gains)} * np.tanh({velocity} / {array_source(widths)})"

    def nominal(self, robot: Robot) -> Array:
        return robot.dry_friction[self.active(robot)]

    @classmethod
    def described(cls, robot: Robot) -> tuple[Effect, ...]:
        """One effect for each joint with friction, as wide and as early as a simulator makes it."""
        joints = [int(j) for j in np.flatnonzero(robot.dry_friction)]
        widths = [float(robot.friction_width[j]) for j in joints]
        leads = [float(robot.friction_lead[j]) for j in joints]
        return tuple(
            cls(joints=(j + 1,), smoothing=width, lead=lead)
            for j, width, lead in zip(joints, widths, leads, strict=True)
        )

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
    passive: ClassVar[bool] = False
    formulas: ClassVar[tuple[str, ...]] = ("np.abs(v)",)
    signature: ClassVar[str] = "the slope over speed differs by direction"
    mistaken_for: ClassVar[str] = (
        "torque_offset: compare both directions at equal speed; standstill shows nothing, because stiction hides it"
    )

    def law(self, robot: Robot, v: Array, sign: Array) -> Array:
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
    dry: ClassVar[bool] = True
    shape_parameters: ClassVar = (ShapeParameter("velocity", "rad/s", (0.02, 0.035, 0.06, 0.1, 0.17, 0.3, 0.5)),)
    formulas: ClassVar[tuple[str, ...]] = (f"{SMOOTH_SIGN_SOURCE} * np.exp(-((v / {{velocity}}) ** 2))",)
    signature: ClassVar[str] = "a bump below 0.1 rad/s"
    mistaken_for: ClassVar[str] = (
        "presliding_hysteresis: follows distance, not speed; filtering the signals but not the torque imitates it"
    )

    def law(self, robot: Robot, v: Array, sign: Array) -> Array:
        return sign * np.exp(-((v / self.shape_values(robot, "velocity")[:, None]) ** 2))

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

    def law(self, robot: Robot, v: Array, sign: Array) -> Array:
        return np.sign(v) * np.abs(v) ** self.shape_values(robot, "exponent")[:, None]
