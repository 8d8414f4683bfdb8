"""Inertia: the links and rotors that the robot's description states, a payload on the last link, and a change of any other link."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.rigid_body_regressor import torque_entries_of, torque_pattern
from physident.effects.classification import Detection, Family, Scope, nonnegative
from physident.effects.effect import AddedInertia, Array, Column, Cone, Effect
from physident.errors import InputError
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


@dataclass(frozen=True)
class LinkChange(Effect):
    """Ten parameters added to some links, with the columns of the rigid body for these links."""

    unit: ClassVar[str] = "kg, kg m, kg m^2"
    family: ClassVar[Family] = Family.INERTIA
    within_model: ClassVar[bool] = True

    def links(self, robot: Robot) -> list[int]:
        """The links it changes, as indices from 0."""
        return self.active(robot)

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        names = list(zip(PARAMETER_NAMES, PARAMETER_UNITS, strict=True))
        return tuple(
            Column(f"{self.name}_{name}_{i + 1}", unit, i + 1, self.name)
            for i in self.links(robot)
            for name, unit in names
        )

    def _entries(self, robot: Robot) -> NDArray[np.intp]:
        """Which structural non-zeros of the rigid body belong to its links."""
        return np.flatnonzero(np.isin(torque_pattern(robot)[:, 1] // 10, self.links(robot)))

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        rows, columns = torque_pattern(robot)[self._entries(robot)].T
        position = {link: k for k, link in enumerate(self.links(robot))}
        effect_columns = [10 * position[c // 10] + c % 10 for c in columns.tolist()]
        return np.column_stack([rows, effect_columns]).astype(np.intp)

    def values(self, robot: Robot, signals: Signals) -> Array:
        return torque_entries_of(robot, signals)[self._entries(robot)]

    def inertia(self, robot: Robot, theta: Array) -> AddedInertia:
        links = np.zeros((robot.n, 10))
        links[self.links(robot)] = theta.reshape(-1, 10)
        return AddedInertia(links.ravel(), np.zeros(robot.n))


@dataclass(frozen=True)
class Payload(LinkChange):
    """tau = Y_n theta: a body fixed to the last link, ten parameters in that link's joint frame (thesis eq. 3.41).

    Mass in kg, first moments in kg m, inertia about the frame's origin in kg m^2; negative for a tool that was removed.
    """

    name: ClassVar[str] = "payload"
    scope: ClassVar[Scope] = Scope.WHOLE_ARM
    signature: ClassVar[str] = "gravity and inertia torques both fit one mass at the last link"
    mistaken_for: ClassVar[str] = "a torque constant common to all joints: record with a known payload"

    def links(self, robot: Robot) -> list[int]:
        return [robot.n - 1]

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        names = ("mass", *PARAMETER_NAMES[1:])
        return tuple(
            Column(f"{self.name}_{name}", unit, robot.n, self.name)
            for name, unit in zip(names, PARAMETER_UNITS, strict=True)
        )


@dataclass(frozen=True)
class LinkInertia(LinkChange):
    """tau = Y_i theta: a change of link i's ten parameters, i from 1 to n - 1; ``joints`` gives the links."""

    name: ClassVar[str] = "link_inertia"
    scope: ClassVar[Scope] = Scope.LINK
    signature: ClassVar[str] = "torque on the joint of this link and on the joints before it"
    mistaken_for: ClassVar[str] = "a change of another link: compare the subspaces of their columns"

    def links(self, robot: Robot) -> list[int]:
        links = self.active(robot)
        if self.joints is None and len(links) < 2:
            raise InputError(
                f"link_inertia: robot {robot.name} has only one link; use payload for a change of the last link"
            )
        return links[:-1] if self.joints is None else links
