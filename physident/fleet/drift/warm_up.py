"""How warm an arm was in each recording, from how long it had been at work that day: what stands for a temperature that nobody measured."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TIME_CONSTANTS = (600.0, 3600.0)  # s: motors warm up within minutes, gears within an hour or more
CLOCK = 1.0  # s: clocks of recordings that follow one another agree to this


def warmth(rows: Sequence[dict[str, Any]]) -> Array:
    """Mean of 1 - exp(-t / T) over each of N recordings of an arm, (N, 2), for each time constant T; t is the time at work that day.

    ``rows`` have the ``day``, the ``file``, the duration in ``seconds`` and the first value ``start`` [s] of the clock. Where the
    clocks of a day's recordings follow one another, t counts from the first one; where each begins anew, t is the duration of
    those before. An arm is taken to be cold when a day begins.
    """
    days: dict[Any, list[int]] = defaultdict(list)
    for k, row in enumerate(rows):
        days[row["day"]].append(k)
    result = np.zeros((len(rows), len(TIME_CONSTANTS)))
    for places in days.values():
        ordered = sorted(places, key=lambda k: (rows[k].get("start") or 0.0, rows[k]["file"]))
        start = np.array([rows[k].get("start") or 0.0 for k in ordered])
        seconds = np.array([rows[k]["seconds"] or 0.0 for k in ordered])
        follows = bool((np.diff(start) >= seconds[:-1] - CLOCK).all())
        begun = start - start[0] if follows else np.cumsum(seconds) - seconds
        for i, constant in enumerate(TIME_CONSTANTS):
            ends = np.exp(-begun / constant), np.exp(-(begun + seconds) / constant)
            length = np.maximum(seconds, CLOCK)
            result[ordered, i] = np.clip(1 - constant / length * (ends[0] - ends[1]), 0, 1)
    return result
