"""The rigid bodies of an arm: its pinocchio model, and how true bodies differ from described ones."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

Array = NDArray[np.float64]


@lru_cache(maxsize=32)
def _built(urdf: str, links: bytes) -> tuple[Any, Any]:
    model = pin.buildModelFromXML(urdf)
    if links:
        for number, row in enumerate(np.frombuffer(links).reshape(-1, 10), 1):
            model.inertias[number] = pin.Inertia.FromDynamicParameters(row)
    return model, model.createData()


def rigid(urdf: str, links: Array | None = None) -> tuple[Any, Any]:
    """Model and data of an arm, with its own inertias or with ``links`` (n, 10) [SI]; kept for the next call."""
    return _built(urdf, b"" if links is None else np.ascontiguousarray(links).tobytes())


def described(urdf: str) -> Array:
    """Inertial parameters (n, 10) of the description, in pinocchio's order."""
    model, _ = rigid(urdf)
    return np.array([body.toDynamicParameters() for body in list(model.inertias)[1:]])


def pseudo_inertia(row: Array) -> Array:
    """Second moments (4, 4) of a body's mass with 1 as the fourth coordinate, from its parameters (10,)."""
    xx, xy, yy, xz, yz, zz = row[4:]
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    moments = np.empty((4, 4))
    moments[:3, :3] = np.trace(tensor) / 2 * np.eye(3) - tensor
    moments[:3, 3] = moments[3, :3] = row[1:4]
    moments[3, 3] = row[0]
    return moments


def parameters(moments: Array) -> Array:
    """Parameters (10,) of a body from its pseudo-inertia (4, 4)."""
    second = moments[:3, :3]
    tensor = np.trace(second) * np.eye(3) - second
    places = ([0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2])
    return np.concatenate([[moments[3, 3]], moments[:3, 3], tensor[places]])


def deformed(row: Array, amount: float, rng: np.random.Generator) -> Array:
    """Parameters (10,) of a body whose mass is stretched, sheared and shifted about its centre, and made heavier.

    ``amount`` is the relative size of each change. A body of positive mass stays one: its mass is moved, never made up.
    """
    moments = pseudo_inertia(row)
    centre = row[1:4] / row[0]
    about_centre = moments[:3, :3] / row[0] - np.outer(centre, centre)
    reach = np.sqrt(np.trace(about_centre))
    stretch = np.eye(3) + amount * rng.standard_normal((3, 3))
    move = np.eye(4)
    move[:3, :3] = stretch
    move[:3, 3] = centre - stretch @ centre + amount * reach * rng.standard_normal(3)
    return parameters(np.exp(amount * rng.standard_normal()) * move @ moments @ move.T)


def with_lump(row: Array, mass: float, centre: Array, radius: float) -> Array:
    """Parameters (10,) of a body with a solid ball of ``mass`` [kg] and ``radius`` [m] at ``centre`` [m] more."""
    point = np.append(centre, 1.0)
    ball = mass * np.outer(point, point)
    ball[:3, :3] += mass * radius**2 / 5 * np.eye(3)
    return parameters(pseudo_inertia(row) + ball)
