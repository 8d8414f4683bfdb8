"""The noise floor: the difference in torque where a motion repeats.

No model that depends on the motion alone can have a smaller error.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.repeated.same_motion import lag_of_repeat
from physident.dynamics.regressor import Regressor
from physident.excitation.motion.recorded import SHORTEST_REPEAT
from physident.recordings.signals import Signals

Array = NDArray[np.float64]


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
    if abs(one.rate / other.rate - 1) > 1e-3 or (lag := lag_of_repeat(one, other)) is None:
        return None
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
    return torque[first_rows][inside] - CubicSpline(known, torque[second_rows])(at[inside])
