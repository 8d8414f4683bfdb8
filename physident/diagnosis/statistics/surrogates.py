"""Residuals with their spectrum and the joints' correlation kept, and their relation to the motion destroyed.

Source: Prichard and Theiler, "Generating surrogate data for time series with several simultaneously measured variables"
(1994): the Fourier phases of all series are turned by the same random angles.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def phase_randomised(residual: Array, segment: NDArray[np.intp], count: int, seed: int) -> Array:
    """Surrogates (M, n, count) of residuals (M, n), each contiguous segment (label (M,)) on its own."""
    rng = np.random.default_rng([seed, 7])
    result = np.empty((*residual.shape, count))
    for part in np.unique(segment):
        rows = np.flatnonzero(segment == part)
        length = len(rows)
        spectrum = np.fft.rfft(residual[rows], axis=0)
        angle = rng.uniform(0, 2 * np.pi, (len(spectrum), 1, count))
        turned = spectrum[:, :, None] * np.exp(1j * angle)
        # a mean has no phase to turn: noise has as much power at rest as at the lowest frequency
        turned[0] = np.sqrt(2) * turned[min(1, len(turned) - 1)].real
        if length % 2 == 0:  # the last coefficient of an even length is real: only its sign is free
            turned[-1] = spectrum[-1, :, None] * np.sign(np.cos(angle[-1]))
        result[rows] = np.fft.irfft(turned, length, axis=0)
    return result
