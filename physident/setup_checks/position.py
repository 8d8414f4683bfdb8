"""Positions that cannot be those of the description's joints: in degrees, or of the motors before the gears."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from physident.setup_checks.finding import SetupFinding, within
from physident.setup_checks.jackknife import jackknife
from physident.setup_checks.joint_fit import CERTAIN, Moments, moments_of, own_unexplained
from physident.setup_checks.order import LOSS, THRICE, TWICE, counts_the_other_way
from physident.setup_checks.rows import Rows

# how a joint may stand in a recording and not in the description: direction (1 or -1) and zero [rad]
PLACES = {
    "turns the other way than it is described": (-1.0, 0.0),
    "is recorded 90 degrees below where it is described": (1.0, np.pi / 2),
    "is recorded 90 degrees above where it is described": (1.0, -np.pi / 2),
    "is recorded half a turn from where it is described": (1.0, np.pi),
}
COUNTS = "counts the other way, and its effort does not"
MARGIN = 0.1  # of a joint's range beyond its limits: limits in descriptions are rounded
OUTSIDE = 0.05  # of the rows: single rows may be wrong
FACTORS = np.geomspace(20.0, 200.0, 24)  # gear ratios of arms; degrees are among them
DEGREES = 180 / np.pi
NEAR = 1.12  # a factor as close to 57.3 is degrees


def check_positions(rows: Rows, moments: Moments, unit: bool) -> SetupFinding | None:
    """Positions outside of the description's limits: in the ``unit`` with which they fit, or, where no unit fits, as such."""
    robot = rows.robot
    span = np.where(np.isfinite(robot.upper - robot.lower), robot.upper - robot.lower, np.inf)
    beyond = (rows.q < robot.lower - MARGIN * span) | (rows.q > robot.upper + MARGIN * span)
    far = beyond.mean(axis=0) > OUTSIDE
    if not far.any():
        return None
    joints = tuple(int(j) + 1 for j in np.flatnonzero(far))
    factor = _factor(rows, moments)
    if unit != (factor is not None):
        return None
    j = joints[0] - 1
    low, high = rows.q[:, j].min(), rows.q[:, j].max()
    evidence = f"joint {j + 1} is recorded from {low:.3g} to {high:.3g} {robot.joints[j].unit('rad')} and described from {robot.lower[j]:.3g} to {robot.upper[j]:.3g}"
    if factor is not None and 1 / NEAR < factor / DEGREES < NEAR:
        kind, what = "position_degrees", "the positions are in degrees; convert them to radians"
    elif factor is not None:
        kind, what = (
            "position_motor",
            f"the positions are those of the motors, about {factor:.0f} times the joints'; divide by the gear ratio",
        )
    else:
        kind = "position_range"
        what = f"the positions of {within(joints, robot.n)} are outside the description's limits: positions of the motors, or another robot"
    return SetupFinding(kind=kind, joints=joints, statement=what, evidence=evidence, void=True)


def check_zeros(rows: Rows, moments: Moments) -> tuple[float, SetupFinding] | None:
    """One joint whose zero or direction, of position and effort alike, is not the description's; with the logarithm of what
    the description then leaves less of the efforts, a sum over joints. None where none is surely better."""
    as_is = own_unexplained(moments)
    found: tuple[float, int, str, Moments] | None = None
    for j in range(rows.robot.n):
        for change, other_rows in _elsewhere(rows, j):
            other = moments_of(other_rows)
            gains = np.log(np.maximum(as_is, CERTAIN) / np.maximum(own_unexplained(other), CERTAIN))
            strong = gains[other_rows.strong()]
            if gains.min() > -LOSS and strong.sum() > TWICE and gains.sum() > THRICE:
                found = (
                    max(found, (float(gains.sum()), j, change, other), key=lambda f: f[0])
                    if found
                    else (float(gains.sum()), j, change, other)
                )
    if found is None:
        return None
    total, j, change, other = found
    lasting = [
        float(
            np.log(
                np.maximum(own_unexplained(moments, b), CERTAIN) / np.maximum(own_unexplained(other, b), CERTAIN)
            ).sum()
        )
        for b in range(moments.blocks)
    ]
    if min(lasting) < TWICE:
        return None
    mean = [100 * float(shares.mean()) for shares in (as_is, own_unexplained(other))]
    if change == COUNTS:
        kind, statement = "position_sign", f"{counts_the_other_way((j + 1,))}: turn the sign of q and dq over"
    else:
        kind = "joint_place"
        statement = f"joint {j + 1} {change}; correct its positions, with velocities and efforts where it turns the other way, or the description's zero and axis"
    return total, SetupFinding(
        kind=kind,
        joints=(j + 1,),
        statement=statement,
        evidence=f"the description then leaves {mean[1]:.0f} % of the variance instead of {mean[0]:.0f} %, mean over joints",
        void=True,
    )


def _elsewhere(rows: Rows, joint: int) -> Iterator[tuple[str, Rows]]:
    """The rows with a joint (from 0) in each of ``PLACES``, and with its positions alone turned over."""
    for change, (direction, zero) in PLACES.items():
        yield change, rows.placed(joint, direction, zero)
    yield COUNTS, rows.counted(np.where(np.arange(rows.robot.n) == joint, -1.0, 1.0))


def upside_down_gain(rows: Rows, moments: Moments) -> float:
    """The logarithm of what the description leaves less of the efforts, a sum over joints, if its gravity is turned over."""
    x, y, z = rows.robot.gravity
    other = moments_of(replace(rows, robot=replace(rows.robot, gravity=(-x, -y, -z))))
    before, after = (np.maximum(own_unexplained(one), CERTAIN) for one in (moments, other))
    return float(np.log(before / after).sum())


def _factor(rows: Rows, moments: Moments) -> float | None:
    """The common factor of all positions with which the description explains the efforts; None where none does surely."""
    as_is = np.log(np.maximum(own_unexplained(moments), CERTAIN))
    tried = [
        (float(np.log(np.maximum(own_unexplained(moments_of(rows.scaled(1 / f))), CERTAIN)).sum()), f) for f in FACTORS
    ]
    best, factor = min(tried)
    if best > float(as_is.sum()) - np.log(2.0):
        return None
    other = moments_of(rows.scaled(1 / factor))
    gains = [
        float(np.sum(np.log(np.maximum(own_unexplained(moments, b), CERTAIN) / np.maximum(own_unexplained(other, b), CERTAIN))))
        for b in range(moments.blocks)
    ]  # fmt: skip
    return factor if jackknife(np.array(float(as_is.sum()) - best), np.array(gains)).low > 0 else None
