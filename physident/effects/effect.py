"""What an effect is: columns of a regressor, with names, units and cones."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import asdict, dataclass
from typing import Any, ClassVar, Literal, final

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.robot import Robot
from physident.signals import Signals

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Column:
    """One parameter: its name, unit, the joint or link (from 1) it belongs to, and its effect's name."""

    name: str
    unit: str
    joint: int
    effect: str


@dataclass(frozen=True, eq=False)
class Cone:
    """A convex set of an effect's parameters: ``map`` @ theta + ``offset`` is in ``kind``.

    ``kind`` "nonnegative": ``map`` (m, k); "psd": ``map`` (d, d, k), a symmetric matrix that is positive semidefinite.
    """

    kind: Literal["nonnegative", "psd"]
    map: Array
    offset: Array


@dataclass(frozen=True)
class Effect(ABC):
    """A physical effect: torque that is linear in its parameters, tau = Phi(q, v, a) theta.

    ``joints`` (from 1) restricts it to some joints, None for all. A subclass has at most one parameter for each joint
    unless it says otherwise, and needs only ``values``.
    """

    joints: tuple[int, ...] | None = None

    name: ClassVar[str]
    unit: ClassVar[str]
    acts_on: ClassVar[Literal["plant", "measurement", "sensor"]] = "plant"

    def active(self, robot: Robot) -> list[int]:
        """Indices (from 0) of the joints it acts on; raises InputError for a joint the robot does not have."""
        if self.joints is None:
            return list(range(robot.n))
        for joint in self.joints:
            if not 1 <= joint <= robot.n:
                raise InputError(f"{self.name}: joint {joint} does not exist, expected 1 to {robot.n}")
        return [joint - 1 for joint in self.joints]

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        """Names and units of its k parameters."""
        return tuple(Column(f"{self.name}_{j + 1}", self.unit, j + 1, self.name) for j in self.active(robot))

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        """(E, 2): joint row and own column (from 0) of each structural non-zero, in the order of ``values``."""
        active = self.active(robot)
        return np.column_stack([active, np.arange(len(active))]).astype(np.intp).reshape(-1, 2)

    @abstractmethod
    def values(self, robot: Robot, signals: Signals) -> Array:
        """Structural non-zeros (E, N) of its regressor; the unit is N m (or N) over the parameter's own."""

    @final
    def regressor(self, robot: Robot, signals: Signals) -> Array:
        """Regressor (N, n, k): torque [N m|N] for each unit of each parameter."""
        pattern = self.pattern(robot)
        Phi = np.zeros((len(signals.time), robot.n, len(self.columns(robot))))
        Phi[:, pattern[:, 0], pattern[:, 1]] = self.values(robot, signals).T
        return Phi

    def nominal(self, robot: Robot) -> Array:
        """Parameters (k,) that the robot's own description states; zero where it states none."""
        return np.zeros(len(self.columns(robot)))

    def cones(self, robot: Robot) -> tuple[Cone, ...]:
        """Convex sets its parameters must lie in to be physical; none unless it says so.

        Friction needs none of its own: all friction of a joint must dissipate as a sum, see ``friction``.
        """
        return ()

    def friction(self, robot: Robot, speeds: Array) -> Array:
        """Friction (k, S) [N m|N] of each unit of each parameter at speeds (S,) [rad/s|m/s] of its joint, unloaded.

        Zero unless it says so. The sum over all effects of a joint must oppose its motion: F(v) v >= 0.
        """
        return np.zeros((len(self.columns(robot)), len(speeds)))

    @final
    def as_dict(self) -> dict[str, Any]:
        """Its name and settings, as JSON can hold them."""
        return {"effect": self.name, **{key: _plain(value) for key, value in asdict(self).items()}}


def nonnegative(k: int) -> Cone:
    """The cone of k parameters that are not negative."""
    return Cone("nonnegative", np.eye(k), np.zeros(k))


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value
