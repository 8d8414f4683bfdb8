"""White noise of measured signals, from what a local polynomial fit does not explain."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from physident.large_arrays import blocks, median

Array = NDArray[np.float64]
WINDOW, ORDER = 9, 4  # samples and polynomial order of the local fit: a signal is smoother than that over nine samples
GAUSSIAN = 1.4826  # standard deviation of a Gaussian over the median of its absolute value


def white_noise(values: Array) -> Array:
    """Standard deviation (n,) of the white noise of even samples (N, n), in their unit; zero for fewer than nine."""
    from scipy.signal import savgol_coeffs

    if len(values) < WINDOW:
        return np.zeros(values.shape[1])
    remaining = 1 - savgol_coeffs(WINDOW, ORDER)[WINDOW // 2]  # share of the noise's variance that the fit leaves
    # the median: a quantised signal is constant at standstill, and an impact is not noise
    sizes = [median(lambda column=column: _residuals(column)) for column in values.T]
    return GAUSSIAN * np.array(sizes) / np.sqrt(remaining)


def _residuals(values: Array) -> Iterator[Array]:
    """The sizes of what local fits do not explain of samples (N,), block by block."""
    from scipy.signal import savgol_filter

    for rows in blocks(len(values)):
        around = slice(max(0, min(rows.start, len(values) - WINDOW) - WINDOW), min(len(values), rows.stop + WINDOW))
        some = values[around]
        fitted = np.asarray(savgol_filter(some, WINDOW, ORDER))
        yield np.abs(some - fitted)[rows.start - around.start : rows.stop - around.start]
