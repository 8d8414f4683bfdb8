"""Mass that the robot's description does not include: a payload on the last link, or a change of any other link."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.rigid_body_regressor import torque_entries_of, torque_pattern
from physident.effects.classification import Family, Scope
from physident.effects.effect import AddedInertia, Array, Column, Effect
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.inertia import PARAMETER_NAMES, PARAMETER_UNITS
from physident.robots.robot import Robot


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
