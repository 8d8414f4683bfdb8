"""The noise floor: the difference in torque where a motion repeats.

No model that depends on the motion alone can have a smaller error.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import Regressor
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
MAX_DIFFERENCE = 0.05  # of RMS velocity, and of RMS position about its mean: smaller differences are the controller's
SHORTEST = 5.0  # s that must repeat: a slow stretch alone can be like another


def noise_floor(regressor: Regressor, signals: Sequence[Signals], torque: Array) -> Array | None:
    """RMS (n,) [N m|N] of the filtered ``torque`` (M, n) that does not repeat with the motion; None where no motion repeats.

    It is computed from pairs of recordings, or two parts of one, whose positions and velocities agree for at least five
    seconds: the RMS difference of their torques over sqrt(2).
    """
    total, rows = np.zeros(torque.shape[1]), 0
    for i in range(len(signals)):
        for k in range(i, len(signals)):
            difference = _difference(regressor, signals, torque, i, k)
            if difference is not None:
                total += (difference**2).sum(axis=0) / 2
                rows += len(difference)
    return np.sqrt(total / rows) if rows else None


def _difference(regressor: Regressor, signals: Sequence[Signals], torque: Array, i: int, k: int) -> Array | None:
    """Difference (R, n) of the torques of two recordings where their motions agree, None where they do not."""
    from scipy.interpolate import CubicSpline

    one, other = signals[i], signals[k]
    if abs(one.rate / other.rate - 1) > 1e-3 or len(one.starts) + len(other.starts) > 2:  # gaps: no common clock
        return None
    shift = _shift(one, other, i == k)
    if shift is None:
        return None
    first_rows, second_rows = regressor.recording == i, regressor.recording == k
    lag = other.time[max(0, shift)] - one.time[max(0, -shift)]
    at = regressor.time[first_rows] + lag
    inside = (at >= regressor.time[second_rows][0]) & (at <= regressor.time[second_rows][-1])
    if np.count_nonzero(inside) < SHORTEST * regressor.kept_rate:
        return None
    return torque[first_rows][inside] - CubicSpline(regressor.time[second_rows], torque[second_rows])(at[inside])


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
    allowed = last - first >= SHORTEST * one.rate
    if same:
        allowed &= shifts >= 1.0 * one.rate
    moving = np.minimum(size_a, size_b) > 0.1 * min(power[0][-1], power[1][-1])
    unlike = np.where(allowed & moving, size_a + size_b - 2 * cross, np.inf) / np.maximum(size_a, 1e-300)
    best = int(np.argmin(unlike))
    if not unlike[best] <= MAX_DIFFERENCE**2:
        return None
    qa, qb = one.q[first[best] : last[best]], other.q[first[best] + shifts[best] : last[best] + shifts[best]]
    spread = np.linalg.norm(qa - qa.mean(axis=0))
    return int(shifts[best]) if np.linalg.norm(qa - qb) <= MAX_DIFFERENCE * spread else None
