"""Friction of a joint as a function of its velocity. Positive parameters oppose the motion.

A single parameter may be negative in a physical model; the sum of a joint's friction may not push it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from physident.effects.effect import Array, Effect
from physident.errors import InputError
from physident.robot import Robot
from physident.signals import Signals


def smooth_sign(v: Array, width: float) -> Array:
    """tanh(v / width), the one smooth sign everywhere; ``v`` and ``width`` in the same unit [rad/s|m/s]."""
    return np.tanh(v / width)


@dataclass(frozen=True)
class ViscousFriction(Effect):
    """tau_j = Fv_j v_j; Fv in N m s/rad (thesis eq. 3.42)."""

    name: ClassVar[str] = "viscous_friction"
    unit: ClassVar[str] = "N m s/rad"

    def values(self, robot: Robot, signals: Signals) -> Array:
        return signals.v.T[self.active(robot)]

    def friction(self, robot: Robot, speeds: Array) -> Array:
        return np.tile(speeds, (len(self.active(robot)), 1))


@dataclass(frozen=True)
class CoulombFriction(Effect):
    """tau_j = Fc_j sgn v_j with sgn v = tanh(v / smoothing); Fc in N m (thesis eq. 3.42).

    ``smoothing`` [rad/s] is of the size of the velocity's noise. Nominal: the motor's friction times the gear ratio,
    mean of both directions, where the robot states its drives.

    A smooth sign creeps under a constant load. ``presliding`` [rad|m] above zero makes a simulated joint stick instead:
    the torque is Fc z, dz/dt = (v - abs(v) z) / presliding, which reaches Fc after that distance and holds any smaller
    load at rest (Dahl, "A solid friction model" (1968)). Its column in a regressor stays the smooth sign.
    """

    smoothing: float = 0.01
    presliding: float = 0.0

    name: ClassVar[str] = "coulomb_friction"
    unit: ClassVar[str] = "N m"

    def __post_init__(self) -> None:
        if not (np.isfinite(self.smoothing) and self.smoothing > 0):
            raise InputError(f"coulomb_friction: smoothing is {self.smoothing}, expected a positive speed [rad/s]")
        if not (np.isfinite(self.presliding) and self.presliding >= 0):
            raise InputError(f"coulomb_friction: presliding is {self.presliding}, expected a distance [rad], or 0")

    def values(self, robot: Robot, signals: Signals) -> Array:
        return smooth_sign(signals.v.T[self.active(robot)], self.smoothing)

    def nominal(self, robot: Robot) -> Array:
        if robot.drives is None:
            return np.zeros(len(self.active(robot)))
        forces = [d.gear_ratio * (d.motor_friction[0] - d.motor_friction[1]) / 2 for d in robot.drives]
        return np.array([forces[j] for j in self.active(robot)])

    def friction(self, robot: Robot, speeds: Array) -> Array:
        return np.tile(smooth_sign(speeds, self.smoothing), (len(self.active(robot)), 1))

    def state_size(self, robot: Robot) -> int:
        return len(self.active(robot)) if self.presliding else 0

    def state_rate(self, robot: Robot, signals: Signals, state: Array) -> Array:
        v = signals.v.T[self.active(robot)]
        return (v - np.abs(v) * state) / self.presliding if self.presliding else state

    def torque_at(self, robot: Robot, signals: Signals, state: Array, load: Array) -> Array:
        return state if self.presliding else self.values(robot, signals)
