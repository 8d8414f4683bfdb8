"""Residuals with their spectrum and the joints' correlation kept, and their relation to the motion destroyed.

Source: Prichard and Theiler, "Generating surrogate data for time series with several simultaneously measured variables"
(1994): the Fourier phases of all series are turned by the same random angles.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
LONGEST = 1 << 14  # rows of a part: a thousand times what residuals remember


def phase_randomised(
    residual: Array, segment: NDArray[np.intp], count: int, seed: int, some: slice = slice(None)
) -> Array:
    """Surrogates (M, n, count) of residuals (M, n), each contiguous segment (label (M,)) on its own, or ``some`` of them.

    A segment of more than ``LONGEST`` rows is cut into parts, each far longer than residuals remember.
    """
    rng = np.random.default_rng([seed, 7])
    result = np.empty((*residual.shape, len(range(count)[some])))
    for rows in _parts(segment):
        length = rows.stop - rows.start
        spectrum = np.fft.rfft(residual[rows], axis=0)
        turn = np.exp(1j * rng.uniform(0, 2 * np.pi, (len(spectrum), 1, count))[:, :, some])
        turned = spectrum[:, :, None] * turn
        # a mean has no phase to turn: noise has as much power at rest as at the lowest frequency
        turned[0] = np.sqrt(2) * turned[min(1, len(turned) - 1)].real
        if length % 2 == 0:  # the last coefficient of an even length is real: only its sign is free
            turned[-1] = spectrum[-1, :, None] * np.sign(turn[-1].real)
        result[rows] = np.fft.irfft(turned, length, axis=0)
    return result


def _parts(segment: NDArray[np.intp]) -> list[slice]:
    """The rows of each segment, or of the parts of a long one; segments are consecutive."""
    ends = [0, *(np.flatnonzero(np.diff(segment)) + 1).tolist(), len(segment)]
    parts = []
    for start, stop in itertools.pairwise(ends):
        pieces = -(-(stop - start) // LONGEST)
        cuts = [start + (stop - start) * k // pieces for k in range(pieces + 1)]
        parts += [slice(a, b) for a, b in itertools.pairwise(cuts)]
    return parts
