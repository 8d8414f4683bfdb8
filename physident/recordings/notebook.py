"""A recording as a notebook shows it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.notebook import results_html

Array = NDArray[np.float64]


def recording_html(title: str, joints: Sequence[str], q: Array, dq: Array, effort: Array, quantity: str) -> str:
    """A row for each joint: the ranges of position q (N, n) [rad|m] and of effort (N, n), and the largest speed of dq (N, n)
    [rad/s|m/s]; ``quantity`` is what the effort is, with its unit."""
    head = ("joint", "smallest position [rad]", "largest", "largest speed [rad/s]", f"smallest {quantity}", "largest")
    values = (q.min(axis=0), q.max(axis=0), np.abs(dq).max(axis=0), effort.min(axis=0), effort.max(axis=0))
    rows = [(name, *(f"{x:.4g}" for x in row)) for name, *row in zip(joints, *values, strict=True)]
    return results_html(title, head, rows)
