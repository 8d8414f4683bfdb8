"""Effects of the drive and of the torque measurement: rotor inertia, torque offset."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from physident.effects.effect import AddedInertia, Array, Cone, Effect, nonnegative
from physident.robot import Robot
from physident.signals import Signals


@dataclass(frozen=True)
class RotorInertia(Effect):
    """tau_j = Ia_j a_j; Ia = G^2 Jm in kg m^2, the rotor's inertia at the joint (thesis eq. 3.45). Cone: Ia >= 0.

    Nominal: the motor's inertia times the gear ratio squared, where the robot states its drives.
    """

    name: ClassVar[str] = "rotor_inertia"
    unit: ClassVar[str] = "kg m^2"

    def values(self, robot: Robot, signals: Signals) -> Array:
        return signals.a.T[self.active(robot)]

    def inertia(self, robot: Robot, theta: Array) -> AddedInertia:
        armature = np.zeros(robot.n)
        armature[self.active(robot)] = theta
        return AddedInertia(np.zeros(10 * robot.n), armature)

    def nominal(self, robot: Robot) -> Array:
        if robot.drives is None:
            return np.zeros(len(self.active(robot)))
        return np.array([robot.drives[j].gear_ratio ** 2 * robot.drives[j].motor_inertia for j in self.active(robot)])

    def cones(self, robot: Robot) -> tuple[Cone, ...]:
        return (nonnegative(len(self.active(robot))),)


@dataclass(frozen=True)
class TorqueOffset(Effect):
    """tau_j = c_j: a constant offset of the measured torque of a joint, in N m."""

    name: ClassVar[str] = "torque_offset"
    unit: ClassVar[str] = "N m"
    acts_on: ClassVar = "measurement"

    def values(self, robot: Robot, signals: Signals) -> Array:
        return np.ones((len(self.active(robot)), len(signals.time)))
