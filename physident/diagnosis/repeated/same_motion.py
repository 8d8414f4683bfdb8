"""Whether two recordings are of one motion, and how far apart their clocks are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.excitation.motion.recorded import SHORTEST_REPEAT
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
MAX_DIFFERENCE = 0.05  # of RMS velocity, and of RMS position about its mean: smaller differences are the controller's
ROUNDS = 3  # of the lag between two clocks; the second already changes it by less than a microsecond


def lag_of_repeat(one: Signals, other: Signals) -> float | None:
    """By how much [s] the second recording's clock is ahead where both move alike for five seconds or more; None where they never do.

    A recording beside itself is compared with its own later parts, a second or more apart.
    """
    if len(one.starts) + len(other.starts) > 2:  # gaps: no common clock
        return None
    alike = other if abs(one.rate / other.rate - 1) <= 1e-3 else _at_rate(other, one.rate)
    shift = _shift(one, alike, one is other)
    if shift is None:
        return None
    return float(alike.time[max(0, shift)] - one.time[max(0, -shift)])


def refined_lag(one: Signals, other: Signals, lag: float) -> float:
    """A lag [s] between two recordings of one motion, between samples: by least squares of their positions."""
    from scipy.interpolate import CubicSpline

    path = CubicSpline(other.time, other.q)
    speed = path.derivative()
    for _ in range(ROUNDS):
        at = one.time + lag
        inside = (at >= other.time[0]) & (at <= other.time[-1])
        v = speed(at[inside])
        lag += float(np.sum((one.q[inside] - path(at[inside])) * v) / max(np.sum(v * v), 1e-300))
    return lag


def _at_rate(one: Signals, rate: float) -> Signals:
    """Time, position and velocity of a recording at another rate [Hz]."""
    from scipy.interpolate import CubicSpline

    time = one.time[0] + np.arange(int((one.time[-1] - one.time[0]) * rate + 1e-6) + 1) / rate
    q, v = (np.asarray(CubicSpline(one.time, values)(time)) for values in (one.q, one.v))
    return replace(Signals.of_states(q, v, np.zeros_like(v)), time=time, rate=rate)


def _shift(one: Signals, other: Signals, same: bool) -> int | None:
    """By how many samples the second recording is ahead where both move alike; None where they never do."""
    from scipy.signal import fftconvolve

    a, b = one.v, other.v
    shifts = np.arange(-(len(a) - 1), len(b))
    cross = sum(fftconvolve(b[:, j], a[::-1, j]) for j in range(a.shape[1]))
    power = (
        np.concatenate([[0.0], np.cumsum((a**2).sum(axis=1))]),
        np.concatenate([[0.0], np.cumsum((b**2).sum(axis=1))]),
    )
    first, last = np.maximum(0, -shifts), np.minimum(len(a), len(b) - shifts)
    size_a, size_b = power[0][last] - power[0][first], power[1][last + shifts] - power[1][first + shifts]
    allowed = last - first >= SHORTEST_REPEAT * one.rate
    if same:
        allowed &= shifts >= 1.0 * one.rate
    moving = np.minimum(size_a, size_b) > 0.1 * min(power[0][-1], power[1][-1])
    unlike = np.where(allowed & moving, size_a + size_b - 2 * cross, np.inf) / np.maximum(size_a, 1e-300)
    # a periodic motion is like itself a period later, too: where most of both overlaps, most can be compared
    lowest = _lowest_of_runs(unlike, MAX_DIFFERENCE**2)
    for best in sorted(lowest, key=lambda k: -(last[k] - first[k])):
        qa, qb = one.q[first[best] : last[best]], other.q[first[best] + shifts[best] : last[best] + shifts[best]]
        spread = np.linalg.norm(qa - qa.mean(axis=0))
        if np.linalg.norm(qa - qb) <= MAX_DIFFERENCE * spread:
            return int(shifts[best])
    return None


def _lowest_of_runs(values: Array, limit: float) -> list[int]:
    """The place of the lowest of each run of values (N,) up to a limit."""
    low = np.flatnonzero(values <= limit)
    runs = np.split(low, np.flatnonzero(np.diff(low) > 1) + 1) if len(low) else []
    return [int(run[np.argmin(values[run])]) for run in runs]
