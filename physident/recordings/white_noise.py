"""White noise of measured signals, from what a local polynomial fit does not explain."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
WINDOW, ORDER = 9, 4  # samples and polynomial order of the local fit: a signal is smoother than that over nine samples
GAUSSIAN = 1.4826  # standard deviation of a Gaussian over the median of its absolute value


def white_noise(values: Array) -> Array:
    """Standard deviation (n,) of the white noise of even samples (N, n), in their unit; zero for fewer than nine."""
    from scipy.signal import savgol_coeffs, savgol_filter

    if len(values) < WINDOW:
        return np.zeros(values.shape[1])
    residual = values - np.asarray(savgol_filter(values, WINDOW, ORDER, axis=0))
    remaining = 1 - savgol_coeffs(WINDOW, ORDER)[WINDOW // 2]  # share of the noise's variance that the fit leaves
    # the median: a quantised signal is constant at standstill, and an impact is not noise
    return GAUSSIAN * np.median(np.abs(residual), axis=0) / np.sqrt(remaining)
