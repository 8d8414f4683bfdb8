"""The noise floor: the difference in torque where a motion repeats.

No model that depends on the motion alone can have a smaller error. A motion never repeats exactly: where torque is steep, a few
milliradians are newton metres, which a model predicts. So what a model leaves is compared as well, and the smaller difference counts.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.repeated.same_motion import lag_of_repeat, refined_lag
from physident.dynamics.regressor import Regressor
from physident.excitation.motion.recorded import SHORTEST_REPEAT
from physident.recordings.signals import Signals

Array = NDArray[np.float64]


def noise_floor(regressor: Regressor, signals: Sequence[Signals], torque: Array, residual: Array) -> Array | None:
    """RMS (n,) [N m|N] of the filtered ``torque`` (M, n) that does not repeat with the motion, of which a model left the ``residual``
    (M, n); None where no motion repeats.

    It is computed from pairs of recordings, or two parts of one, whose positions and velocities agree for at least five
    seconds: the RMS difference of their torques or residuals over sqrt(2). Where these rows are harder than the rest, it is the same
    share of what is left of all rows.
    """
    both = np.column_stack([torque, residual])
    pairs = [_repeated(regressor, signals, both, i, k) for i in range(len(signals)) for k in range(i, len(signals))]
    found = [pair for pair in pairs if pair is not None]
    if not found:
        return None
    one, other = (np.concatenate(part) for part in zip(*found, strict=True))
    n = torque.shape[1]
    floor = np.sqrt(np.mean((one - other) ** 2, axis=0) / 2).reshape(2, n).min(axis=0)
    there = np.sqrt(np.mean((one**2 + other**2) / 2, axis=0))[n:]
    everywhere = np.sqrt((residual**2).sum(axis=0) / np.maximum(regressor.counted.sum(axis=0), 1))
    return floor * np.minimum(1.0, everywhere / np.maximum(there, 1e-300))


def _repeated(
    regressor: Regressor, signals: Sequence[Signals], values: Array, i: int, k: int
) -> tuple[Array, Array] | None:
    """Values (R, ...) of the rows of two recordings where their motions agree, None where they do not."""
    from scipy.interpolate import CubicSpline

    one, other = signals[i], signals[k]
    if (lag := lag_of_repeat(one, other)) is None:
        return None
    lag = refined_lag(one, other, lag)
    first_rows, second_rows = regressor.recording == i, regressor.recording == k
    # a row that is not counted on some joint, as where an effect remembers what was not recorded, has no torque there
    first_rows, second_rows = (rows & regressor.counted.all(axis=1) for rows in (first_rows, second_rows))
    at = regressor.time[first_rows] + lag
    known = regressor.time[second_rows]
    if len(known) < 2:
        return None
    after = np.clip(np.searchsorted(known, at), 1, len(known) - 1)
    inside = (at >= known[0]) & (at <= known[-1]) & (known[after] - known[after - 1] < 1.5 / regressor.kept_rate)
    if np.count_nonzero(inside) < SHORTEST_REPEAT * regressor.kept_rate:
        return None
    return values[first_rows][inside], np.asarray(CubicSpline(known, values[second_rows])(at[inside]))
