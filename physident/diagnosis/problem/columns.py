"""Columns of effects beside the model's, stored for the joints that they act on, and the baseline that they join."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from physident.large_arrays import empty, steps

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Columns:
    """``count`` columns of M ``rows`` in each joint; ``joints`` has the ``places`` (c,) of those that are not zero there, and their
    values (M, c).

    Seen as a sequence it is the dense columns (M, count) of each joint. ``products`` keeps what was computed of them beside
    others, by their ``token``.
    """

    count: int
    rows: int
    joints: tuple[tuple[NDArray[np.intp], Array], ...]
    products: dict[tuple[object, ...], list[Array]] = field(default_factory=dict)
    token: object = field(default_factory=object)

    @staticmethod
    def of(joints: Sequence[Array] | Columns) -> Columns:
        """Dense columns (M, k) of each joint, those that are zero left out."""
        if isinstance(joints, Columns):
            return joints
        sparse = []
        for values in joints:
            places = np.flatnonzero(values.any(axis=0))
            sparse.append((places, values if len(places) == values.shape[1] else values[:, places]))
        return Columns(joints[0].shape[1], len(joints[0]), tuple(sparse))

    def __len__(self) -> int:
        return len(self.joints)

    def __iter__(self) -> Iterator[Array]:
        return (self[joint] for joint in range(len(self)))

    def __getitem__(self, joint: int) -> Array:
        places, values = self.joints[joint]
        if len(places) == self.count:
            return values
        dense = np.zeros((self.rows, self.count))
        dense[:, places] = values
        return dense

    @property
    def size(self) -> int:
        """Bytes of the values."""
        return sum(values.nbytes for _, values in self.joints)

    def joint_by_joint(self) -> Columns:
        """The same with columns of its own for each joint."""
        active = [j for j, (places, _) in enumerate(self.joints) if len(places)]
        joints = tuple(
            (places + self.count * active.index(j), values) if j in active else (places, values)
            for j, (places, values) in enumerate(self.joints)
        )
        return Columns(self.count * len(active), self.rows, joints)

    def torque(self, values: Array) -> Array:
        """The torque (M, n) [N m|N] of ``values`` (count,)."""
        return np.column_stack([columns @ values[places] for places, columns in self.joints])


def joined_columns(parts: Sequence[Columns]) -> Columns:
    """The columns of several effects in order."""
    if len(parts) == 1:
        return parts[0]
    starts = np.cumsum([0, *(one.count for one in parts)])
    joints = []
    for each in zip(*(one.joints for one in parts), strict=True):
        places = [start + at for start, (at, _) in zip(starts, each, strict=False)]
        joints.append((np.concatenate(places).astype(np.intp), np.column_stack([values for _, values in each])))
    return Columns(int(starts[-1]), parts[0].rows, tuple(joints))


@dataclass(frozen=True, eq=False)
class Baseline:
    """Columns that are refitted with every candidate, in units of the noise: the model's, ``joints`` (M, r) in each joint's rows,
    and ``extra`` ones of accepted effects after them.

    ``prior`` (R,) is the prior precision of their values, zero where only the data decide.
    """

    joints: tuple[Array, ...]
    prior: Array
    extra: tuple[Columns, ...] = ()

    def joined(self, columns: Sequence[Array] | Columns, precision: Array | None = None) -> Baseline:
        """The baseline with more columns, (M, k) in each joint's rows, whose values have a prior ``precision`` (k,), by default none."""
        more = Columns.of(columns)
        prior = np.concatenate([self.prior, np.zeros(more.count) if precision is None else precision])
        return Baseline(self.joints, prior, (*self.extra, more))

    @property
    def starts(self) -> list[int]:
        """Where the columns of each extra effect begin among the R."""
        return [int(at) for at in np.cumsum([self.joints[0].shape[1], *(one.count for one in self.extra)])[:-1]]

    def torque(self, x: Array) -> Array:
        """The torque (M, n) [N m|N] of values x (R,)."""
        result = empty((len(self.joints[0]), len(self.joints)))
        for some in steps(len(result)):
            result[some] = self.some_torque(some, x)
        return result

    def some_torque(self, some: slice, x: Array) -> Array:
        """The torque (m, n, ...) of values x (R, ...) in some rows."""
        r = self.joints[0].shape[1]
        result = np.stack([B[some] @ x[:r] for B in self.joints], axis=1)
        for first, one in zip(self.starts, self.extra, strict=True):
            for j, (places, values) in enumerate(one.joints):
                if len(places):
                    result[:, j] += values[some] @ x[first + places]
        return result

    def rows(self, joint: int, some: slice) -> Array:
        """Some rows (m, R) of a joint."""
        parts = [self.joints[joint][some]]
        for one in self.extra:
            places, values = one.joints[joint]
            dense = np.zeros((len(parts[0]), one.count))
            dense[:, places] = values[some]
            parts.append(dense)
        return np.column_stack(parts) if self.extra else parts[0]
