"""The friction of a joint as a format of simulators has it: damping and dry friction, neither of them negative."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.effects.effect import Effect
from physident.effects.friction import CoulombFriction, VelocityFriction, ViscousFriction
from physident.effects.learned.velocity_curve import LearnedVelocity
from physident.effects.user.formula import FormulaEffect
from physident.estimation.physical.cones import FREE_SPEED
from physident.robots.robot import Robot

Array = NDArray[np.float64]
Parts = list[tuple[Effect, Array]]
# of formulas, those that are no friction of the velocity alone have none here
OF_VELOCITY = (VelocityFriction, LearnedVelocity, FormulaEffect)
SPEEDS = 100  # evenly spaced
MOSTLY = (
    1 / 3
)  # of a joint's velocity limit: faster it rarely turns, and laws fitted at lower speeds may bend away there


@dataclass(frozen=True, eq=False)
class Line:
    """What is added to the damping and to the dry friction of a joint (from 0), so that they come as close to all its
    friction as two terms can that are not negative, and the ``damping`` and ``dry`` that result."""

    joint: int
    added_damping: float
    added_dry: float
    damping: float
    dry: float


def nearest_lines(robot: Robot, kept: Parts, left_out: Parts) -> list[Line]:
    """The joints whose friction is more than the damping and dry friction in ``kept``: those with a friction of their
    velocity in ``left_out``, and those with a negative term. Least squares over speeds up to a third of the
    velocity limit."""
    from scipy.optimize import nnls

    damping, dry = np.zeros((2, robot.n))
    for effect, theta in kept:
        for term in effect.joint_terms(robot, theta) or ():
            if len(term.joints) == 1:
                damping[term.joints[0]] += term.damping or 0.0
                dry[term.joints[0]] += term.dry or 0.0
    own = [(effect, theta) for effect, theta in left_out if isinstance(effect, OF_VELOCITY)]
    others = {j for effect, _ in own for j in effect.active(robot)}
    lines = []
    for j in range(robot.n):
        if j not in others and damping[j] >= 0 and dry[j] >= 0:
            continue
        limit = robot.velocity_limit[j]
        v = np.linspace(0, MOSTLY * (limit if np.isfinite(limit) else FREE_SPEED), SPEEDS + 1)[1:]
        torque = damping[j] * v + dry[j] + sum(_at_joint(robot, effect, theta, j, v) for effect, theta in own)
        (d, c), _ = nnls(np.column_stack([v, np.ones_like(v)]), torque)
        if not np.allclose([d, c], [damping[j], dry[j]], rtol=1e-9, atol=0.0):
            lines.append(Line(j, float(d - damping[j]), float(c - dry[j]), float(d), float(c)))
    return lines


def added(lines: list[Line], sign: float) -> Parts:
    """The effects that add what ``lines`` add, times ``sign``."""
    if not lines:
        return []
    joints = tuple(line.joint + 1 for line in lines)
    return [
        (ViscousFriction(joints), sign * np.array([line.added_damping for line in lines])),
        (CoulombFriction(joints, presliding=0.0), sign * np.array([line.added_dry for line in lines])),
    ]


def _at_joint(robot: Robot, effect: Effect, theta: Array, joint: int, v: Array) -> Array:
    """Friction (S,) of one joint (from 0) at speeds v (S,), the mean of both directions."""
    at = [k for k, column in enumerate(effect.columns(robot)) if column.joint == joint + 1]
    both = effect.friction(robot, v) - effect.friction(robot, -v)
    return 0.5 * theta[at] @ both[at]
