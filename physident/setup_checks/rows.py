"""Filtered rows of recordings beside the torques that the description expects: what all checks of the effort look at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.inverse_dynamics import gravity_torque, inverse_dynamics
from physident.effects.hysteresis import bristle
from physident.errors import InputError
from physident.recordings.preparation import differentiate
from physident.recordings.recording import Recording
from physident.recordings.signals import MOVING_SPEED, Filter, Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
CUTOFF = 5.0  # Hz: gravity, inertia and friction of arms lie below
BLOCKS = 10  # of each set of recordings: the fewest for which Student's t is near the normal distribution
STRONG = 0.3  # of the largest inertia and gravity torque of any joint: weaker ones depend on details of the description
BUILDS_UP = (1e-3, 3e-3, 1e-2)  # rad: over which the friction of gears builds up after a reversal
MIN_ROWS = 60  # of all recordings together: six a block


@dataclass(frozen=True, eq=False, kw_only=True)
class Rows:
    """M rows in motion of n joints, from positions and efforts only: the measured velocity may be wrong.

    ``q``, ``v``, ``a`` and ``torque`` (M, n) in rad, N m and seconds, filtered and decimated; ``sign`` (M, n) is the filtered
    direction of motion. ``bristles`` (M, n, 3) are friction of one that builds up over each of ``BUILDS_UP``. ``recording``, ``segment`` and ``block``
    (M,) number the recordings, their contiguous parts and the blocks of the jackknife; ``time`` (M,) [s]. ``trusted``: all efforts are torques, or currents with drive gains.
    """

    robot: Robot
    q: Array
    v: Array
    a: Array
    torque: Array
    sign: Array
    bristles: Array
    time: Array
    recording: NDArray[np.intp]
    segment: NDArray[np.intp]
    block: NDArray[np.intp]
    trusted: bool

    @cached_property
    def gravity(self) -> Array:
        """The description's gravity torque (M, n) [N m]."""
        return gravity_torque(self.robot, self.robot.nominal, self.q, np.array(self.robot.gravity))

    @cached_property
    def inertial(self) -> Array:
        """The description's torque (M, n) [N m] of acceleration and velocity."""
        whole = inverse_dynamics(self.robot, self.robot.nominal, self.q, self.v, self.a)
        return whole - self.gravity

    @cached_property
    def columns(self) -> Array:
        """What explains the torque of each joint, (n, M, 5): gravity, inertia, rotor, viscous and Coulomb friction, each
        without its mean over a recording, of which a constant offset is no evidence."""
        parts = (self.gravity, self.inertial, self.a, self.v, self.sign)
        return self.centred(np.stack(parts, axis=-1)).transpose(1, 0, 2)

    def strong(self) -> NDArray[np.bool_]:
        """The joints (n,) on which the description's inertia and gravity torque is large."""
        size = self.columns[:, :, :2].sum(axis=2).std(axis=1)
        return size >= STRONG * size.max()

    def moving(self) -> NDArray[np.bool_]:
        """The joints (n,) that move: one that is held shows its friction's doubt, and neither friction nor inertia of its own."""
        return self.v.std(axis=0) > MOVING_SPEED * self.robot.radian

    def centred(self, values: Array) -> Array:
        """Values (M, ...) without their mean over each recording; a short part of one may hold friction of one direction alone."""
        result = np.array(values, dtype=float)
        for one in np.unique(self.recording):
            rows = self.recording == one
            result[rows] -= result[rows].mean(axis=0)
        return result

    def relabelled(self, order: NDArray[np.intp]) -> Rows:
        """The rows with channel order[k] taken for joint k, positions and efforts alike."""
        return replace(
            self, q=self.q[:, order], v=self.v[:, order], a=self.a[:, order], torque=self.torque[:, order], sign=self.sign[:, order],
            bristles=self.bristles[:, order],
        )  # fmt: skip

    def counted(self, sign: Array) -> Rows:
        """The rows with positions that count in the direction of ``sign`` (n,) of 1 or -1, and efforts as they are."""
        turned = {name: sign * getattr(self, name) for name in ("q", "v", "a", "sign")}
        return replace(self, bristles=sign[:, None] * self.bristles, **turned)

    def placed(self, joint: int, direction: float, zero: float) -> Rows:
        """The rows with a joint (from 0) that turns in another ``direction`` (1 or -1) and stands ``zero`` [rad] further on."""
        factor = np.ones(self.robot.n)
        factor[joint] = direction
        turned = self.counted(factor)
        turned.q[:, joint] += zero
        return replace(turned, torque=factor * self.torque)

    def scaled(self, factor: float) -> Rows:
        """The rows with positions in another unit."""
        return replace(self, q=self.q * factor, v=self.v * factor, a=self.a * factor)


def rows_of(robot: Robot, recordings: Sequence[Recording]) -> Rows | None:
    """Rows of recordings with the robot's number of joints; None where too little of them is in motion."""
    parts = [(k, part) for k, recording in enumerate(recordings) for part in _filtered(recording, robot)]
    numbers, kept = [k for k, part in parts if len(part.time) > 2], [part for _, part in parts if len(part.time) > 2]
    lengths = [len(part.time) for part in kept]
    if sum(lengths) < MIN_ROWS:
        return None
    segment = np.repeat(np.arange(len(kept)), lengths)
    names = ("q", "v", "a", "torque", "sign", "bristles", "time")
    joined = {name: np.concatenate([getattr(part, name) for part in kept]) for name in names}
    count = len(segment)
    return Rows(
        robot=robot,
        **joined,
        recording=np.repeat(numbers, lengths),
        segment=segment,
        block=np.arange(count) * BLOCKS // count,
        trusted=all(r.effort_kind == "torque" or r.drive_gains is not None for r in recordings),
    )


def with_unit_gains(recording: Recording) -> Recording:
    """The recording itself, or with drive gains of one where it has currents without gains."""
    if recording.effort_kind == "torque" or recording.drive_gains is not None:
        return recording
    return recording.with_drive_gains([1.0] * recording.n)


def filter_for(recording: Recording) -> Filter:
    """The filter of all checks, within what the clock of a recording allows."""
    rate = 1 / float(np.median(np.diff(recording.time)))
    return Filter(cutoff=min(CUTOFF, 0.2 * rate))


@dataclass(frozen=True, eq=False)
class _Part:
    """The rows of one contiguous part of a recording that are in motion."""

    time: Array
    q: Array
    v: Array
    a: Array
    torque: Array
    sign: Array
    bristles: Array


def _filtered(recording: Recording, robot: Robot) -> list[_Part]:
    """The contiguous parts of a recording, filtered; none where no part is as long as the filter."""
    filter = filter_for(recording)
    try:
        signals = differentiate(with_unit_gains(replace(recording, dq=None)), filter)
    except InputError:
        return []  # nothing to judge, and fitting will refuse it
    every, delay = filter.decimation(signals.rate), filter.delay(signals.rate)

    def low(values: Array) -> Array:
        return filter.apply(np.ascontiguousarray(values.T), signals.rate).T

    result = []
    for part in map(signals.part, signals.segments):
        assert part.torque is not None
        channels = (part.q, part.v, part.a, part.torque, np.tanh(part.v / MOVING_SPEED))
        q, v, a, torque, sign = map(low, channels)
        bristles = np.stack([low(one) for one in _bristles(part, robot)], axis=-1)
        time = part.time[delay * every :: every][: len(v)]
        moving = (np.abs(v) > MOVING_SPEED / 2).any(axis=1)
        result.append(_Part(*(x[moving] for x in (time, q, v, a, torque, sign, bristles))))
    return result


def _bristles(signals: Signals, robot: Robot) -> list[Array]:
    """Friction (N, n) of one that builds up over each distance, on a slide in proportion."""
    radian = np.array([joint.radian for joint in robot.joints])
    return [bristle(signals.v.T, far * radian, signals.rate).T / (far * radian) for far in BUILDS_UP]
