"""Causes at the tool or in the ground, which reach all joints through the arm's own geometry."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from studies.open_world_second.bodies import rigid
from tests.truth import Disturbance

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class ToolCause(Disturbance):
    """A force that the tool must exert on its surroundings, in proportion to ``size``; a subclass writes it."""

    urdf: str
    tool: str
    size: float

    def unit(self, time: float, place: Array, speed: Array) -> Array:
        """Force (3,) [N] on the surroundings at size 1, tool place (3,) [m] and velocity (3,) [m/s] in the base frame."""
        raise NotImplementedError

    def resist(self, time: float, q: Array, v: Array) -> Array:
        place, jacobian = tool_at(self.urdf, self.tool, q)
        return jacobian.T @ (self.size * self.unit(time, place, jacobian @ v))


@dataclass(frozen=True, kw_only=True, eq=False)
class StirredFluid(ToolCause):
    """The tool stirs a bath: drag ``size`` [N s^2/m^2] times the square of its speed."""

    def unit(self, time: float, place: Array, speed: Array) -> Array:
        return np.sqrt(speed @ speed) * speed


@dataclass(frozen=True, kw_only=True, eq=False)
class MagneticDrag(ToolCause):
    """A magnet at the tool brakes itself near a metal sheet: drag ``size`` [N s/m], less by e at ``reach`` [m] from it.

    The sheet goes through ``through`` (3,) [m] with the ``normal`` (3,).
    """

    through: Array
    normal: Array
    reach: float

    def unit(self, time: float, place: Array, speed: Array) -> Array:
        away = (place - self.through) @ self.normal / self.reach
        return np.exp(-away * away) * speed


@dataclass(frozen=True, kw_only=True, eq=False)
class TautCord(ToolCause):
    """A cord from the tool to an ``anchor`` (3,) [m] pulls with ``size`` [N/m] beyond its ``slack`` length [m]."""

    anchor: Array
    slack: float
    rounding: float

    def unit(self, time: float, place: Array, speed: Array) -> Array:
        cord = place - self.anchor
        length = float(np.sqrt(cord @ cord))
        past = length - self.slack
        return (past + np.hypot(past, self.rounding)) / 2 * cord / length


@dataclass(frozen=True, kw_only=True, eq=False)
class PulsatingTool(ToolCause):
    """A tool with a slow crank: a force of ``size`` [N] along ``way`` (3,) with ``frequency`` [Hz] and an overtone."""

    way: Array
    frequency: float
    phase: float

    def unit(self, time: float, place: Array, speed: Array) -> Array:
        angle = 2 * np.pi * self.frequency * time + self.phase
        return (np.sin(angle) + 0.4 * np.sin(2 * angle + 1)) * self.way


@dataclass(frozen=True, kw_only=True, eq=False)
class RockingFloor(Disturbance):
    """The floor rocks by ``size`` [rad], once every ``periods`` [s] about each of two level axes, as on a ship.

    ``links`` (n, 10) are the arm's true bodies; only the turned weight counts, the floor moves too slowly for more.
    """

    urdf: str
    links: Array
    size: float
    periods: tuple[float, float]
    phases: tuple[float, float]

    def resist(self, time: float, q: Array, v: Array) -> Array:
        angle = 2 * np.pi * time / np.array(self.periods) + np.array(self.phases)
        x, y = self.size * np.sin(angle)
        upright = np.sqrt(max(0.0, 1 - x * x - y * y))
        model, data = rigid(self.urdf, self.links)
        kept = model.gravity.linear.copy()
        strength = float(np.linalg.norm(kept))
        try:
            # weight is linear in gravity, so its change is the weight in the change of gravity
            model.gravity.linear = strength * np.array([x, y, 1 - upright])
            return pin.computeGeneralizedGravity(model, data, q).copy()
        finally:
            model.gravity.linear = kept


def tool_at(urdf: str, tool: str, q: Array) -> tuple[Array, Array]:
    """Place (3,) [m] of the tool and its Jacobian (3, n), both in the base frame."""
    model, data = rigid(urdf)
    frame: Any = model.getFrameId(tool)
    jacobian = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)[:3]
    return pin.updateFramePlacement(model, data, frame).translation.copy(), jacobian
