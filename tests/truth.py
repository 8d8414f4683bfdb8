"""What is true of an arm: the description that every test plant reads, and what a plant returns.

It holds data, no physics: each plant writes its own laws, constants, integrator and control. Joints are numbered from 1.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionTruth:
    """Friction of n joints; every field is (n,), in N m (or N) and rad (or m).

    ``kind`` is the law near zero speed: "dry" is set-valued (a stuck joint stands still until its load exceeds the
    breakaway torque), "bristle" is LuGre with a Stribeck dip, "smooth" is a function of velocity of finite width. Away
    from zero speed all three approach coulomb sgn v + viscous v. ``breakaway`` >= ``coulomb`` is the level at the onset
    of motion, which falls to ``coulomb`` over ``stribeck_speed``. ``bristle_stiffness`` [N m/rad] and ``bristle_damping``
    [N m s/rad] matter to "bristle" only, ``width`` [rad/s] to "smooth" only. ``per_degree`` [1/K] is the relative fall of
    coulomb, breakaway and viscous friction for each kelvin that a recording is warmer.
    """

    kind: Literal["dry", "bristle", "smooth"]
    coulomb: Array
    viscous: Array
    breakaway: Array
    stribeck_speed: Array
    bristle_stiffness: Array
    bristle_damping: Array
    width: Array
    per_degree: Array


@dataclass(frozen=True, kw_only=True)
class HiddenEffect:
    """A change that a plant makes by itself: an effect of the catalogue by its public name, or a structural one.

    ``joints`` as the catalogue names them (empty for effects of the whole arm), ``size`` in the unit of the effect's
    parameter, ``shape`` its settings, for instance ``{"stribeck_speed": 0.1}``.
    """

    effect: str
    joints: tuple[int, ...]
    size: float
    shape: dict[str, Any] = field(default_factory=dict)


class Disturbance:
    """Physics that belongs to no plant and to no catalogue; each method leaves alone what a subclass does not change.

    A subclass is a frozen dataclass whose fields are all it needs: the same arguments give the same values.
    """

    def resist(self, time: float, q: Array, v: Array) -> Array | None:
        """Torque (n,) [N m] that the drives must overcome at one instant, or None; smooth in q and v, no sgn v."""
        return None

    def deliver(self, time: float, v: Array, torque: Array) -> Array:
        """Torque (n,) [N m] that really acts at one instant where control asks for, and the drive reports, ``torque``."""
        return torque

    def report(self, time: Array, q: Array, v: Array, torque: Array) -> Array:
        """Reported torque (N, n) [N m] at even times (N,) of a motion (N, n) whose motors gave ``torque``."""
        return torque


@dataclass(frozen=True, kw_only=True, eq=False)
class ArmTruth:
    """All that is true of one arm.

    ``urdf`` is its description as text: a serial arm of n revolute or prismatic joints, gravity along -z of the base.
    ``links`` (n, 10) replace the description's inertias, in pinocchio's order [m, mc, Ixx Ixy Iyy Ixz Iyz Izz] about the
    joint frame; ``rotor_inertia`` (n,) [kg m^2] at the joint; ``torque_offset`` (n,) [N m] of the reported torque.
    ``lower``, ``upper`` [rad], ``top_speed`` [rad/s] and ``top_acceleration`` [rad/s^2] (n,) bound its motions;
    ``bandwidth`` [rad/s] is that of its position control, ``tool`` the frame that carries loads and is pushed.
    """

    name: str
    urdf: str
    tool: str
    links: Array
    rotor_inertia: Array
    torque_offset: Array
    friction: FrictionTruth
    lower: Array
    upper: Array
    top_speed: Array
    top_acceleration: Array
    bandwidth: float
    background: tuple[Disturbance, ...] = ()
    effects: tuple[HiddenEffect, ...] = ()
    disturbances: tuple[Disturbance, ...] = ()

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return len(self.rotor_inertia)


class Motion(Protocol):
    """A plan of n joints over time, at rest at both ends."""

    @property
    def duration(self) -> float:
        """How long it lasts [s]."""
        ...

    def states(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities, accelerations (N, n) at times (N,) [s]."""
        ...


@dataclass(frozen=True, eq=False)
class Run:
    """What happened, at even and dense times (N,) [s], free of noise.

    ``q`` [rad], ``v`` [rad/s], ``a`` [rad/s^2] (N, n) as perfect encoders show the joints; ``torque`` (N, n) [N m] as a
    perfect instrument reports it, hidden effects of the measurement included; ``temperature`` (N, n) [degC];
    ``at_rest`` (N, n): the joint is stuck by friction (None where a plant cannot tell).
    """

    time: Array
    q: Array
    v: Array
    a: Array
    torque: Array
    temperature: Array
    at_rest: NDArray[np.bool_] | None


class Plant(Protocol):
    """A simulated arm under its own position control."""

    @property
    def name(self) -> str:
        """The engine in a word."""
        ...

    @property
    def effects(self) -> frozenset[str]:
        """Names of the ``HiddenEffect`` that it can do."""
        ...

    def simulate(self, arm: ArmTruth, motion: Motion, *, warmer: float = 0.0, step: float | None = None) -> Run:
        """The arm following a motion from rest; ``warmer`` [K]: how much warmer it is than at temperature 25 degC."""
        ...

    def torque_along(self, arm: ArmTruth, run: Run) -> Array:
        """Reported torque (N, n) [N m] that this arm needs for the encoder motion of another run, friction included."""
        ...
