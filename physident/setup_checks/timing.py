"""A constant delay between positions and efforts: the shift with which the description explains the efforts best.

Friction that builds up over a small angle is late after a reversal, and would be taken for a delay: it is fitted, over several angles, and
rows at which a joint is slow are left out for that joint. So would friction that grows with the load, which slow motions have most of.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from physident.setup_checks.finding import SetupFinding
from physident.setup_checks.jackknife import Interval, jackknife
from physident.setup_checks.joint_fit import TINY
from physident.setup_checks.order import TWICE
from physident.setup_checks.rows import Rows

Array = NDArray[np.float64]
SHIFTS = np.arange(-0.15, 0.1501, 0.01)  # s
LATE = 0.02  # s: a tenth of the period of a 5 Hz motion
FAST = 0.3  # of a joint's 95th percentile of speed: slower rows are near a reversal
FLOOR = 1e-3  # share of the variance: a simulator's exact data are not worth more than good real ones


def check_delay(rows: Rows) -> SetupFinding | None:
    """An effort that is early or late against its position."""
    delay = effort_delay(rows)
    if delay is None or (float(delay.low) < LATE and float(delay.high) > -LATE):
        return None
    value, way = float(delay.value), "later" if delay.value > 0 else "earlier"
    return SetupFinding(
        kind="effort_delay",
        joints=(),
        statement=f"the efforts are {way} than the positions by {1e3 * abs(value):.0f} ms; shift the channels onto one clock",
        evidence=f"interval {math.floor(1e3 * float(delay.low))} to {math.ceil(1e3 * float(delay.high))} ms",
        void=False,
    )


def effort_delay(rows: Rows) -> Interval | None:
    """Delay [s] of the efforts behind the positions; None where it lies at the end of what was searched, where it explains away less
    than half of what is left, or where it is not seen without the joint that shows it most. Friction that a description lacks is early
    or late by a little of it, and the ripple of one motor suits some shift of its joint; a clock shifts all joints alike."""
    blocks = np.unique(rows.block)
    sums = [_joint_sums(rows, j, blocks) for j in range(rows.robot.n)]
    kept = ~np.vstack([np.zeros(len(blocks), bool), np.eye(len(blocks), dtype=bool)])
    left = np.array([[_left(joint, some) for joint in sums] for some in kept])  # (1 + B, n, S)
    found = _delay(left)
    if found is None:
        return None
    before, after = left[0, :, len(SHIFTS) // 2], left[0, :, np.argmin(left[0].sum(axis=0))]
    if (before - after).sum() < TWICE:
        return None
    others = _delay(np.delete(left, np.argmax(before - after), axis=1))
    agree = others is not None and float(others.low if found.value > 0 else -others.high) > 0
    return found if agree or rows.robot.n == 1 else None


def _delay(left: Array) -> Interval | None:
    """The delay [s] that suits the joints of ``left`` (1 + B, n, S) best, from all blocks and without each of them."""
    whole, *replicates = (_lowest(one) for one in left.sum(axis=1))
    if not np.isfinite([whole, *replicates]).all():
        return None
    return jackknife(np.array(whole), np.array(replicates))


@dataclass(frozen=True, eq=False)
class _Sums:
    """Of one joint, by blocks: products of its columns (B, k, k), with each shifted torque (B, S, k), of the torques (B, S)."""

    inner: Array
    cross: Array
    power: Array


def _joint_sums(rows: Rows, joint: int, blocks: NDArray[np.intp]) -> _Sums:
    load = np.abs(rows.gravity + rows.inertial)[:, joint] * rows.sign[:, joint]
    columns = np.column_stack([rows.columns[joint], load, rows.bristles[:, joint]])
    speed = np.abs(rows.v[:, joint])
    fast = speed > FAST * np.percentile(speed, 95)
    x, y, block, segment = columns[fast], _shifted(rows, joint)[fast], rows.block[fast], rows.segment[fast]
    for part in np.unique(segment):  # an offset of one recording is no evidence
        x[segment == part] -= x[segment == part].mean(axis=0)
        y[segment == part] -= y[segment == part].mean(axis=0)
    parts = [(x[block == b], y[block == b]) for b in blocks]
    return _Sums(
        np.array([a.T @ a for a, _ in parts]),
        np.array([c.T @ a for a, c in parts]),
        np.array([(c**2).sum(axis=0) for _, c in parts]),
    )


def _left(sums: _Sums, kept: NDArray[np.bool_]) -> Array:
    """Logarithm (S,) of the share of variance that least squares leaves of the torque with each shift."""
    inner, cross, power = (x[kept].sum(axis=0) for x in (sums.inner, sums.cross, sums.power))
    scale = np.sqrt(np.maximum(np.diag(inner), 0.0))
    used = scale > TINY * np.sqrt(power.max())
    if not used.any() or not power.min() > 0:
        return np.zeros(len(SHIFTS))
    b = cross[:, used] / scale[used]
    matrix = inner[np.ix_(used, used)] / np.outer(scale[used], scale[used])
    explained = np.einsum("sk,kl,sl->s", b, np.linalg.pinv(matrix, rcond=1e-9, hermitian=True), b)
    return np.log(np.maximum(1 - explained / power, 0.0) + FLOOR)


def _shifted(rows: Rows, joint: int) -> Array:
    """The efforts (M, S) of a joint later by every shift."""
    torque = np.empty((len(rows.time), len(SHIFTS)))
    for part in np.unique(rows.segment):
        chosen = rows.segment == part
        time = rows.time[chosen]
        later = np.clip(time[:, None] + SHIFTS, time[0], time[-1])
        torque[chosen] = CubicSpline(time, rows.torque[chosen, joint])(later)
    return torque


def _lowest(values: Array) -> float:
    """The shift [s] at the bottom of the parabola through the lowest value and its neighbours; NaN at either end."""
    k = int(np.argmin(values))
    if k in (0, len(values) - 1):
        return np.nan
    left, middle, right = values[k - 1 : k + 2]
    bend = left - 2 * middle + right
    return float(SHIFTS[k] + (SHIFTS[1] - SHIFTS[0]) * 0.5 * (left - right) / bend) if bend > 0 else float(SHIFTS[k])
