"""A late clock: torque is recorded later than the motion it belongs to."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.effects.effect import Array, Column, Effect
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot


@dataclass(frozen=True)
class TimeDelay(Effect):
    """tau(t) = tau_m(t - d), to first order -d dtau_m/dt, one d for all joints; d in s, positive where torque is late."""

    name: ClassVar[str] = "time_delay"
    unit: ClassVar[str] = "s"
    acts_on: ClassVar = "measurement"
    pointwise: ClassVar[bool] = False
    needs_model: ClassVar[bool] = True
    signature: ClassVar[str] = "the same milliseconds in every joint"
    rivals: ClassVar[str] = "joint_elasticity: scales with the inertia behind the joint"

    def __post_init__(self) -> None:
        if self.joints is not None:
            raise InputError("time_delay is one clock for all joints; expected no joints setting")

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        return (Column(self.name, self.unit, 1, self.name),)

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        return np.array([(j, 0) for j in range(robot.n)], dtype=np.intp)

    def values(self, robot: Robot, signals: Signals) -> Array:
        return -np.gradient(signals.from_model("motor"), 1 / signals.rate, axis=0).T

    def measure(self, robot: Robot, theta: Array, signals: Signals) -> Signals:
        assert signals.torque is not None
        late = signals.time - theta[0]
        return replace(signals, torque=np.column_stack([np.interp(late, signals.time, x) for x in signals.torque.T]))
