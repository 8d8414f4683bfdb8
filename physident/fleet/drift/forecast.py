"""Where a trend leads: a straight line through what is left of a parameter since it began to change."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
AHEAD = 90.0  # days
FEWEST = 4  # recordings: a line through three leaves one of them to say how it scatters
LEVEL = 0.95


@dataclass(frozen=True)
class Forecast:
    """The trend of a change in its unit: ``slope`` for each year, and what it is ``days`` ahead, with its 95 % interval."""

    slope: float
    days: float
    value: float
    low: float
    high: float


def forecast(day: Array, rest: Array, size: Array) -> Forecast | None:
    """The forecast from recordings (N,) since a change began; None where they are too few, or show no trend.

    ``rest`` is the change without what conditions explain and ``size`` its standard deviation. A trend is a slope whose 95 %
    interval leaves out zero; the interval of the forecast includes the scatter of a single recording.
    """
    from scipy.stats import t

    if len(day) < FEWEST:
        return None
    X = np.column_stack([np.ones(len(day)), day - day[-1]]) / size[:, None]
    inverse = np.linalg.inv(X.T @ X)
    line = inverse @ (X.T @ (rest / size))
    freedom = len(day) - 2
    spread = max(1.0, float(((rest / size - X @ line) ** 2).sum()) / freedom)
    half = float(t.ppf((1 + LEVEL) / 2, freedom))
    if abs(line[1]) <= half * np.sqrt(spread * inverse[1, 1]):
        return None
    ahead = np.array([1.0, AHEAD])
    value = float(ahead @ line)
    error = half * float(np.sqrt(spread * (ahead @ inverse @ ahead + np.median(size) ** 2)))
    return Forecast(float(line[1]) * 365.25, AHEAD, value, value - error, value + error)
