"""Noise of measured signals: white noise, from what a local polynomial fit does not explain, and spectra above their noise floor."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.large_arrays import BLOCK, blocks, median, release

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


BAND_SHARE = 0.99  # of a signal's power above its noise floor
NOISE_FACTOR = 3  # noise floors: a chi-squared bin of noise rarely exceeds it
LENGTH = 8.0  # s of each segment of which the spectrum is the mean


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Power density (F,) of a signal over ``frequency`` (F,) [Hz], and its noise ``floor``: the median of the highest third."""

    frequency: Array
    power: Array
    floor: float

    @property
    def band(self) -> float:
        """Frequency [Hz] below which 99 % of the power above the noise floor lies."""
        excess = np.maximum(self.power - NOISE_FACTOR * self.floor, 0.0)
        if not excess.any():
            return 0.0
        return float(self.frequency[np.searchsorted(np.cumsum(excess), BAND_SHARE * excess.sum())])

    @property
    def noise_from(self) -> float:
        """Lowest frequency [Hz] at which the signal is no stronger than its noise floor."""
        noise = np.flatnonzero(self.power <= NOISE_FACTOR * self.floor)
        return float(self.frequency[noise[0] if len(noise) else -1])


def spectrum_of(values: Array, rate: float) -> Spectrum:
    """The spectrum of samples (N,) at ``rate`` [Hz]: the mean of overlapping segments (Welch, "The use of fast Fourier transform
    for the estimation of power spectra" (1967))."""
    from scipy.signal import welch

    length = min(len(values), int(LENGTH * rate))
    step = length - length // 2
    segments = (len(values) - length) // step + 1
    together = max(1, BLOCK // step)  # segments of a piece
    total, frequency = np.zeros(length // 2 + 1), np.zeros(0)
    for first in range(0, segments, together):
        count = min(together, segments - first)
        some = values[first * step : (first + count - 1) * step + length]
        frequency, power = welch(some, rate, nperseg=length, detrend="linear")
        total += count * power
        release()
    power = total / segments
    return Spectrum(np.asarray(frequency), power, float(np.median(power[2 * len(power) // 3 :])))
