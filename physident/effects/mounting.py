"""Errors of mounting and zeroing: gravity of another direction or size, and encoders whose zero is off."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from physident.arguments import refuse_one_number
from physident.dynamics.inverse_dynamics import gravity_torque, inverse_dynamics, torque_changes
from physident.effects.classification import Family, Scope, every_joint_pattern
from physident.effects.effect import AddedInertia, Array, Column, Effect
from physident.effects.kinds_of_values import AboutItsSize
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

SLIGHT = 0.05  # of gravity: its size along its own direction is the same beside a smaller part, to a thousandth


@dataclass(frozen=True)
class GravityTilt(AboutItsSize):
    """tau = g_x d tau/d g_x + g_y d tau/d g_y: gravity has a part along the base's x or y axis; g in m/s^2.

    ``about`` (g_x, g_y) [m/s^2] is the part beside which a vertical gravity keeps its size: its own direction then has
    c (g_x a_x + g_y a_y) less, so much that this is exact at ``about`` a, as a search finds it. Where it is not given, the part is slight.
    The columns also depend on first moments that vertical gravity never shows; those of the model are used.
    """

    about: tuple[float, float] | None = None

    name: ClassVar[str] = "gravity_tilt"
    unit: ClassVar[str] = "m/s^2"
    family: ClassVar[Family] = Family.MOUNTING
    scope: ClassVar[Scope] = Scope.WHOLE_ARM
    needs_model: ClassVar[bool] = True
    signature: ClassVar[str] = "gravity torque on joint 1"
    mistaken_for: ClassVar[str] = (
        "joint_zero_offset: couples the joints; errors of first moments that vertical gravity never shows"
    )

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        return tuple(Column(f"{self.name}_{axis}", self.unit, 1, self.name) for axis in "xy")

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        return every_joint_pattern(robot.n, 2)

    def values(self, robot: Robot, signals: Signals) -> Array:
        axes = self._directions(robot)
        return np.concatenate([gravity_torque(robot, signals.from_model("links"), signals.q, axis).T for axis in axes])

    def inertia(self, robot: Robot, theta: Array) -> AddedInertia:
        x, y, z = (theta @ self._directions(robot)).tolist()
        return AddedInertia(np.zeros(10 * robot.n), np.zeros(robot.n), (x, y, z))

    def once_sized(self, theta: Array) -> Self:
        """About the part ``theta`` (2,), unless that is slight."""
        slight = np.linalg.norm(theta) <= SLIGHT * EARTH[0]
        return self if slight else replace(self, about=(float(theta[0]), float(theta[1])))

    def _directions(self, robot: Robot) -> Array:
        """The changes (2, 3) of gravity of one unit of each parameter; raises InputError for a part that is not finite, or zero."""
        result, part, stated = np.eye(3)[:2].copy(), np.array(self.about or (0.0, 0.0)), np.array(robot.gravity)
        if self.about is None or stated[:2].any():
            return result
        if part.shape != (2,) or not np.isfinite(part).all() or not part.any():
            raise InputError(f"{self.name}: about is {self.about}, expected two parts of gravity [m/s^2], or none")
        left = np.sqrt(max(stated[2] ** 2 - part @ part, 0.0)) - abs(stated[2])
        result[:, 2] = np.sign(stated[2]) * left * part / (part @ part)
        return result


EARTH = (9.76, 9.84)  # m/s^2: what is measured anywhere on its surface


@dataclass(frozen=True)
class GravityMagnitude(Effect):
    """tau = g d tau/d g: gravity is larger by g along its own direction; g in m/s^2, negative where it is smaller.

    A diagnosis looks for it only where a description can be wrong about it: in simulations, which state their gravity, and where
    gravity is not the Earth's.
    """

    name: ClassVar[str] = "gravity_magnitude"
    unit: ClassVar[str] = "m/s^2"
    family: ClassVar[Family] = Family.MOUNTING
    scope: ClassVar[Scope] = Scope.WHOLE_ARM
    needs_model: ClassVar[bool] = True
    signature: ClassVar[str] = "all gravity torques are scaled alike, and inertia torques are not"
    mistaken_for: ClassVar[str] = (
        "torque_constant, payload, link_inertia: they change inertia torques too, so record fast motions"
    )

    @classmethod
    def can_be_wrong(cls, robot: Robot) -> bool:
        simulated = robot.origin is not None and robot.origin.format == "mjcf"
        return simulated or not EARTH[0] <= float(np.linalg.norm(robot.gravity)) <= EARTH[1]

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        return (Column(self.name, self.unit, 1, self.name),)

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        return every_joint_pattern(robot.n, 1)

    def values(self, robot: Robot, signals: Signals) -> Array:
        return gravity_torque(robot, signals.from_model("links"), signals.q, _direction(robot)).T

    def inertia(self, robot: Robot, theta: Array) -> AddedInertia:
        x, y, z = (float(theta[0] * along) for along in _direction(robot))
        return AddedInertia(np.zeros(10 * robot.n), np.zeros(robot.n), (x, y, z))

    def in_words(self, robot: Robot, theta: Array) -> str:
        stated, change = float(np.linalg.norm(robot.gravity)), float(theta[0])
        if stated == 0.0:
            return f"The description has no gravity; the recordings show {change:.4g} m/s^2."
        size = f"{100 * abs(change) / stated:.3g} % {'larger' if change > 0 else 'smaller'}"
        return f"Gravity is {size} than described: {stated + change:.4g} instead of {stated:.4g} m/s^2."


def _direction(robot: Robot) -> Array:
    """Unit vector (3,) of the description's gravity; downwards where it has none."""
    size = float(np.linalg.norm(robot.gravity))
    return np.array(robot.gravity) / size if size > 0 else np.array([0.0, 0.0, -1.0])


SMALL = 0.012  # rad: the torque is a line over a smaller offset, to less than a per cent


@dataclass(frozen=True)
class JointZeroOffset(AboutItsSize):
    """tau = d_j (tau(q + D_j) - tau(q)) / D_j: the true angle is the recorded one plus d_j; d in rad. Acts on the rows of all joints.

    ``about`` D [rad] is the offset of each joint at which this is exact, as a search finds it; where it is not given, the torque is that of a
    small offset, d_j d tau/d q_j. It is the torque of the links. It is zero for the first joint of an upright arm and for a last link that
    is symmetric about its axis: their offsets cannot be seen.
    """

    about: tuple[float, ...] | None = None

    name: ClassVar[str] = "joint_zero_offset"
    unit: ClassVar[str] = "rad"
    family: ClassVar[Family] = Family.MOUNTING
    acts_on: ClassVar = "sensor"
    needs_model: ClassVar[bool] = True
    settings_by_joint: ClassVar[tuple[str, ...]] = ("about",)
    signature: ClassVar[str] = "a function of the angles alone that couples the joints"
    mistaken_for: ClassVar[str] = "gravity_tilt, torque_offset: record poses in all directions"

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_one_number(self.name, about=self.about)
        if self.about is not None and not all(np.isfinite(x) and x != 0 for x in self.about):
            raise InputError(f"{self.name}: about is {self.about}, expected offsets [rad] other than zero, or none")

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        return every_joint_pattern(robot.n, len(self.active(robot)))

    def values(self, robot: Robot, signals: Signals) -> Array:
        active, N, links = tuple(self.active(robot)), len(signals.time), signals.from_model("links")
        q, v, a = state = (signals.q, signals.v, signals.a)
        if self.about is None:
            return torque_changes(robot, links, state, active, np.ones((len(active), 1, N))).reshape(-1, N)
        here, changes = inverse_dynamics(robot, links, q, v, a), []
        for j, offset in zip(active, self.shape_values(robot, "about"), strict=True):
            there = inverse_dynamics(robot, links, q + offset * (np.arange(robot.n) == j), v, a)
            changes.append((there - here).T / offset)
        return np.array(changes).reshape(-1, N)

    def once_sized(self, theta: Array) -> Self:
        """About the offsets ``theta`` (k,), unless all are small."""
        large = np.abs(theta) > SMALL
        return replace(self, about=tuple(np.where(large, theta, SMALL).tolist())) if large.any() else self

    def measure(self, robot: Robot, theta: Array, signals: Signals) -> Signals:
        q = signals.q.copy()
        q[:, self.active(robot)] -= theta
        return replace(signals, q=q)
