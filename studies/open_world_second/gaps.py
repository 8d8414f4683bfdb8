"""Torques with gaps, for channels with memory: a plant may not know the torque of a joint that friction holds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def bridged(torque: Array) -> Array:
    """The torque (N, n) with straight lines across its gaps (NaN); a channel that is all gap is zero."""
    gaps = np.isnan(torque)
    if not gaps.any():
        return torque
    whole = np.zeros_like(torque)
    rows = np.arange(len(torque))
    for j, gap in enumerate(gaps.T):
        if not gap.all():
            whole[:, j] = np.interp(rows, rows[~gap], torque[~gap, j])
    return whole
