"""The regressor of recordings: every effect's columns and the torque, through the same filter, joint by joint."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.effect import Column, Effect
from physident.errors import InputError
from physident.recordings.signals import Filter, Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
CHUNK = 4096  # samples evaluated before they are filtered


@dataclass(frozen=True, eq=False)
class JointRows:
    """The rows of one joint: the columns (k,) that can be non-zero in it, and their filtered values (M, k)."""

    columns: NDArray[np.intp]
    values: Array


@dataclass(frozen=True, eq=False)
class Regressor:
    """Filtered regressor and torque of M kept instants of n joints, p columns, stored without structural zeros.

    ``torque`` (M, n) [N m|N]; ``time`` (M,) [s]; ``recording`` (M,) the index of the recording a row comes from;
    ``segment`` (M,) the index of the contiguous segment. ``kept_rate`` [Hz]. ``counted`` (M, n): a row of a joint that
    does not count, because an effect there still depends on what was before the recording, is zero on both sides.
    """

    columns: tuple[Column, ...]
    joints: tuple[JointRows, ...]
    torque: Array
    time: Array
    recording: NDArray[np.intp]
    segment: NDArray[np.intp]
    kept_rate: float
    counted: NDArray[np.bool_]

    @property
    def Y(self) -> Array:
        """The dense regressor (M, n, p)."""
        Y = np.zeros((len(self.time), len(self.joints), len(self.columns)))
        for j, rows in enumerate(self.joints):
            Y[:, j, rows.columns] = rows.values
        return Y

    def predict(self, theta: Array) -> Array:
        """Filtered torque (M, n) [N m|N] of parameters (p,)."""
        return np.column_stack([rows.values @ theta[rows.columns] for rows in self.joints])

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
        R = np.zeros((p + 1, p + 1))
        stacked = np.asarray(np.linalg.qr(np.concatenate(factors), mode="r"))
        R[: len(stacked)] = stacked
        return R[:p, :p], R[:p, p], float(R[p, p] ** 2)

    def joint_sizes(self, theta: Array) -> Array:
        """Norm (n,) [N m|N] of each joint's residual at parameters (p,), from the factors: the tall rows are not read."""
        pairs = zip(self.joints, self._joint_factors, strict=True)
        return np.array([float(np.linalg.norm(R[:, :-1] @ theta[rows.columns] - R[:, -1])) for rows, R in pairs])

    def with_columns(self, other: Regressor, places: NDArray[np.intp]) -> Regressor:
        """The same rows with the columns at ``places`` taken from another regressor, whose columns are those in order."""
        joints = []
        for mine, theirs in zip(self.joints, other.joints, strict=True):
            values = mine.values.copy()
            at = {int(c): k for k, c in enumerate(mine.columns)}
            for k, c in enumerate(theirs.columns):
                values[:, at[int(places[c])]] = theirs.values[:, k]
            joints.append(JointRows(mine.columns, values))
        return replace(self, joints=tuple(joints))

    @cached_property
    def _joint_factors(self) -> list[Array]:
        """The R factor of each joint's rows with the torque as last column: weights scale it, they do not change it."""
        return [
            np.asarray(np.linalg.qr(np.column_stack([rows.values, tau]), mode="r"))
            for rows, tau in zip(self.joints, self.torque.T, strict=True)
        ]


def build_regressor(
    robot: Robot,
    effects: Sequence[Effect],
    signals: Sequence[Signals],
    filter: Filter,
    moving_only: bool = True,
    theta: Array | None = None,
    model: Model | None = None,
) -> Regressor:
    """The regressor of some recordings' signals: each column and the torque pass the same filter and decimation.

    Columns that depend on the model's own torque take it from ``theta`` (p,) of these effects, from another ``model``, or
    from the robot's nominal parameters.
    ``moving_only`` keeps the rows whose filter window lies in the moving part of its recording. Raises InputError for signals without torque, of another
    number of joints, or with nothing left.
    """
    columns = tuple(column for effect in effects for column in effect.columns(robot))
    if any(effect.needs_model for effect in effects):
        if model is None:
            model = Model.nominal(robot, effects) if theta is None else Model(robot, tuple(effects), theta)
        signals = [model.refer(s) for s in signals]
    places = _Places(robot, effects)
    pieces = [_segments(robot, s, filter, moving_only) for s in signals]
    total = sum(len(keep) for piece in pieces for _, keep in piece)
    if total == 0:
        names = ", ".join(s.source for s in signals)
        raise InputError(
            f"{names}: nothing left after the filter in the moving part; expected joints that move for seconds"
        )
    values = [np.empty((len(places.columns[j]), total)) for j in range(robot.n)]
    torque, time = np.empty((total, robot.n)), np.empty(total)
    counted = np.ones((total, robot.n), dtype=bool)
    origin, part = np.empty(total, dtype=np.intp), np.empty(total, dtype=np.intp)
    at = segment = 0
    for index, (one, piece) in enumerate(zip(signals, pieces, strict=True)):
        for samples, keep in piece:
            if not len(keep):
                continue
            own = slice(at, at + len(keep))
            torque[own], time[own] = _filtered_measurements(one, samples, keep, filter)
            origin[own], part[own] = index, segment
            places.fill(values, at, one.part(samples), keep, filter)
            counted[own] = places.counted(one.part(samples), keep, filter)
            at, segment = at + len(keep), segment + 1
    for j in range(robot.n):  # a row that does not count is zero on both sides
        values[j][:, ~counted[:, j]] = 0.0
    torque[~counted] = 0.0
    rows = tuple(JointRows(places.columns[j], values[j].T) for j in range(robot.n))
    rates = [s.rate / filter.decimation(s.rate) for s in signals]
    return Regressor(columns, rows, torque, time, origin, part, float(np.mean(rates)), counted)


class _Places:
    """Where each effect's structural non-zeros go: a joint, and a place among that joint's columns."""

    def __init__(self, robot: Robot, effects: Sequence[Effect]) -> None:
        self.robot, self.effects = robot, effects
        offset = 0
        entries: list[list[int]] = [[] for _ in range(robot.n)]
        self.targets: list[list[tuple[NDArray[np.intp], slice]]] = []
        for effect in effects:
            pattern = effect.pattern(robot)
            target = []
            for j in range(robot.n):
                mine = np.flatnonzero(pattern[:, 0] == j)
                target.append((mine, slice(len(entries[j]), len(entries[j]) + len(mine))))
                entries[j] += [int(offset + c) for c in pattern[mine, 1]]
            self.targets.append(target)
            offset += len(effect.columns(robot))
        self.columns = [np.array(columns, dtype=np.intp) for columns in entries]

    def fill(self, values: list[Array], at: int, signals: Signals, keep: NDArray[np.intp], filter: Filter) -> None:
        """Evaluate and filter the kept rows of one segment into ``values`` from ``at`` on: a chunk at a time where each
        sample stands for itself, all at once where an effect has a memory."""
        D = filter.decimation(signals.rate)
        length = len(filter.taps(signals.rate))
        rows = max(1, max(CHUNK, 4 * length) // D)
        for effect, target in zip(self.effects, self.targets, strict=True):
            if not effect.pointwise:
                whole = filter.apply(effect.values(self.robot, signals), signals.rate)[:, keep]
                self._put(values, target, whole, at)
        for start in range(0, len(keep), rows):
            chunk = slice(keep[start] * D, keep[min(start + rows, len(keep)) - 1] * D + length)
            part = signals.part(chunk)
            for effect, target in zip(self.effects, self.targets, strict=True):
                if effect.pointwise:
                    self._put(values, target, filter.apply(effect.values(self.robot, part), signals.rate), at + start)

    def _put(self, values: list[Array], target: list[tuple[NDArray[np.intp], slice]], kept: Array, at: int) -> None:
        for j, (mine, place) in enumerate(target):
            values[j][place, at : at + kept.shape[1]] = kept[mine]

    def counted(self, signals: Signals, keep: NDArray[np.intp], filter: Filter) -> NDArray[np.bool_]:
        """Rows (K, n) whose whole window is settled for every effect of that joint."""
        result = np.ones((len(keep), self.robot.n), dtype=bool)
        D, length = filter.decimation(signals.rate), len(filter.taps(signals.rate))
        for effect in self.effects:
            unsettled = effect.unsettled(self.robot, signals)
            if unsettled is not None:
                before = np.concatenate([np.zeros((1, self.robot.n)), np.cumsum(unsettled, axis=0)])
                result &= before[keep * D + length] == before[keep * D]
        return result


def _segments(
    robot: Robot, signals: Signals, filter: Filter, moving_only: bool
) -> list[tuple[slice, NDArray[np.intp]]]:
    """For each segment its samples and the filtered rows kept, which are consecutive."""
    if signals.q.shape[1] != robot.n:
        raise InputError(
            f"{signals.source}: {signals.q.shape[1]} joints, but robot {robot.name} has {robot.n}; check --robot and --columns"
        )
    if signals.torque is None:
        raise InputError(f"{signals.source}: has no torque, expected measured torques or currents with drive gains")
    start, stop = (signals.moving or (math.inf, -math.inf)) if moving_only else (-math.inf, math.inf)
    half = filter.delay(signals.rate) * filter.decimation(signals.rate) / signals.rate
    result = []
    for samples in signals.segments:
        keep = np.arange(filter.kept(samples.stop - samples.start, signals.rate))
        time = _row_times(signals, samples, keep, filter)
        # the whole window must lie in the moving part: at standstill stiction leaves the torque undetermined
        result.append((samples, keep[(time - half >= start - 1e-9) & (time + half <= stop + 1e-9)]))
    return result


def _row_times(signals: Signals, samples: slice, keep: NDArray[np.intp], filter: Filter) -> Array:
    centre = (keep + filter.delay(signals.rate)) * filter.decimation(signals.rate)
    return signals.time[samples][centre]


def _filtered_measurements(
    signals: Signals, samples: slice, keep: NDArray[np.intp], filter: Filter
) -> tuple[Array, Array]:
    assert signals.torque is not None
    torque = filter.apply(signals.torque[samples].T, signals.rate)[:, keep].T
    return torque, _row_times(signals, samples, keep, filter)
