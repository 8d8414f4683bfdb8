"""How the arm is mounted and zeroed: gravity that is not straight down, encoders whose zero is off."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.inverse_dynamics import gravity_torque, torque_changes
from physident.effects.effect import AddedInertia, Array, Column, Effect
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot


@dataclass(frozen=True)
class GravityTilt(Effect):
    """tau = g_x d tau/d g_x + g_y d tau/d g_y: gravity has a part along the base's x or y axis; g in m/s^2.

    The columns need first moments that vertical gravity never showed; the model's are used.
    """

    name: ClassVar[str] = "gravity_tilt"
    unit: ClassVar[str] = "m/s^2"
    needs_model: ClassVar[bool] = True
    signature: ClassVar[str] = "gravity torque on joint 1"
    rivals: ClassVar[str] = "joint_zero_offset: couples joints; first moments that vertical gravity never showed"

    def __post_init__(self) -> None:
        if self.joints is not None:
            raise InputError("gravity_tilt acts on the whole arm; expected no joints setting")

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        return tuple(Column(f"{self.name}_{axis}", self.unit, 1, self.name) for axis in "xy")

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        return np.array([(j, c) for c in range(2) for j in range(robot.n)], dtype=np.intp)

    def values(self, robot: Robot, signals: Signals) -> Array:
        axes = np.eye(3)[:2]
        return np.concatenate([gravity_torque(robot, signals.from_model("links"), signals.q, axis).T for axis in axes])

    def inertia(self, robot: Robot, theta: Array) -> AddedInertia:
        return AddedInertia(np.zeros(10 * robot.n), np.zeros(robot.n), (float(theta[0]), float(theta[1]), 0.0))


@dataclass(frozen=True)
class JointZeroOffset(Effect):
    """tau = d_j d tau/d q_j: the true angle is the recorded one plus d_j; d in rad. Acts on all rows.

    The derivative is that of the links' torque; an upright arm's first joint, and a last link that is round about its
    axis, show nothing.
    """

    name: ClassVar[str] = "joint_zero_offset"
    unit: ClassVar[str] = "rad"
    acts_on: ClassVar = "sensor"
    needs_model: ClassVar[bool] = True
    signature: ClassVar[str] = "a pure function of the angles that couples joints"
    rivals: ClassVar[str] = "gravity_tilt, torque_offset: poses all around"

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        count = len(self.active(robot))
        return np.array([(j, c) for c in range(count) for j in range(robot.n)], dtype=np.intp).reshape(-1, 2)

    def values(self, robot: Robot, signals: Signals) -> Array:
        active, N = tuple(self.active(robot)), len(signals.time)
        state, turns = (signals.q, signals.v, signals.a), np.ones((len(active), 1, N))
        return torque_changes(robot, signals.from_model("links"), state, active, turns).reshape(-1, N)

    def measure(self, robot: Robot, theta: Array, signals: Signals) -> Signals:
        q = signals.q.copy()
        q[:, self.active(robot)] -= theta
        return replace(signals, q=q)
