"""The stretches of recordings that are simulated: measured states to start from, and the torque that follows them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.effect import Effect
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.estimation.identify import prepare_all
from physident.recordings.recording import Recording
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
ROUNDS = 30  # of the torque of the drives from the measured one: each is closer by the size of the wrong gain


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

    Solved by repetition; an effect that needs other instants, such as a delay, is removed to first order.
    """
    effects = [(e, theta) for e, theta in model.effect_parameters() if e.acts_on == "measurement"]
    if not effects:
        return windows.torque
    result = np.empty_like(windows.torque)
    for w in range(len(windows)):
        measured = windows.torque[w]
        s = Signals(windows.clock, windows.q[w], windows.v[w], np.zeros_like(measured), rate=1 / windows.step)
        drive = measured
        for _ in range(ROUNDS):
            before = drive
            drive = measured - sum(
                _added(model, e, theta, s, drive if e.pointwise else measured) for e, theta in effects
            )
            if np.abs(drive - before).max() < 1e-9 * max(1.0, np.abs(measured).max()):
                break
        result[w] = drive
    return result


def _added(model: Model, effect: Effect, theta: Array, signals: Signals, drive: Array) -> Array:
    return effect.regressor(model.robot, replace(signals, motor=drive)) @ theta
