"""Physical consistency as convex cones over the parameters of a model: rigid bodies, dissipating friction, known bounds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.effects.effect import Column, Effect
from physident.estimation.physical.bounds import Bound, Box, Ellipsoid, bound_rows, volume_rows
from physident.robots.inertia import pseudo_inertia
from physident.robots.robot import Robot

Array = NDArray[np.float64]
SPEEDS = 24  # points of the speed grid in each direction, evenly spaced from a tenth of the limit on
SLOW_SPEEDS = 8  # and below that, evenly spaced in the logarithm
SLOWEST = 1e-3  # rad/s: there the sharpest sign has turned to three quarters
FREE_SPEED = math.pi  # rad/s: for joints that state no limit


@dataclass(frozen=True, eq=False)
class MatrixInequality:
    """A linear matrix inequality (LMI): ``map`` (d, d, p) @ theta + ``offset`` (d, d) is positive semidefinite.

    ``label`` says what is wrong where it is not. ``link`` is the number (from 1) of the link whose pseudo-inertia the
    matrix is, None where other effects than the rigid body contribute to it.
    """

    map: Array
    offset: Array
    label: str
    link: int | None = None

    def at(self, theta: Array) -> Array:
        """Its value (d, d)."""
        return self.map @ theta + self.offset


@dataclass(frozen=True, eq=False, kw_only=True)
class Cones:
    """The set of physical parameters theta (p,).

    ``rows`` (m, p) @ theta + ``offsets`` (m,) >= 0, every matrix of ``matrices`` positive semidefinite, ``equal`` (k, p)
    @ theta = ``targets`` (k,). ``labels`` (m + k) say what is wrong where a row is violated.
    """

    rows: Array
    offsets: Array
    matrices: tuple[MatrixInequality, ...]
    equal: Array
    targets: Array
    labels: tuple[str, ...]

    def broken(self, theta: Array, tolerance: float = 1e-9) -> list[str]:
        """Labels of what ``theta`` (p,) violates by more than ``tolerance`` of the size of its terms, each once."""
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
    bounding_volumes: Sequence[Ellipsoid | Box] = (),
    bounds: Sequence[Bound] = (),
) -> Cones:
    """The cones of every effect, of each joint's total friction, and of the given bounds.

    Raises InputError for a bounding volume of a link that does not exist, or a bound of an unknown parameter.
    """
    columns = tuple(column for effect in effects for column in effect.columns(robot))
    blocks = _effect_rows(robot, effects, columns)
    for joint, rows in friction_rows(robot, effects):
        blocks.append(_Rows.all_labelled(f"friction of joint {joint} drives it", rows))
    for volume in bounding_volumes:
        label = f"mass of link {volume.link} outside its bounding volume"
        blocks.append(_Rows.all_labelled(label, volume_rows(volume, columns)))
    for bound in bounds:
        blocks.append(_Rows.all_labelled(f"{bound.parameter} outside its bounds", *bound_rows(bound, columns)))
    equal = np.zeros((0 if total_mass is None else 1, len(columns)))
    equal[:, [i for i, c in enumerate(columns) if c.effect == "rigid_body" and c.unit == "kg"]] = 1.0
    labels = [label for block in blocks for label in block.labels]
    return Cones(
        rows=np.concatenate([np.zeros((0, len(columns))), *(block.rows for block in blocks)]),
        offsets=np.concatenate([np.zeros(0), *(block.offsets for block in blocks)]),
        matrices=tuple(link_matrices(robot, effects)),
        equal=equal,
        targets=np.full(len(equal), total_mass or 0.0),
        labels=(*labels, *["total mass differs from the known one"] * len(equal)),
    )


@dataclass(frozen=True, eq=False)
class _Rows:
    """Some inequalities ``rows`` (m, p) @ theta + ``offsets`` (m,) >= 0 with a label each."""

    rows: Array
    offsets: Array
    labels: list[str]

    @staticmethod
    def all_labelled(label: str, rows: Array, offsets: Array | None = None) -> _Rows:
        return _Rows(rows, np.zeros(len(rows)) if offsets is None else offsets, [label] * len(rows))


def _effect_rows(robot: Robot, effects: Sequence[Effect], columns: Sequence[Column]) -> list[_Rows]:
    """The cones that each effect states for its own parameters."""
    blocks, start = [], 0
    for effect in effects:
        stop = start + len(effect.columns(robot))
        for cone in effect.cones(robot):
            rows = np.zeros((len(cone.map), len(columns)))
            rows[:, start:stop] = cone.map
            blocks.append(_Rows(rows, cone.offset, [_sign_label(row, columns) for row in rows]))
        start = stop
    return blocks


def link_matrices(robot: Robot, effects: Sequence[Effect]) -> list[MatrixInequality]:
    """The pseudo-inertia of each link as the sum over all effects that change it.

    A payload may be negative, such as a tool that was removed, as long as the link with it is a rigid body.
    """
    units = [(effect, unit) for effect in effects for unit in np.eye(len(effect.columns(robot)))]
    added = [effect.inertia(robot, unit) for effect, unit in units]
    links = np.array([np.zeros(10 * robot.n) if one is None else one.links for one in added]).T
    basis = np.stack([pseudo_inertia(unit) for unit in np.eye(10)], axis=-1)
    blocks = [(i + 1, links[10 * i : 10 * i + 10]) for i in range(robot.n)]
    alone = np.array([effect.name == "rigid_body" for effect, _ in units])
    return [
        MatrixInequality(
            basis @ block, np.zeros((4, 4)), f"link {i} is not a rigid body", None if block[:, ~alone].any() else i
        )
        for i, block in blocks
        if block.any()
    ]


def friction_rows(robot: Robot, effects: Sequence[Effect]) -> list[tuple[int, Array]]:
    """For each joint (from 1) with friction, rows (S, p) with rows @ theta = F(v) sgn v >= 0.

    F is the sum of the joint's friction effects, v are speeds in both directions up to the joint's limit. The largest
    entry of each row is scaled to one.
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
            on_joint = np.array([column.joint == j + 1 for column in effect.columns(robot)])
            blocks.append((effect.friction(robot, v) * np.sign(v)) * on_joint[:, None])
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
