"""Rigid-body dynamics: inertia, Coriolis, centrifugal and gravity torques of every link."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.rigid_body_regressor import torque_entries, torque_pattern
from physident.effects.effect import AddedInertia, Array, Column, Effect
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.inertia import PARAMETER_NAMES, PARAMETER_UNITS
from physident.robots.robot import Robot


@dataclass(frozen=True)
class RigidBody(Effect):
    """tau = Y(q, v, a) theta with ten parameters for each link (thesis eq. 3.41).

    Acts on all joints. Each link's pseudo-inertia, with what other effects add to it, is positive semidefinite.
    """

    name: ClassVar[str] = "rigid_body"
    unit: ClassVar[str] = "kg, kg m, kg m^2"

    def __post_init__(self) -> None:
        if self.joints is not None:
            raise InputError("rigid_body acts on every joint; expected no joints setting")

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        units = dict(zip(PARAMETER_NAMES, PARAMETER_UNITS, strict=True))
        return tuple(Column(f"{p}_{i}", units[p], i, self.name) for i in range(1, robot.n + 1) for p in PARAMETER_NAMES)

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        return torque_pattern(robot)

    def values(self, robot: Robot, signals: Signals) -> Array:
        return torque_entries(robot, signals.q, signals.v, signals.a)

    def inertia(self, robot: Robot, theta: Array) -> AddedInertia:
        return AddedInertia(theta, np.zeros(robot.n))

    def nominal(self, robot: Robot) -> Array:
        return robot.nominal.copy()
