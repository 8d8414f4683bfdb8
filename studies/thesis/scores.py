"""One error for every way: relative, per joint, both sides through the same filter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import physident as pid
from studies.thesis.published import RATE

Array = NDArray[np.float64]
FILTER = pid.Filter(5.0)


def filtered(torque: Array) -> Array:
    """Torque (N, n) through the common low-pass, (M, n)."""
    return FILTER.apply(torque.T, RATE).T


def relative(measured: Array, predicted: Array) -> Array:
    """100 |measured - predicted| / |measured| (n,) [%] after the filter."""
    a, b = filtered(measured), filtered(predicted)
    return 100 * np.linalg.norm(a - b, axis=0) / np.linalg.norm(a, axis=0)


def rms(difference: Array) -> Array:
    """Root mean square (n,) [N m] after the filter."""
    return np.sqrt(np.mean(filtered(difference) ** 2, axis=0))
