"""What a real arm can be, as convex cones over the parameters of a model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.effects.effect import Column, Effect
from physident.estimation.physical.knowledge import Bound, Box, Ellipsoid, bound_rows, shape_rows
from physident.robots.inertia import pseudo_inertia
from physident.robots.robot import Robot

Array = NDArray[np.float64]
SPEEDS = 24  # points of the speed grid in each direction, evenly spaced from a tenth of the limit on
SLOW_SPEEDS = 8  # and below that, evenly spaced in the logarithm
SLOWEST = 1e-3  # rad/s, a tenth of the smooth sign's width
FREE_SPEED = math.pi  # rad/s: for joints that state no limit


@dataclass(frozen=True, eq=False)
class Matrix:
    """A symmetric matrix ``map`` (d, d, p) @ theta + ``offset`` that must be positive semidefinite, and its label.

    ``link`` is the number of the link whose pseudo-inertia it is where the rigid body alone makes it, None otherwise.
    """

    map: Array
    offset: Array
    label: str
    link: int | None = None

    def at(self, theta: Array) -> Array:
        """Its value (d, d)."""
        return self.map @ theta + self.offset


@dataclass(frozen=True, eq=False)
class Cones:
    """Physical parameters theta (p,): ``rows`` (m, p) @ theta + ``offsets`` (m,) >= 0, every matrix positive
    semidefinite, ``equal`` (k, p) @ theta = ``targets`` (k,). ``labels`` (m + k) say what each row is."""

    rows: Array
    offsets: Array
    matrices: tuple[Matrix, ...]
    equal: Array
    targets: Array
    labels: tuple[str, ...]

    def broken(self, theta: Array, tolerance: float = 1e-9) -> list[str]:
        """What ``theta`` (p,) violates by more than ``tolerance`` of the size of its terms, each named once."""
        size = np.abs(self.rows) @ np.abs(theta) + np.abs(self.offsets)
        names = [
            label
            for label, value, s in zip(self.labels, self.rows @ theta + self.offsets, size, strict=False)
            if value < -tolerance * s
        ]
        for matrix in self.matrices:
            values = np.linalg.eigvalsh(matrix.at(theta))
            if values[0] < -tolerance * np.abs(values).max():
                names.append(matrix.label)
        return list(dict.fromkeys(names))


def physical_cones(
    robot: Robot,
    effects: Sequence[Effect],
    total_mass: float | None = None,
    shapes: Sequence[Ellipsoid | Box] = (),
    bounds: Sequence[Bound] = (),
) -> Cones:
    """The cones of every effect, of each joint's friction as a sum, and of what is known about the arm."""
    columns = tuple(column for effect in effects for column in effect.columns(robot))
    rows: list[tuple[Array, Array, list[str]]] = []
    at = 0
    for effect in effects:
        own = slice(at, at + len(effect.columns(robot)))
        at = own.stop
        for cone in effect.cones(robot):
            whole = np.zeros((len(cone.map), len(columns)))
            whole[:, own] = cone.map
            rows.append((whole, cone.offset, [_sign_label(row, columns) for row in whole]))
    rows += [(r, np.zeros(len(r)), [f"friction of joint {j} drives it"] * len(r)) for j, r in friction(robot, effects)]
    for shape in shapes:
        inside = shape_rows(shape, columns)
        rows.append((inside, np.zeros(len(inside)), [f"mass of link {shape.link} outside its shape"] * len(inside)))
    for bound in bounds:
        inside, offset = bound_rows(bound, columns)
        rows.append((inside, offset, [f"{bound.parameter} outside its bounds"] * len(inside)))
    equal = np.zeros((0 if total_mass is None else 1, len(columns)))
    equal[:, [i for i, c in enumerate(columns) if c.effect == "rigid_body" and c.unit == "kg"]] = 1.0
    return Cones(
        np.concatenate([np.zeros((0, len(columns))), *(r for r, _, _ in rows)]),
        np.concatenate([np.zeros(0), *(o for _, o, _ in rows)]),
        tuple(link_matrices(robot, effects)), equal, np.full(len(equal), total_mass or 0.0),
        tuple(label for _, _, labels in rows for label in labels) + ("total mass differs from the known one",) * len(equal),
    )  # fmt: skip


def link_matrices(robot: Robot, effects: Sequence[Effect]) -> list[Matrix]:
    """The pseudo-inertia of each link as the sum over all effects that change it: a payload may be negative, a tool
    taken off, as long as the link with it is a body."""
    units = [(effect, unit) for effect in effects for unit in np.eye(len(effect.columns(robot)))]
    added = [effect.inertia(robot, unit) for effect, unit in units]
    links = np.array([np.zeros(10 * robot.n) if one is None else one.links for one in added]).T
    basis = np.stack([pseudo_inertia(unit) for unit in np.eye(10)], axis=-1)
    blocks = [(i + 1, links[10 * i : 10 * i + 10]) for i in range(robot.n)]
    alone = np.array([effect.name == "rigid_body" for effect, _ in units])
    return [
        Matrix(basis @ block, np.zeros((4, 4)), f"link {i} is no rigid body", None if block[:, ~alone].any() else i)
        for i, block in blocks
        if block.any()
    ]


def friction(robot: Robot, effects: Sequence[Effect]) -> list[tuple[int, Array]]:
    """For each joint (from 1) with friction, rows (S, p): the sum of its friction effects against the motion.

    rows @ theta = F(v) sgn v at speeds v in both directions, up to the joint's limit; each row scaled to one.
    """
    result = []
    for j in range(robot.n):
        limit = robot.velocity_limit[j] if math.isfinite(robot.velocity_limit[j]) else FREE_SPEED
        limit = max(limit, 100 * SLOWEST)
        slow = np.geomspace(SLOWEST, limit / 10, SLOW_SPEEDS, endpoint=False)
        speeds = np.concatenate([slow, np.linspace(limit / 10, limit, SPEEDS)])
        v = np.concatenate([-speeds[::-1], speeds])
        blocks = []
        for effect in effects:
            own = np.array([column.joint == j + 1 for column in effect.columns(robot)])
            blocks.append((effect.friction(robot, v) * np.sign(v)) * own[:, None])
        rows = np.concatenate(blocks).T
        size = np.abs(rows).max(axis=1)
        if size.any():
            result.append((j + 1, np.unique((rows[size > 0].T / size[size > 0]).T.round(12), axis=0)))
    return result


def links(columns: Sequence[Column]) -> list[tuple[int, slice]]:
    """Number (from 1) and the ten columns of each link of the rigid-body effect."""
    first = [i for i, c in enumerate(columns) if c.effect == "rigid_body" and c.name.startswith("m_")]
    return [(columns[i].joint, slice(i, i + 10)) for i in first]


def _sign_label(row: Array, columns: Sequence[Column]) -> str:
    names = [column.name for column, factor in zip(columns, row, strict=True) if factor]
    return f"{names[0]} is negative" if len(names) == 1 else f"{' + '.join(names)} is out of its range"
