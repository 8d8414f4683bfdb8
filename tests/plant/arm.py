"""The arm: every truth about it in one frozen place, and the pinocchio model of its bodies."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from tests.plant.drives import Drives
from tests.plant.friction import Friction

Array = NDArray[np.float64]
URDF = Path(__file__).resolve().parents[2] / "physident" / "robots" / "ur5.urdf"
GRAVITY = 9.81  # m/s^2
TOOL = "tool0"
PIECE = 0.5  # s: a contact's force is constant for so long
AMBIENT = 25.0  # degC


@cache
def _bodies() -> Any:
    text = re.sub(r"<(visual|collision)>.*?</\1>", "", URDF.read_text(encoding="utf-8"), flags=re.S)
    return pin.buildModelFromXML(text)


def nominal_links() -> Array:
    """Parameters (6, 10) of the UR5's links, in pinocchio's order."""
    return np.array([body.toDynamicParameters() for body in list(_bodies().inertias)[1:]])


@dataclass(frozen=True)
class Contact:
    """The tool pushes on its surroundings: ``forces`` in the base frame [N], one for each half second from ``start`` [s]."""

    start: float
    forces: tuple[tuple[float, float, float], ...]

    def force(self, time: float) -> tuple[float, float, float] | None:
        """The force [N] at one time [s], or None."""
        piece = int(np.floor((time - self.start) / PIECE + 1e-9))
        return self.forces[piece] if 0 <= piece < len(self.forces) else None


@dataclass(frozen=True)
class Hidden:
    """What was hidden: the effect's name, its joints (from 1), magnitude and shape."""

    effect: str
    joints: tuple[int, ...]
    magnitude: tuple[float, ...]
    shape: tuple[tuple[str, Any], ...] = ()


@dataclass(frozen=True, eq=False)
class Arm:
    """A UR5 as it truly is. Plain ``Arm()`` is the ordinary one: rigid links, rotors, Coulomb and viscous friction.

    ``links`` (6, 10) in pinocchio's order, any tool in the last; ``gravity`` (3,) [m/s^2] in the base frame; ``spring``
    (6,) [N m/rad] pulls a joint to zero; ``zero_offset`` (6,) [rad]: true position = encoder's + zero_offset, the sign of
    a column d tau/d q; ``temperature_rise`` (6,) [K] and ``temperature_time`` [s] of a first-order warming.
    """

    links: Array = field(default_factory=nominal_links)
    gravity: Array = field(default_factory=lambda: np.array([0.0, 0.0, -GRAVITY]))
    friction: Friction = field(default_factory=Friction)
    drives: Drives = field(default_factory=Drives)
    spring: Array = field(default_factory=lambda: np.zeros(6))
    contacts: tuple[Contact, ...] = ()
    zero_offset: Array = field(default_factory=lambda: np.zeros(6))
    temperature_rise: Array = field(default_factory=lambda: np.zeros(6))
    temperature_time: float = 15.0
    hidden: tuple[Hidden, ...] = ()

    @cached_property
    def bodies(self) -> Any:
        """Pinocchio model of the links; joints with a stiff gear carry their rotor as armature."""
        model = _bodies().copy()
        for i, link in enumerate(self.links, 1):
            model.inertias[i] = pin.Inertia.FromDynamicParameters(link)
        model.gravity.linear = self.gravity
        stiff = self.drives.compliance == 0
        model.armature[:] = np.where(stiff, self.drives.rotor_inertia, 0.0)
        return model

    def temperature(self, time: Array) -> Array:
        """Joint temperatures (N, 6) [degC] at times (N,) [s]."""
        return AMBIENT + self.temperature_rise * (1 - np.exp(-time[:, None] / self.temperature_time))

    def contact_torque(self, data: Any, q: Array, time: float) -> Array | None:
        """Joint torque (6,) [N m] that the contacts take at link positions (6,), or None without contact."""
        forces = [f for contact in self.contacts if (f := contact.force(time)) is not None]
        if not forces:
            return None
        frame = self.bodies.getFrameId(TOOL)
        J = pin.computeFrameJacobian(self.bodies, data, q, frame, pin.LOCAL_WORLD_ALIGNED)
        return J[:3].T @ np.sum(forces, axis=0)
