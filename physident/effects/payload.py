"""Mass that the robot's description does not know: a payload at the last link, a change of any other link."""

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
class LinkChange(Effect):
    """Ten parameters added to some links, through the columns that the rigid body has for them."""

    unit: ClassVar[str] = "kg, kg m, kg m^2"

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

    def _own(self, robot: Robot) -> NDArray[np.intp]:
        return np.flatnonzero(np.isin(torque_pattern(robot)[:, 1] // 10, self.links(robot)))

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        own = torque_pattern(robot)[self._own(robot)]
        place = {link: at for at, link in enumerate(self.links(robot))}
        columns = [10 * place[c // 10] + c % 10 for c in own[:, 1].tolist()]
        return np.column_stack([own[:, 0], columns]).astype(np.intp)

    def values(self, robot: Robot, signals: Signals) -> Array:
        return torque_entries(robot, signals.q, signals.v, signals.a)[self._own(robot)]

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
    signature: ClassVar[str] = "gravity and inertia agree on one mass"
    rivals: ClassVar[str] = "a torque constant common to all joints; link_inertia of the last link is the same thing"

    def __post_init__(self) -> None:
        if self.joints is not None:
            raise InputError("payload sits at the last link; expected no joints setting")

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
    """tau = Y_i theta: a change of link i's ten parameters, i from 1 to n - 1 (``joints`` names the links)."""

    name: ClassVar[str] = "link_inertia"
    signature: ClassVar[str] = "torque in the rows of this link's joint and those before it"
    rivals: ClassVar[str] = "other links: compare the subspaces of their columns"

    def links(self, robot: Robot) -> list[int]:
        links = self.active(robot)
        if self.joints is None and len(links) < 2:
            raise InputError(
                f"link_inertia: robot {robot.name} has one link, whose change is payload; expected that effect"
            )
        return links[:-1] if self.joints is None else links
