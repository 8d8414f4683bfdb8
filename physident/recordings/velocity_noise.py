"""The noise of a measured velocity, from what a local polynomial fit does not explain."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physident.recordings.signals import Signals

Array = NDArray[np.float64]
WINDOW, ORDER = 9, 4  # samples and polynomial order of the local fit: motion is smoother than that over nine samples
GAUSSIAN = 1.4826  # standard deviation of a Gaussian over the median of its absolute value


def velocity_noise(signals: Signals) -> Array:
    """Standard deviation (n,) [rad/s|m/s] of the white noise of measured velocities; zero for fewer than nine samples."""
    from scipy.signal import savgol_coeffs, savgol_filter

    if len(signals.v) < WINDOW:
        return np.zeros(signals.v.shape[1])
    residual = signals.v - np.asarray(savgol_filter(signals.v, WINDOW, ORDER, axis=0))
    remaining = 1 - savgol_coeffs(WINDOW, ORDER)[WINDOW // 2]  # share of the noise's variance that the fit leaves
    # the median: a quantised velocity is constant at standstill, and an impact is not noise
    return GAUSSIAN * np.median(np.abs(residual), axis=0) / np.sqrt(remaining)
