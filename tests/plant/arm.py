"""The arm: every truth about it in one frozen place, and the pinocchio model of its bodies."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cache, cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from tests.plant.drives import Drives
from tests.plant.friction import Friction
from tests.truth import Disturbance

Array = NDArray[np.float64]
URDF = Path(__file__).resolve().parents[2] / "physident" / "robots" / "ur5.urdf"
GRAVITY = 9.81  # m/s^2
TOOL = "tool0"
AMBIENT = 25.0  # degC


@lru_cache(maxsize=64)
def described(text: str) -> Any:
    """Pinocchio model of a URDF's text; copy it before a change."""
    model = pin.buildModelFromXML(re.sub(r"<(visual|collision)>.*?</\1>", "", text, flags=re.S))
    if model.nq != model.nv:
        raise ValueError("the description has a joint that is neither revolute nor prismatic")
    return model


@cache
def ur5() -> str:
    """The UR5's description, read as text."""
    return URDF.read_text(encoding="utf-8")


def nominal_links(text: str | None = None) -> Array:
    """Parameters (n, 10) of a description's links, by default the UR5's, in pinocchio's order."""
    return np.array([body.toDynamicParameters() for body in list(described(text or ur5()).inertias)[1:]])


@dataclass(frozen=True)
class Contact:
    """The tool pushes on its surroundings from ``start`` to ``end`` [s]: ``forces`` in the base frame [N], each for an equal
    part of that time."""

    start: float
    end: float
    forces: tuple[tuple[float, float, float], ...]

    def force(self, time: float) -> tuple[float, float, float] | None:
        """The force [N] at one time [s], or None."""
        piece = int(np.floor(len(self.forces) * (time - self.start) / (self.end - self.start) + 1e-9))
        return self.forces[piece] if 0 <= piece < len(self.forces) else None


@dataclass(frozen=True, eq=False)
class Dropped:
    """A load carried by the last link until ``time`` [s], then lost: ``body`` (10,) in pinocchio's order."""

    time: float
    body: Array


@dataclass(frozen=True)
class Hidden:
    """What was hidden: the effect's name, its joints (from 1), magnitude and shape."""

    effect: str
    joints: tuple[int, ...]
    magnitude: tuple[float, ...]
    shape: tuple[tuple[str, Any], ...] = ()


@dataclass(frozen=True, eq=False)
class Arm:
    """An arm of n joints as it truly is. Plain ``Arm()`` is an ordinary UR5: rigid links, rotors, Coulomb and viscous friction.

    ``links`` (n, 10) in pinocchio's order, any tool in the last; ``gravity`` (3,) [m/s^2] in the base frame; ``spring``
    (n,) [N m/rad] pulls a joint to zero; ``zero_offset`` (n,) [rad]: true position = encoder's + zero_offset, the sign of
    a column d tau/d q; ``temperature_rise`` (n,) [K] and ``temperature_time`` [s] of a first-order warming from
    ``ambient`` [degC]; ``description`` is the URDF's text, ``tool`` the frame that is pushed.
    """

    links: Array = field(default_factory=nominal_links)
    gravity: Array = field(default_factory=lambda: np.array([0.0, 0.0, -GRAVITY]))
    friction: Friction = field(default_factory=Friction)
    drives: Drives = field(default_factory=Drives)
    spring: Array = field(default_factory=lambda: np.zeros(6))
    contacts: tuple[Contact, ...] = ()
    zero_offset: Array = field(default_factory=lambda: np.zeros(6))
    temperature_rise: Array = field(default_factory=lambda: np.zeros(6))
    temperature_time: float = 13.0  # s
    hidden: tuple[Hidden, ...] = ()
    dropped: tuple[Dropped, ...] = ()
    disturbances: tuple[Disturbance, ...] = ()
    ambient: float = AMBIENT
    description: str = field(default_factory=ur5)
    tool: str = TOOL

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return len(self.links)

    @cached_property
    def bodies(self) -> Any:
        """Pinocchio model of the links; joints with a stiff gear carry their rotor as armature."""
        return self._carrying([load.body for load in self.dropped])

    @cached_property
    def carried(self) -> list[tuple[float, Any]]:
        """Pinocchio models and the times [s] from which they hold, in order: a load is carried until it is lost."""
        ends = sorted({load.time for load in self.dropped})
        later = [(end, self._carrying([d.body for d in self.dropped if d.time > end])) for end in ends]
        return [(-np.inf, self.bodies), *later]

    def _carrying(self, loads: list[Array]) -> Any:
        model = described(self.description).copy()
        for i, link in enumerate(self.links, 1):
            load = sum(loads, np.zeros(10)) if i == self.joints else 0.0
            model.inertias[i] = pin.Inertia.FromDynamicParameters(link + load)
        model.gravity.linear = self.gravity
        model.armature[:] = np.where(self.drives.compliance == 0, self.drives.rotor_inertia, 0.0)
        return model

    def temperature(self, time: Array) -> Array:
        """Joint temperatures (N, n) [degC] at times (N,) [s]."""
        return self.ambient + self.temperature_rise * (1 - np.exp(-time[:, None] / self.temperature_time))

    def contact_torque(self, data: Any, q: Array, time: float) -> Array | None:
        """Joint torque (n,) [N m] that the contacts take at link positions (n,), or None without contact."""
        forces = [f for contact in self.contacts if (f := contact.force(time)) is not None]
        if not forces:
            return None
        J = pin.computeFrameJacobian(self.bodies, data, q, self.bodies.getFrameId(self.tool), pin.LOCAL_WORLD_ALIGNED)
        return J[:3].T @ np.sum(forces, axis=0)
