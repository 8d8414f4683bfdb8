"""The same motion recorded twice: what a recording differs by needs no model, and tells when a hand pushed."""

from __future__ import annotations

import numpy as np
from asking import UR5_GAINS
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

import physident as pid

Array = NDArray[np.float64]
WINDOW = 0.25  # s
PUSH = 6.0  # N m on two joints at once: stiction alone leaves twins apart too, but one joint at a time
APART = 0.6  # s: pushes that are closer are one
MOVES = 0.02  # rad/s


def difference(
    clean: pid.Recording, pushed: pid.Recording, filter: pid.Filter
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Time (N,) [s], torque of one twin less the other's (N, n) [N m], and whether any joint moves (N,)."""
    first, second = (pid.prepare(r, filter) for r in (clean, pushed))
    count = min(len(first.time), len(second.time))
    assert first.torque is not None
    assert second.torque is not None
    width = round(WINDOW * second.rate)
    apart = uniform_filter1d(second.torque[:count] - first.torque[:count], width, axis=0)
    moving = uniform_filter1d((np.abs(second.v[:count]) > MOVES).any(axis=1).astype(float), width) > 0.5
    return second.time[:count] - second.origin, apart, moving


def pushes(time: Array, apart: Array) -> list[tuple[float, float]]:
    """When the twins differ on two joints at once (start, end) [s]."""
    both = np.sort(np.abs(apart), axis=1)[:, -2] > PUSH
    found: list[tuple[float, float]] = []
    for t in time[both]:
        if found and t - found[-1][1] < APART:
            found[-1] = (found[-1][0], float(t))
        else:
            found.append((float(t), float(t)))
    return found


def pair(folder: str) -> tuple[pid.Recording, pid.Recording]:
    """The clean twin and the pushed one."""
    clean, pushed = pid.load_recordings(
        [f"{folder}/{n}.csv.gz" for n in ("move7", "move7_contact")], drive_gains=UR5_GAINS
    )
    return clean, pushed
