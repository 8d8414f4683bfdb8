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
    """

    smoothing: float = 0.01

    name: ClassVar[str] = "coulomb_friction"
    unit: ClassVar[str] = "N m"

    def __post_init__(self) -> None:
        if not (np.isfinite(self.smoothing) and self.smoothing > 0):
            raise InputError(f"coulomb_friction: smoothing is {self.smoothing}, expected a positive speed [rad/s]")

    def values(self, robot: Robot, signals: Signals) -> Array:
        return smooth_sign(signals.v.T[self.active(robot)], self.smoothing)

    def nominal(self, robot: Robot) -> Array:
        if robot.drives is None:
            return np.zeros(len(self.active(robot)))
        forces = [d.gear_ratio * (d.motor_friction[0] - d.motor_friction[1]) / 2 for d in robot.drives]
        return np.array([forces[j] for j in self.active(robot)])

    def friction(self, robot: Robot, speeds: Array) -> Array:
        return np.tile(smooth_sign(speeds, self.smoothing), (len(self.active(robot)), 1))
