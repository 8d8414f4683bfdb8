"""Where the structural non-zeros of effects go in a regressor, and how they are filled with filtered values."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.effects.effect import Effect
from physident.errors import InputError
from physident.large_arrays import BLOCK, is_shared, release
from physident.processes import each
from physident.recordings.signals import Filter, Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
CHUNK = 4096  # samples evaluated before they are filtered
TOGETHER = 48  # columns filtered at once: a product of large matrices is several times as fast as many of small ones


@dataclass(frozen=True, eq=False)
class Target:
    """Non-zeros of an effect on one ``joint`` (from 0): their indices ``entries`` among ``Effect.values``, and their ``places`` among the
    joint's columns."""

    joint: int
    entries: NDArray[np.intp]
    places: slice


@dataclass(frozen=True, eq=False)
class ColumnStructure:
    """For each joint the ``columns`` that can be non-zero in its rows; for each of the ``effects`` that are evaluated its ``targets``."""

    robot: Robot
    effects: Sequence[Effect]
    columns: list[NDArray[np.intp]]
    targets: list[list[Target]]

    @staticmethod
    def of(robot: Robot, effects: Sequence[Effect]) -> ColumnStructure:
        """The structure of some effects' columns, one effect after another."""
        offset = 0
        columns: list[list[int]] = [[] for _ in range(robot.n)]
        targets: list[list[Target]] = []
        for effect in effects:
            pattern = effect.pattern(robot)
            targets.append([])
            for j, joint_columns in enumerate(columns):
                entries = np.flatnonzero(pattern[:, 0] == j)
                targets[-1].append(Target(j, entries, slice(len(joint_columns), len(joint_columns) + len(entries))))
                joint_columns += [int(offset + c) for c in pattern[entries, 1]]
            offset += len(effect.columns(robot))
        evaluated = [one for members in _alike(effects) for one in _as_one(robot, effects, targets, members)]
        return ColumnStructure(
            robot=robot,
            effects=[effect for effect, _ in evaluated],
            columns=[np.array(c, dtype=np.intp) for c in columns],
            targets=[own for _, own in evaluated],
        )

    def fill(self, values: list[Array], first: int, signals: Signals, rows: NDArray[np.intp], filter: Filter) -> None:
        """Evaluates and filters the kept rows of one segment into ``values``, from row ``first`` on.

        Pointwise effects are evaluated in chunks, effects with a memory in blocks with the samples around that these depend on.
        """
        D = filter.decimation(signals.rate)
        length = len(filter.taps(signals.rate))
        chunk_rows = max(1, max(CHUNK, 4 * length) // D)
        for effect, targets in zip(self.effects, self.targets, strict=True):
            if not effect.pointwise:
                self._fill_with_memory(effect, targets, values, first, signals, rows, filter)

        def fill_chunk(start: int) -> None:
            samples = slice(rows[start] * D, rows[min(start + chunk_rows, len(rows)) - 1] * D + length)
            part, waiting = signals.part(samples), []
            for effect, targets in zip(self.effects, self.targets, strict=True):
                if effect.pointwise:
                    waiting.append((targets, effect.values(self.robot, part)))
                if sum(len(one) for _, one in waiting) >= TOGETHER:
                    _filter_and_put(values, waiting, signals.rate, first + start, filter)
                    waiting = []
            _filter_and_put(values, waiting, signals.rate, first + start, filter)
            if len(rows) > BLOCK:
                release()

        each(fill_chunk, range(0, len(rows), chunk_rows), shared=is_shared(values[0]))

    def _fill_with_memory(
        self, effect: Effect, targets: list[Target], values: list[Array], first: int, signals: Signals, rows: NDArray[np.intp], filter: Filter
    ) -> None:  # fmt: skip
        """The same for one effect whose values depend on other samples than their own."""
        D, length = filter.decimation(signals.rate), len(filter.taps(signals.rate))
        block_rows = max(1, BLOCK // D)

        def fill_block(start: int) -> None:
            samples = slice(rows[start] * D, rows[min(start + block_rows, len(rows)) - 1] * D + length)
            around = effect.around(self.robot, signals, samples)
            part = effect.values(self.robot, signals.part(around))
            own = part[..., samples.start - around.start : samples.stop - around.start]
            _put(values, targets, filter.apply(own, signals.rate), first + start)
            if len(rows) > block_rows:
                release()

        each(fill_block, range(0, len(rows), block_rows), shared=is_shared(values[0]))

    def counted(self, signals: Signals, rows: NDArray[np.intp], filter: Filter) -> NDArray[np.bool_]:
        """Rows (K, n) in whose whole filter window every effect on that joint is settled."""
        result = np.ones((len(rows), self.robot.n), dtype=bool)
        D = filter.decimation(signals.rate)
        for effect in self.effects:
            unsettled = effect.unsettled(self.robot, signals)
            if unsettled is not None:
                result &= rows[:, None] * D >= unsettled
        return result


def _alike(effects: Sequence[Effect]) -> Iterable[list[int]]:
    """Which effects (indices) can be evaluated as one: those of one joint each that differ in their joint alone."""
    groups: dict[object, list[int]] = {}
    for i, effect in enumerate(effects):
        groups.setdefault(replace(effect, joints=None) if _is_single(effect) else i, []).append(i)
    return groups.values()


def _is_single(effect: Effect) -> bool:
    """Whether an effect is that of one joint, whose settings are those of any other joint, too."""
    if effect.joints is None or len(effect.joints) != 1:
        return False
    shapes = {shape.field for shape in effect.shape_parameters} | {"joints"}
    return not any(isinstance(value, tuple) for name, value in vars(effect).items() if name not in shapes)


def _as_one(
    robot: Robot, effects: Sequence[Effect], targets: Sequence[list[Target]], members: Sequence[int]
) -> list[tuple[Effect, list[Target]]]:
    """The effect to evaluate in the place of some that differ in their joint alone, and where its values go: what they have in common,
    such as inverse dynamics and its derivatives, is then computed once. Those of which one of several joints is not the sum stay as they are."""
    apart = [(effects[i], targets[i]) for i in members]
    if len(members) == 1:
        return apart
    one = replace(effects[members[0]], joints=tuple(joint for i in members for joint in effects[i].joints or ()))
    pattern, each = one.pattern(robot), len(effects[members[0]].columns(robot))
    result = []
    for k, i in enumerate(members):
        own = np.flatnonzero(pattern[:, 1] // each == k)
        if not np.array_equal(pattern[own] - (0, k * each), effects[i].pattern(robot)):
            return apart
        result += [replace(target, entries=own[target.entries]) for target in targets[i]]
    return [(one, result)]


def _filter_and_put(
    values: list[Array], waiting: Sequence[tuple[list[Target], Array]], rate: float, first: int, filter: Filter
) -> None:
    """Filters the columns of several effects at once, and puts them into ``values`` from row ``first`` on."""
    if not waiting:
        return
    filtered = filter.apply(np.concatenate([one for _, one in waiting]), rate)
    start = 0
    for targets, one in waiting:
        _put(values, targets, filtered[start : start + len(one)], first)
        start += len(one)


def _put(values: list[Array], targets: list[Target], filtered: Array, first: int) -> None:
    for target in targets:
        values[target.joint][target.places, first : first + filtered.shape[1]] = filtered[target.entries]


@dataclass(frozen=True, eq=False)
class KeptRows:
    """The filtered rows of one segment that are kept: its ``samples``, the numbers of the ``rows`` (K,), which are
    consecutive, and their ``times`` (K,) [s]."""

    samples: slice
    rows: NDArray[np.intp]
    times: Array


def kept_rows(robot: Robot, signals: Signals, filter: Filter, moving_only: bool) -> list[KeptRows]:
    """The kept rows of each segment; raises InputError for another number of joints and for signals without torque."""
    if signals.q.shape[1] != robot.n:
        raise InputError(
            f"{signals.source}: {signals.q.shape[1]} joints, but robot {robot.name} has {robot.n}; check --robot, --joints and --columns"
        )
    if signals.torque is None:
        raise InputError(f"{signals.source}: has no torque, expected measured torques or currents with drive gains")
    start, stop = (signals.moving or (math.inf, -math.inf)) if moving_only else (-math.inf, math.inf)
    half_window = filter.delay(signals.rate) * filter.decimation(signals.rate) / signals.rate
    result = []
    for samples in signals.segments:
        rows = np.arange(filter.kept(samples.stop - samples.start, signals.rate))
        times = signals.time[samples][(rows + filter.delay(signals.rate)) * filter.decimation(signals.rate)]
        # the whole window must lie in the moving part: at standstill stiction leaves the torque undetermined
        inside = (times - half_window >= start - 1e-9) & (times + half_window <= stop + 1e-9)
        result.append(KeptRows(samples, rows[inside], times[inside]))
    return result
