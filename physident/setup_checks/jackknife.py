"""Intervals from a jackknife over long blocks of time, which hold for autocorrelated residuals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
LEVEL = 0.99  # of every interval; each finding also has to be of a size that no healthy set-up has


@dataclass(frozen=True, eq=False, kw_only=True)
class Interval:
    """A value and the two ends of its interval at ``LEVEL``; arrays of one shape."""

    value: Array
    low: Array
    high: Array


def jackknife(whole: Array, replicates: Array) -> Interval:
    """The interval of a statistic (...) from its values (B, ...) with one of B blocks left out each time.

    Source: Efron and Tibshirani, "An Introduction to the Bootstrap" (1993), sec. 11.2, with Student's t over B - 1 degrees of
    freedom.
    """
    from scipy.stats import t

    count = len(replicates)
    spread = replicates - replicates.mean(axis=0)
    error = np.sqrt((count - 1) / count * (spread**2).sum(axis=0))
    half = cast(float, t.ppf((1 + LEVEL) / 2, count - 1)) * error
    return Interval(value=np.asarray(whole), low=whole - half, high=whole + half)
