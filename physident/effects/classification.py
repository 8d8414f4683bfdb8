"""What an effect states of itself: columns and cones, family and place, how it is searched, and what simulators know of it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Variable = Literal["position", "velocity", "load", "torque", "temperature", "time"]


@dataclass(frozen=True)
class Column:
    """One parameter of an effect: its name, unit, joint or link (from 1), and the name of the effect."""

    name: str
    unit: str
    joint: int
    effect: str


def units_in_words(columns: Iterable[Column]) -> str:
    """The units of some columns, each once: those of joints that turn and of joints that slide differ."""
    return "|".join(dict.fromkeys(column.unit for column in columns))


@dataclass(frozen=True, eq=False)
class Cone:
    """A convex set for the parameters of one effect: ``map`` (m, k) @ theta + ``offset`` (m,) is not negative.

    Conditions on a sum over several effects are not cones of one effect: the inertia of a link (``Effect.inertia``) and
    the friction of a joint (``Effect.friction``) must be physical as sums.
    """

    map: Array
    offset: Array


def nonnegative(k: int) -> Cone:
    """The cone of k parameters that are not negative."""
    return Cone(np.eye(k), np.zeros(k))


def every_joint_pattern(n: int, k: int) -> NDArray[np.intp]:
    """The ``Effect.pattern`` (n k, 2) of k columns that are non-zero in the rows of all n joints."""
    return np.array([(joint, column) for column in range(k) for joint in range(n)], dtype=np.intp).reshape(-1, 2)


@dataclass(frozen=True, eq=False)
class AddedInertia:
    """Inertia that an effect adds to the arm: ``links`` (10 n,) in the order of ``Robot.nominal``, ``armature`` (n,)
    [kg m^2|kg] that only the joint's own acceleration feels, and ``gravity`` (3,) [m/s^2] added in the base frame."""

    links: Array
    armature: Array
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)


class Family(Enum):
    """The part of the physics that an effect belongs to."""

    INERTIA = "inertia"
    FRICTION = "friction"
    TRANSMISSION = "transmission"
    MEASUREMENT = "measurement"
    MOUNTING = "mounting"
    CONTACT = "contact"
    LEARNED = "learned"


class Scope(Enum):
    """Where an effect can act: on any single joint, on a pair of neighbouring joints, on a link, or on the whole arm."""

    JOINT = "joint"
    NEIGHBOURS = "pair of neighbouring joints"
    LINK = "link"
    WHOLE_ARM = "whole arm"

    def places(self, n: int) -> list[tuple[int, ...]]:
        """The places where the effect can act on an arm of n joints, each as joint numbers (from 1).

        The whole arm is one place without numbers. Links go from 1 to n - 1: a change of the last link is a payload.
        """
        if self is Scope.WHOLE_ARM:
            return [()]
        if self is Scope.NEIGHBOURS:
            return [(joint, joint + 1) for joint in range(1, n)]
        return [(joint,) for joint in range(1, n if self is Scope.LINK else n + 1)]

    @property
    def joins_joints(self) -> bool:
        """Whether the same effect on several joints is one finding; each pair and each link is a cause by itself."""
        return self in (Scope.JOINT, Scope.WHOLE_ARM)

    @property
    def noun(self) -> str:
        """What the effect's joint numbers count: "link" or "joint"."""
        return "link" if self is Scope.LINK else "joint"


class Detection(Enum):
    """How a diagnosis searches for an effect: at each of its places, in windows of time, after all others, or not at all."""

    BY_PLACE = "at each of its places"
    BY_TIME = "in windows of time"
    AFTER_LAWS = "where the laws of the catalogue leave structure"
    NEVER = "never, because other effects describe its changes"


@dataclass(frozen=True)
class JointTerm:
    """Passive torque that simulators know: damping w + dry sgn w + stiffness p, the same on each of ``joints`` (from 0).

    w and p are the sums of these joints' velocities and positions. None for a part that the effect does not state.
    """

    joints: tuple[int, ...]
    damping: float | None = None
    dry: float | None = None
    stiffness: float | None = None


@dataclass(frozen=True)
class ShapeParameter:
    """A parameter that the torque is not linear in, such as the Stribeck velocity.

    ``field`` is the attribute of the effect that holds one value for each joint, in ``unit``. Where it is not given, it
    is searched on ``grid`` within the recordings, and then refined unless only the grid's values make sense (``discrete``).
    Where nothing physical lies beyond its last or first value (``bounded``), data that prefer that value speak of another law.
    """

    field: str
    unit: str
    grid: tuple[float, ...]
    discrete: bool = False
    bounded: Literal["first", "last"] | None = None
