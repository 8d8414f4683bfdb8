"""Rigid-body dynamics: inertia, Coriolis, centrifugal and gravity torques of the links, and the inertia of the rotors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.rigid_body_regressor import torque_entries_of, torque_pattern
from physident.effects.classification import Detection, Family, Scope, nonnegative
from physident.effects.effect import AddedInertia, Array, Column, Cone, Effect
from physident.recordings.signals import Signals
from physident.robots.inertia import PARAMETER_NAMES, PARAMETER_UNITS
from physident.robots.robot import Robot


@dataclass(frozen=True)
class RigidBody(Effect):
    """tau = Y(q, v, a) theta with ten parameters for each link (thesis eq. 3.41).

    Acts on all joints. The pseudo-inertia of each link, including what other effects add to it, is positive semidefinite.
    """

    name: ClassVar[str] = "rigid_body"
    unit: ClassVar[str] = "kg, kg m, kg m^2"
    family: ClassVar[Family] = Family.INERTIA
    scope: ClassVar[Scope] = Scope.WHOLE_ARM
    detection: ClassVar[Detection] = Detection.NEVER  # payload and link_inertia describe its changes

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        units = dict(zip(PARAMETER_NAMES, PARAMETER_UNITS, strict=True))
        return tuple(Column(f"{p}_{i}", units[p], i, self.name) for i in range(1, robot.n + 1) for p in PARAMETER_NAMES)

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        return torque_pattern(robot)

    def values(self, robot: Robot, signals: Signals) -> Array:
        return torque_entries_of(robot, signals)

    def inertia(self, robot: Robot, theta: Array) -> AddedInertia:
        return AddedInertia(theta, np.zeros(robot.n))

    def nominal(self, robot: Robot) -> Array:
        return robot.nominal.copy()


@dataclass(frozen=True)
class RotorInertia(Effect):
    """tau_j = Ia_j a_j; Ia = G^2 Jm in kg m^2, the rotor's inertia at the joint (thesis eq. 3.45). Cone: Ia >= 0.

    Nominal: the motor's inertia times the gear ratio squared, where the robot states its drives, or a simulator's armature.
    """

    name: ClassVar[str] = "rotor_inertia"
    unit: ClassVar[str] = "kg m^2"
    family: ClassVar[Family] = Family.INERTIA
    signature: ClassVar[str] = "in phase with the joint's own acceleration"
    mistaken_for: ClassVar[str] = (
        "link inertia: on an upright arm the first two rotors cannot be distinguished from the inertia of the links"
    )

    def values(self, robot: Robot, signals: Signals) -> Array:
        return signals.a.T[self.active(robot)]

    def inertia(self, robot: Robot, theta: Array) -> AddedInertia:
        armature = np.zeros(robot.n)
        armature[self.active(robot)] = theta
        return AddedInertia(np.zeros(10 * robot.n), armature)

    def nominal(self, robot: Robot) -> Array:
        return robot.rotor_inertia[self.active(robot)]

    def cones(self, robot: Robot) -> tuple[Cone, ...]:
        return (nonnegative(len(self.active(robot))),)
