"""Effects of the drive and of the torque's measurement: rotor inertia, torque constant, torque offset."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from physident.effects.effect import AddedInertia, Array, Cone, Effect, nonnegative
from physident.recordings.signals import Signals
from physident.robots.robot import Robot


@dataclass(frozen=True)
class RotorInertia(Effect):
    """tau_j = Ia_j a_j; Ia = G^2 Jm in kg m^2, the rotor's inertia at the joint (thesis eq. 3.45). Cone: Ia >= 0.

    Nominal: the motor's inertia times the gear ratio squared, where the robot states its drives.
    """

    name: ClassVar[str] = "rotor_inertia"
    unit: ClassVar[str] = "kg m^2"
    signature: ClassVar[str] = "in phase with the joint's own acceleration"
    rivals: ClassVar[str] = "link inertia: on an upright arm those of the first two joints lie inside the rigid columns"

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
class TorqueConstant(Effect):
    """tau_j = (1 + k_j) tau_m_j: the measured torque of a joint is scaled by a wrong gain; k has no unit.

    tau_m is the model's torque without measurement effects. A common k on all joints is invisible without a known mass.
    """

    name: ClassVar[str] = "torque_constant"
    unit: ClassVar[str] = "1"
    acts_on: ClassVar = "measurement"
    needs_model: ClassVar[bool] = True
    signature: ClassVar[str] = "the whole torque of one joint is scaled"
    rivals: ClassVar[str] = "a wrong mass: it does not stay in one row"

    def values(self, robot: Robot, signals: Signals) -> Array:
        return signals.from_model("motor").T[self.active(robot)]

    def measure(self, robot: Robot, theta: Array, signals: Signals) -> Signals:
        assert signals.torque is not None
        scale = np.ones(robot.n)
        scale[self.active(robot)] += theta
        return replace(signals, torque=signals.torque * scale)


@dataclass(frozen=True)
class TorqueOffset(Effect):
    """tau_j = c_j: a constant offset of the measured torque of a joint, in N m."""

    name: ClassVar[str] = "torque_offset"
    unit: ClassVar[str] = "N m"
    acts_on: ClassVar = "measurement"
    signature: ClassVar[str] = "persists at any speed"
    rivals: ClassVar[str] = "friction_asymmetry: move at two speeds in both directions"

    def values(self, robot: Robot, signals: Signals) -> Array:
        return np.ones((len(self.active(robot)), len(signals.time)))
