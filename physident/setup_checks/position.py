"""Positions that cannot be those of the description's joints: in degrees, or of the motors before the gears."""

from __future__ import annotations

import numpy as np

from physident.setup_checks.finding import SetupFinding, within
from physident.setup_checks.jackknife import jackknife
from physident.setup_checks.joint_fit import CERTAIN, Moments, moments_of, own_unexplained
from physident.setup_checks.rows import Rows

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
    evidence = f"joint {j + 1} is recorded from {low:.3g} to {high:.3g} rad and described from {robot.lower[j]:.3g} to {robot.upper[j]:.3g}"
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
