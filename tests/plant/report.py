"""From the torque that acts to the one that a drive is asked for, and to the one that is reported."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tests.plant.arm import Arm
from tests.truth import Disturbance

Array = NDArray[np.float64]
ROUNDS = 60
CLOSE = 1e-10  # N m


def asked(arm: Arm, time: Array, v: Array, acting: Array) -> Array:
    """Torque (N, n) [N m] that drives must be asked for so that ``acting`` (N, n) acts; NaN where none does it."""
    delivering = [d for d in arm.disturbances if type(d).deliver is not Disturbance.deliver]
    if not delivering:
        return acting
    out = acting.copy()
    for k in range(len(time)):
        known = np.isfinite(acting[k])
        need = np.where(known, acting[k], 0.0)
        ask, miss = need, np.full(len(need), np.inf)
        for _ in range(ROUNDS):
            got = ask
            for disturbance in delivering:
                got = disturbance.deliver(time[k], v[k], got)
            miss = need - got
            if np.abs(miss).max() < CLOSE:
                break
            ask = ask + miss
        out[k] = np.where(known & (np.abs(miss) < 1e3 * CLOSE), ask, np.nan)
    return out


def reported(arm: Arm, time: Array, q: Array, v: Array, motor: Array, seen: Array | None = None) -> Array:
    """Torque (N, n) [N m] as instruments report what the motors gave, free of noise: late, scaled, shifted, and at last
    disturbed. ``q``, ``v`` (N, n) as the joints truly moved; unknown (NaN) torques stay unknown, and
    are meanwhile taken as those with which the report is as ``seen``."""
    reporting = [d for d in arm.disturbances if type(d).report is not Disturbance.report]
    delays = arm.drives.delays
    unknown = np.isnan(motor)

    def shown(torque: Array) -> Array:
        torque = arm.drives.reported(_late(time, torque, delays))
        for disturbance in reporting:
            torque = disturbance.report(time, q, v, torque)
        return torque

    if not unknown.any():
        return shown(motor)
    if seen is None:
        seen = shown(np.where(unknown, 0.0, motor))
    trial = np.where(unknown, seen, motor)
    # a report that mixes torques shows a little of the unknown ones in others: a few corrections settle it
    for _ in range(ROUNDS if reporting and not delays.any() else 0):
        trial = trial + np.where(unknown, seen - shown(trial), 0.0)
    told = _late(time, unknown.astype(float), delays)
    return np.where(unknown | (told != 0), np.nan, shown(trial))


def _late(time: Array, torque: Array, delays: Array) -> Array:
    """Torque (N, n) [N m], that of each joint as it was a delay (n,) [s] before, by the cubic through the four rows around that instant."""
    if not delays.any():
        return torque
    behind = delays / (time[1] - time[0])
    place = np.clip(np.arange(len(time))[:, None] - behind, 0.0, len(time) - 1.0)
    first = np.clip(np.floor(place).astype(int) - 1, 0, len(time) - 4)
    x = place - first
    weights = [
        -(x - 1) * (x - 2) * (x - 3) / 6, x * (x - 2) * (x - 3) / 2, -x * (x - 1) * (x - 3) / 2, x * (x - 1) * (x - 2) / 6
    ]  # fmt: skip
    joint = np.arange(torque.shape[1])
    return sum((w * torque[first + i, joint] for i, w in enumerate(weights)), np.zeros_like(torque))
