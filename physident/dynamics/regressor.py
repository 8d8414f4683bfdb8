"""The regressor of recordings: every effect's columns and the torque, through the same filter, joint by joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.column_structure import ColumnStructure, kept_rows
from physident.dynamics.model import Model, turning_speeds
from physident.effects.effect import Column, Effect
from physident.errors import InputError
from physident.large_arrays import BLOCK, blocks, copied, empty, is_shared, triangle
from physident.processes import each
from physident.recordings.signals import Filter, Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class JointRows:
    """The rows of one joint: ``columns`` (k,) that can be non-zero in them, their filtered values ``plain`` (M, k), and the
    ``weight`` (M,) of each row, None for one."""

    columns: NDArray[np.intp]
    plain: Array
    weight: Array | None = None

    @property
    def values(self) -> Array:
        """The weighted values (M, k)."""
        return self.some(slice(None))

    def some(self, rows: slice | NDArray[np.intp]) -> Array:
        """The weighted values (K, k) of some rows."""
        return self.plain[rows] if self.weight is None else self.plain[rows] * self.weight[rows, None]

    def weighted(self, weight: Array) -> JointRows:
        """The same rows, each multiplied by ``weight`` (M,); the values themselves are not copied."""
        return replace(self, weight=weight if self.weight is None else self.weight * weight)


@dataclass(frozen=True, eq=False, repr=False)
class Regressor:
    """Filtered regressor and torque of M kept instants of n joints, p columns, stored without structural zeros.

    ``torque`` (M, n) [N m|N]; ``time`` (M,) [s]; ``recording`` (M,) index of the recording of each row; ``segment`` (M,)
    index of its contiguous segment; ``kept_rate`` [Hz] of the rows. Where ``counted`` (M, n) is False, an effect on that
    joint still depends on the motion before the recording: such a row is zero on both sides. ``prior`` (p,) says for how many rows
    [(N m)^2 a unit squared] of its joint, in which the parameter alone is seen and is zero, a prior of each parameter counts; None
    where there is none.
    """

    columns: tuple[Column, ...]
    joints: tuple[JointRows, ...]
    torque: Array
    time: Array
    recording: NDArray[np.intp]
    segment: NDArray[np.intp]
    kept_rate: float
    counted: NDArray[np.bool_]
    prior: Array | None = None

    def __repr__(self) -> str:
        effects = ", ".join(dict.fromkeys(column.effect for column in self.columns))
        recordings, rows = len(np.unique(self.recording)), len(self.time)
        return (
            f"Regressor: {rows} rows at {self.kept_rate:g} Hz of {len(self.joints)} joints, {len(self.columns)} columns,"
            f" {recordings} recording{'s' * (recordings != 1)}\neffects: {effects}"
        )

    @property
    def Y(self) -> Array:
        """The dense regressor (M, n, p)."""
        return self.dense(slice(0, len(self.time)))

    def dense(self, rows: slice | NDArray[np.intp]) -> Array:
        """Some rows of the dense regressor (K, n, p)."""
        Y = np.zeros((len(self.time[rows]), len(self.joints), len(self.columns)))
        for j, joint in enumerate(self.joints):
            Y[:, j, joint.columns] = joint.some(rows)
        return Y

    def predict(self, theta: Array) -> Array:
        """Filtered torque (M, n) [N m|N] of parameters (p,)."""
        torque = empty((len(self.time), len(self.joints)))
        for some in blocks(len(torque)):
            for j, rows in enumerate(self.joints):
                torque[some, j] = rows.some(some) @ theta[rows.columns]
        return torque

    def residual(self, theta: Array) -> Array:
        """What parameters (p,) leave of the filtered torque (M, n) [N m|N]."""
        left = self.predict(theta)
        for some in blocks(len(left)):
            left[some] = self.torque[some] - left[some]
        return left

    def compressed(self, weights: Array) -> tuple[Array, Array, float]:
        """R (p, p), z (p,) and rest with |W (Y theta - torque)|^2 = |R theta - z|^2 + rest for every theta.

        ``weights`` (n,) multiply the rows of each joint [1/(N m)]. Each joint's rows are factored once.
        """
        p = len(self.columns)
        factors = [np.zeros((0, p + 1))]
        for weight, rows, R in zip(weights, self.joints, self._joint_factors, strict=True):
            factor = np.zeros((len(R), p + 1))
            factor[:, rows.columns], factor[:, p] = weight * R[:, :-1], weight * R[:, -1]
            factors.append(factor)
        factors.append(self.prior_rows(weights))
        R = np.zeros((p + 1, p + 1))
        stacked = np.asarray(np.linalg.qr(np.concatenate(factors), mode="r"))
        R[: len(stacked)] = stacked
        return R[:p, :p], R[:p, p], float(R[p, p] ** 2)

    def prior_rows(self, weights: Array) -> Array:
        """The rows (k, p + 1) that the prior adds, torque last, in units of ``weights`` (n,) [1/(N m)]."""
        p = len(self.columns)
        held = np.flatnonzero(self.prior) if self.prior is not None else np.zeros(0, dtype=np.intp)
        rows = np.zeros((len(held), p + 1))
        if self.prior is not None and len(held):
            joints = np.array([self.columns[c].joint - 1 for c in held])
            rows[np.arange(len(held)), held] = np.sqrt(self.prior[held]) * weights[joints]
        return rows

    def in_memory(self) -> Regressor:
        """The same with its weighted values computed once, for what asks for them again and again."""
        return replace(self, joints=tuple(JointRows(rows.columns, rows.values) for rows in self.joints))

    def joint_sizes(self, theta: Array) -> Array:
        """Norm (n,) [N m|N] of each joint's residual at parameters (p,), from the QR factors alone."""
        pairs = zip(self.joints, self._joint_factors, strict=True)
        return np.array([float(np.linalg.norm(R[:, :-1] @ theta[rows.columns] - R[:, -1])) for rows, R in pairs])

    def with_columns(self, other: Regressor, places: NDArray[np.intp]) -> Regressor:
        """The same rows with the columns at ``places`` taken from another regressor, whose columns are those in order; zero in rows that
        are not counted here, though they may be there."""
        joints = []
        for rows, new_rows, counted in zip(self.joints, other.joints, self.counted.T, strict=True):
            values, fresh = copied(rows.values), new_rows.values
            position = {int(c): k for k, c in enumerate(rows.columns)}
            for k, c in enumerate(new_rows.columns):
                values[:, position[int(places[c])]] = fresh[:, k] * counted
            joints.append(JointRows(rows.columns, values))
        return replace(self, joints=tuple(joints))

    @cached_property
    def _joint_factors(self) -> list[Array]:
        """The R factor of each joint's rows with the torque as last column: weights scale it, they do not change it."""
        return [
            triangle(np.column_stack([rows.some(some), tau[some]]) for some in blocks(len(tau)))
            for rows, tau in zip(self.joints, self.torque.T, strict=True)
        ]


def with_transition(robot: Robot, effects: Sequence[Effect], signals: Signals) -> Signals:
    """The signals with the speeds over which the sign of dry friction turns, where one of the effects states them."""
    stated = turning_speeds(robot, effects)
    return signals if stated is None else replace(signals, transition=stated)


def build_regressor(
    robot: Robot,
    effects: Sequence[Effect],
    signals: Sequence[Signals],
    filter: Filter,
    moving_only: bool = True,
    theta: Array | None = None,
    model: Model | None = None,
) -> Regressor:
    """The regressor of some recordings' signals: every column and the torque pass the same filter and decimation.

    Columns that depend on the model's own torque use the parameters ``theta`` (p,) of these effects, another ``model``,
    the model that the signals were referred to before, or the robot's nominal parameters. ``moving_only`` keeps the rows whose filter window lies in the moving part of the
    recording. Raises InputError for signals without torque, of another number of joints, or without any row left.
    """
    columns = tuple(column for effect in effects for column in effect.columns(robot))
    known = theta is None and model is None and all(one.motor is not None for one in signals)
    if any(effect.needs_model for effect in effects) and not known:
        if model is None:
            model = Model.nominal(robot, effects) if theta is None else Model(robot, tuple(effects), theta)
        signals = [model.refer(s) for s in signals]
    signals = [with_transition(robot, effects, s) for s in signals]
    structure = ColumnStructure.of(robot, effects)
    pieces = [kept_rows(robot, s, filter, moving_only) for s in signals]
    total = sum(len(piece.rows) for recording in pieces for piece in recording)
    if total == 0:
        names = ", ".join(s.source for s in signals)
        raise InputError(
            f"{names}: no rows are left after the filter in the moving part; expected joints that move for seconds"
        )
    counts = [len(joint_columns) for joint_columns in structure.columns]
    together = empty((sum(counts), total), shared=any(is_shared(one.v) for one in signals))
    values = np.split(together, np.cumsum(counts)[:-1])
    torque, time = empty((total, robot.n)), empty(total)
    counted = np.ones((total, robot.n), dtype=bool)
    recording, segment = empty(total, np.intp), empty(total, np.intp)
    first, filled = 0, [(index, piece) for index, some in enumerate(pieces) for piece in some if len(piece.rows)]
    starts: list[int] = []
    for number, (index, piece) in enumerate(filled):
        part, rows = signals[index].part(piece.samples), slice(first, first + len(piece.rows))
        assert part.torque is not None
        torque[rows] = filter.apply(part.torque.T, part.rate)[:, piece.rows].T
        time[rows] = piece.times
        recording[rows], segment[rows] = index, number
        counted[rows] = structure.counted(part, piece.rows, filter)
        starts.append(first)
        first = rows.stop

    def fill(number: int) -> None:
        index, piece = filled[number]
        structure.fill(values, starts[number], signals[index].part(piece.samples), piece.rows, filter)

    # of a long piece, the processes fill parts in turn
    are_short = all(len(piece.rows) <= BLOCK for _, piece in filled)
    each(fill, range(len(filled)), shared=are_short and is_shared(together))
    if not counted.all():  # a row that is not counted is zero on both sides
        for j in range(robot.n):
            values[j][:, ~counted[:, j]] = 0.0
        torque[~counted] = 0.0
    return Regressor(
        columns=columns,
        joints=tuple(JointRows(joint_columns, v.T) for joint_columns, v in zip(structure.columns, values, strict=True)),
        torque=torque,
        time=time,
        recording=recording,
        segment=segment,
        kept_rate=float(np.mean([s.rate / filter.decimation(s.rate) for s in signals])),
        counted=counted,
    )
