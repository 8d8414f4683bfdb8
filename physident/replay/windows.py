"""The stretches of recordings that are simulated: measured states to start from, and the torque that follows them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.effect import Effect
from physident.errors import InputError, warn
from physident.estimation.estimate import Estimate
from physident.estimation.identify import prepare_all
from physident.recordings.recording import Recording
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
ROUNDS = 50  # of the torque of the drives from the measured one, of which two are enough for a gain
STEP = 1e-4  # of the largest torque, for slopes: no curve bends over so little
FLATTEST = 0.2  # of a measured torque over the drive's: where it is flatter, its noise counts five times, and Newton's steps are too long
UNKNOWN = 0.01  # of a joint's RMS torque: a measurement that is met no better is made by none of the drive's torques
OFTEN = 0.01  # of the time: a sample now and then moves no arm


@dataclass(frozen=True, eq=False)
class Windows:
    """W stretches of equal length, at the times ``clock`` (T,) [s] after each start.

    ``start`` (W,) [s] since the beginning of the recording ``recording`` (W,); ``q`` [rad|m], ``v`` [rad/s|m/s] (W, T, n)
    measured, and ``torque`` (W, T, n) [N m|N] measured.
    """

    clock: Array
    start: Array
    recording: NDArray[np.intp]
    q: Array
    v: Array
    torque: Array

    @property
    def step(self) -> float:
        """Time between two samples [s]."""
        return float(self.clock[1] - self.clock[0])

    def __len__(self) -> int:
        return len(self.start)


def signals_of(estimate: Estimate, recordings: Sequence[Recording]) -> list[Signals]:
    """Signals of recordings as the model's own filter sees them; currents without gains take those of the model."""
    converted = [recording.with_default_drive_gains(estimate.drive_gains) for recording in recordings]
    return prepare_all(estimate.model.robot, converted, estimate.filter)


def cut_windows(signals: Sequence[Signals], length: float, every: float) -> Windows:
    """Stretches of ``length`` [s] that start ``every`` [s], inside the moving part and a part without gaps.

    Raises InputError where no such stretch exists, and for recordings at different rates.
    """
    rates = {one.rate for one in signals}
    rate = min(rates)
    count = round(length * rate)
    starts: list[tuple[int, int]] = []
    for index, one in enumerate(signals):
        moving = one.moving
        if moving is None:
            continue
        hop = max(1, round(every * one.rate))
        samples = round(length * one.rate) + 1
        for segment in one.segments:
            for first in range(segment.start, segment.stop - samples + 1, hop):
                if moving[0] <= one.time[first] and one.time[first + samples - 1] <= moving[1]:
                    starts.append((index, first))
    if not starts or count < 2:
        raise InputError(
            f"no part of the recordings moves without a gap for {length:g} s; expected longer recordings or a shorter --horizon"
        )
    clock = np.arange(count + 1) / rate
    parts = {name: np.empty((len(starts), count + 1, signals[0].q.shape[1])) for name in ("q", "v", "torque")}
    for w, (index, first) in enumerate(starts):
        one = signals[index]
        at = one.time[first] + clock
        rows = slice(first, min(len(one.time), first + round(length * one.rate) + 2))
        for name, values in parts.items():
            channel = getattr(one, name)
            values[w] = np.column_stack([np.interp(at, one.time[rows], column) for column in channel[rows].T])
    start = np.array([signals[index].time[first] - signals[index].origin for index, first in starts])
    return Windows(clock, start, np.array([index for index, _ in starts], dtype=np.intp), **parts)


def drive_torque(model: Model, windows: Windows) -> Array:
    """Torque of the drives (W, T, n) [N m|N] behind a measured one: what the model says of the torque measurement removed.

    Solved by Newton's method, joint by joint; an effect that needs other instants, such as a delay, is removed to first order. Warns where the
    measurement does not tell the torque, as inside a sensor's dead band.
    """
    effects = [(e, theta) for e, theta in model.effect_parameters() if e.acts_on == "measurement"]
    if not effects:
        return windows.torque
    result, unknown = np.empty_like(windows.torque), np.empty(windows.torque.shape, dtype=bool)
    for w in range(len(windows)):
        measured = windows.torque[w]
        s = Signals(windows.clock, windows.q[w], windows.v[w], np.zeros_like(measured), rate=1 / windows.step)
        result[w], unknown[w] = _unmeasured(model, effects, s, measured)
    _warn_where_unknown(unknown)
    return result


def _unmeasured(
    model: Model, effects: Sequence[tuple[Effect, Array]], signals: Signals, measured: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """The torque of the drives (T, n) that a measured one shows, and where (T, n) that does not tell it."""
    step, drive = STEP * max(1.0, float(np.abs(measured).max())), measured

    def shown(torque: Array) -> Array:
        parts = (_added(model, e, theta, signals, torque if e.pointwise else measured) for e, theta in effects)
        return torque + sum(parts)

    length = np.ones_like(measured)  # of each step: shorter where the last one went too far, as at an end of a curve
    apart, slope = shown(drive) - measured, np.ones_like(measured)
    for _ in range(ROUNDS):
        slope = (shown(drive + step) - shown(drive - step)) / (2 * step)
        if np.abs(apart).max() < step**2:
            break
        tried = drive - length * apart / np.maximum(slope, FLATTEST)
        nearer = np.abs(shown(tried) - measured) < np.abs(apart)
        drive, length = np.where(nearer, tried, drive), np.where(nearer, np.minimum(2 * length, 1.0), length / 2)
        apart = shown(drive) - measured
    missed = np.abs(apart) > UNKNOWN * np.sqrt(np.mean(measured**2, axis=0))
    return drive, missed | (slope < FLATTEST)


def _warn_where_unknown(unknown: NDArray[np.bool_]) -> None:
    share = unknown.mean(axis=(0, 1))
    if joints := [f"joint {j + 1} for {100 * share[j]:.0f} % of the time" for j in np.flatnonzero(share > OFTEN)]:
        warn(
            "the measured torque does not tell the torque of the drive, because the model's measurement effects make nearly the same of"
            f" several torques: {', '.join(joints)}; expected a measurement that grows with the torque"
        )


def _added(model: Model, effect: Effect, theta: Array, signals: Signals, drive: Array) -> Array:
    return effect.regressor(model.robot, replace(signals, motor=drive)) @ theta
