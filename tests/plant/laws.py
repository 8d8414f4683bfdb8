"""What friction does near zero speed: a smooth turn of finite width, bristles (LuGre), or true dry friction.

A law gives each sliding element a *direction* s in [-1, 1], which takes the place of sgn u; u (m,) is the element's speed and
its ``level`` (m,) [N m] is the friction torque far from zero speed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
WIDTH = 0.0035  # rad/s: the ordinary arm turns its friction within about two encoder steps a sample
PARTS = 6  # pieces of a step in which a bristle follows the motion
EDGE = np.linspace(0.0, 1.0, PARTS + 1)[:, None]
MIDDLE = (EDGE[1:] + EDGE[:-1]) / 2


@dataclass(frozen=True, eq=False)
class Smooth:
    """s = u / sqrt(u^2 + width^2); ``width`` (m,) or one for all [rad/s]."""

    width: Array | float = WIDTH

    def direction(self, u: Array) -> Array:
        """s (..., m) at speeds (..., m) [rad/s]."""
        return u / np.sqrt(u * u + np.square(self.width))

    def slope(self, u: Array) -> Array:
        """ds/du (..., m) [s/rad]."""
        square = np.square(self.width)
        return square * (u * u + square) ** -1.5


@dataclass(frozen=True, eq=False)
class Bristle:
    """LuGre: torque stiffness z + damping(u) dz/dt with dz/dt = u - |u| z stiffness/level(u), fields (m,).

    The bristle damping fades as exp(-(u/fade)^2), without which LuGre would give energy at high speed.
    ``stiffness`` [N m/rad], ``damping`` [N m s/rad], ``fade`` [rad/s].
    """

    stiffness: Array
    damping: Array
    fade: Array

    def damped(self, u: Array) -> Array:
        """Damping (..., m) [N m s/rad] at speeds (..., m) [rad/s]."""
        return self.damping * np.exp(-np.square(u / self.fade))

    def torque(self, u: Array, z: Array, level: Array) -> Array:
        """Torque (..., m) [N m] of deflections z (..., m) [rad]."""
        return self.stiffness * z + self.damped(u) * (u - np.abs(u) * z * self.stiffness / level)


@dataclass(frozen=True)
class Dry:
    """Set-valued Coulomb friction: a resting element takes any torque up to its level, a sliding one opposes its motion."""


Law = Smooth | Bristle | Dry


def path(x: Array, u: Array, step: float) -> tuple[Array, Array]:
    """Distances (N-1, PARTS, m) [rad] and middle speeds [rad/s] of the pieces of each step of a motion x, u (N, m).

    Between rows the motion is the cubic with the rows' positions and speeds, so a reversal within a step is not missed.
    """
    way, u0, u1 = (x[1:] - x[:-1])[:, None] / step, u[:-1, None], u[1:, None]
    bend, twist = 3 * way - 2 * u0 - u1, u0 + u1 - 2 * way
    place = step * EDGE * (u0 + EDGE * (bend + EDGE * twist))
    return place[:, 1:] - place[:, :-1], u0 + MIDDLE * (2 * bend + 3 * MIDDLE * twist)


def carry(distance: Array, reach: Array) -> tuple[Array, Array]:
    """(keep, gain), each (..., m): a deflection z becomes keep z + gain [rad] over the pieces (..., PARTS, m) of a step.

    ``reach`` (..., PARTS, m) [rad] is where dz = dx - |dx| z/reach levels off; exact where it is constant in a piece.
    """
    keep = np.exp(-np.abs(distance) / reach)
    fed = (1 - keep) * reach * np.sign(distance)
    later = np.asarray(np.cumprod(keep[..., ::-1, :], axis=-2), dtype=np.float64)[
        ..., ::-1, :
    ]  # of piece i and all after it
    gain = fed[..., -1, :] + (fed[..., :-1, :] * later[..., 1:, :]).sum(axis=-2)
    return later[..., 0, :], gain
