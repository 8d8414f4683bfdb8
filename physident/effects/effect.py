"""What an effect is: columns of a regressor, with names, units and cones."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar, Literal, final

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

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
    """A convex set of an effect's own parameters: ``map`` (m, k) @ theta + ``offset`` (m,) is not negative.

    What several effects share needs no cone of theirs: a link's inertia (``inertia``) and a joint's friction
    (``friction``) must be physical as sums.
    """

    map: Array
    offset: Array


@dataclass(frozen=True)
class Shape:
    """A parameter that torque is not linear in: the effect's ``field`` that holds it, one value for each joint it acts
    on, its unit, the ``grid`` it is searched on inside the fitting data, and whether only the grid's values make sense."""

    field: str
    unit: str
    grid: tuple[float, ...]
    discrete: bool = False


@dataclass(frozen=True, eq=False)
class AddedInertia:
    """Inertia that an effect adds to the plant: ``links`` (10 n,) in the order of ``Robot.nominal``, ``armature`` (n,)
    [kg m^2|kg] felt only by a joint's own acceleration, ``gravity`` (3,) [m/s^2] added in the base frame."""

    links: Array
    armature: Array
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)


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
    shapes: ClassVar[tuple[Shape, ...]] = ()
    pointwise: ClassVar[bool] = True  # each sample's value depends on that sample alone
    needs_model: ClassVar[bool] = False  # its columns depend on the model's own torque or link parameters
    signature: ClassVar[str] = ""  # how it shows, in words
    rivals: ClassVar[str] = ""  # what it is mistaken for, and what separates them

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

    def shape(self, robot: Robot, field: str) -> Array:
        """Values (k,) of a shape parameter for the joints it acts on; raises InputError where it is not set."""
        values = getattr(self, field)
        count = len(self.active(robot))
        if values is None or len(values) not in (1, count):
            came = "not set" if values is None else f"{len(values)} values"
            raise InputError(f"{self.name}: {field} is {came}, expected {count}, one a joint; identify finds them")
        return np.broadcast_to(np.array(values, dtype=float), (count,))

    def unsettled(self, robot: Robot, signals: Signals) -> NDArray[np.bool_] | None:
        """Samples (N, n) of one segment whose value still depends on what was before it; None where none do."""
        return None

    def anywhere(self) -> tuple[Effect, float]:
        """The effect as a question of structure, free of any recording's time, and how many seconds it needs for that."""
        return self, 0.0

    def cutoff_needed(self, robot: Robot, signals: Signals) -> float:
        """The cutoff [Hz] below which the common filter takes its signature away; 0 where any band will do."""
        return 0.0

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

    def inertia(self, robot: Robot, theta: Array) -> AddedInertia | None:
        """The inertia it adds to a simulated plant, when its torque (parameters ``theta`` (k,)) is that of inertia
        alone; None, the default, when ``torque_at`` is to be evaluated."""
        return None

    def state_size(self, robot: Robot) -> int:
        """Number S of internal states of a simulated plant, such as a bristle's deflection for each joint; none unless
        it says so. They start at zero."""
        return 0

    def state_rate(self, robot: Robot, signals: Signals, state: Array) -> Array:
        """Derivative (S, N) of its internal state (S, N) at N unrelated instants."""
        return np.zeros_like(state)

    def torque_at(self, robot: Robot, signals: Signals, state: Array, load: Array) -> Array:
        """Structural non-zeros (E, N) as ``values``, at N unrelated instants of a simulated plant.

        ``state`` (S, N) is its internal state, ``load`` (N, n) [N m|N] the torque of inertia and gravity. By default
        ``values``: an effect overrides it where that needs the past or another effect's torque.
        """
        return self.values(robot, signals)

    def measure(self, robot: Robot, theta: Array, signals: Signals) -> Signals:
        """What a simulated arm's instruments show of true signals, whose torque (N, n) is the drive's.

        An effect on the plant changes nothing here. Any other adds its torque: exact for the torque's measurement, to
        first order for a sensor of motion, which may override it with the map itself.
        """
        if self.acts_on == "plant" or signals.torque is None:
            return signals
        return replace(signals, torque=signals.torque + self.regressor(robot, signals) @ theta)

    @final
    def as_dict(self) -> dict[str, Any]:
        """Its name and settings, as JSON can hold them."""
        return {"effect": self.name, **{key: _plain(value) for key, value in asdict(self).items()}}


def nonnegative(k: int) -> Cone:
    """The cone of k parameters that are not negative."""
    return Cone(np.eye(k), np.zeros(k))


def _plain(value: Any) -> Any:
    return [_plain(v) for v in value] if isinstance(value, tuple) else value
