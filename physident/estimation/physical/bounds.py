"""Known bounds of an arm: volumes that contain a link's mass, limits of single parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from physident.effects.effect import Column
from physident.errors import InputError
from physident.robots.inertia import pseudo_inertia

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Ellipsoid:
    """All mass of ``link`` (from 1) lies in an ellipsoid along its frame's axes: ``centre``, ``semi_axes`` (3,) [m]."""

    link: int
    centre: tuple[float, float, float]
    semi_axes: tuple[float, float, float]

    def __post_init__(self) -> None:
        _three(self.link, "centre", self.centre)
        _three(self.link, "semi_axes", self.semi_axes)
        if min(self.semi_axes) <= 0:
            raise InputError(f"link {self.link}: semi_axes are {self.semi_axes}, expected positive lengths [m]")

    def moments(self) -> list[Array]:
        """Symmetric (4, 4) Q with tr(Q P) >= 0 for every mass distribution inside.

        The mean of 1 - |(x - c) / s|^2 over the mass. Source: Wensing, Kim, Slotine (2018), proposition 3.
        """
        c, inverse = np.array(self.centre), np.diag(1 / np.square(self.semi_axes))
        Q = np.zeros((4, 4))
        Q[:3, :3], Q[:3, 3], Q[3, :3] = -inverse, inverse @ c, inverse @ c
        Q[3, 3] = 1 - c @ inverse @ c
        return [Q]


@dataclass(frozen=True)
class Box:
    """All mass of ``link`` (from 1) lies in a box along its frame's axes, from ``lower`` to ``upper`` (3,) [m]."""

    link: int
    lower: tuple[float, float, float]
    upper: tuple[float, float, float]

    def __post_init__(self) -> None:
        _three(self.link, "lower", self.lower)
        _three(self.link, "upper", self.upper)
        for axis, low, high in zip("xyz", self.lower, self.upper, strict=True):
            if low >= high:
                raise InputError(
                    f"link {self.link}: box from {low:g} to {high:g} m along {axis} is empty; expected lower below upper"
                )

    def moments(self) -> list[Array]:
        """Symmetric (4, 4) Q with tr(Q P) >= 0 for every mass distribution inside.

        The mean of the product of the distances to two faces, for every pair of faces, is not negative.
        """
        faces = []  # affine functions f . (x, 1) >= 0 inside
        for k in range(3):
            unit = np.eye(4)[k]
            faces += [unit - self.lower[k] * np.eye(4)[3], self.upper[k] * np.eye(4)[3] - unit]
        return [(np.outer(f, g) + np.outer(g, f)) / 2 for f, g in combinations(faces, 2)]


@dataclass(frozen=True)
class Bound:
    """``lower`` <= parameter <= ``upper`` in the parameter's unit, by name as in "m_6"; None for no bound on that side."""

    parameter: str
    lower: float | None = None
    upper: float | None = None

    def __post_init__(self) -> None:
        given = [x for x in (self.lower, self.upper) if x is not None]
        if not given or not all(map(math.isfinite, given)) or given != sorted(given):
            raise InputError(
                f"bounds of {self.parameter} are {self.lower} and {self.upper}, expected at least one finite number, and lower <= upper"
            )


def volume_rows(volume: Ellipsoid | Box, columns: Sequence[Column]) -> Array:
    """Rows (m, p) with rows @ theta >= 0 for a link inside its volume; raises InputError for a link that does not exist."""
    link_columns = [i for i, c in enumerate(columns) if c.effect == "rigid_body" and c.joint == volume.link]
    if len(link_columns) != 10:
        raise InputError(
            f"bounding volume of link {volume.link}: the model has no such link with rigid_body parameters"
        )
    rows = np.zeros((len(volume.moments()), len(columns)))
    units = [pseudo_inertia(unit) for unit in np.eye(10)]
    for row, Q in zip(rows, volume.moments(), strict=True):
        row[link_columns] = [np.sum(Q * unit) for unit in units]
    return rows


def bound_rows(bound: Bound, columns: Sequence[Column]) -> tuple[Array, Array]:
    """Rows (m, p) and offsets (m,) with rows @ theta + offsets >= 0; raises InputError for an unknown parameter."""
    places = [i for i, c in enumerate(columns) if c.name == bound.parameter]
    if len(places) != 1:
        names = ", ".join(c.name for c in columns if c.effect != "rigid_body")
        raise InputError(f"bound of unknown parameter {bound.parameter!r}, expected m_1, mcx_1, ... or one of {names}")
    unit = np.eye(len(columns))[places[0]]
    sides = [] if bound.lower is None else [(unit, -bound.lower)]
    sides += [] if bound.upper is None else [(-unit, bound.upper)]
    rows = np.array([row for row, _ in sides])
    return rows, np.array([offset for _, offset in sides])


def _three(link: int, what: str, values: Sequence[float]) -> None:
    if len(values) != 3 or not np.isfinite(values).all():
        raise InputError(f"link {link}: {what} is {tuple(values)}, expected three finite lengths [m]")
