"""The limits of each joint's position, speed and acceleration, as linear constraints on a Fourier series."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import block_diag

from physident.errors import InputError
from physident.excitation.limits.constraints import Constraints
from physident.excitation.limits.limit import Margin
from physident.excitation.motion.motion import Motion
from physident.excitation.motion.series import Series
from physident.excitation.motion.trajectory import FREE_RANGE, FREE_SPEED
from physident.robots.robot import Robot

Array = NDArray[np.float64]
STILL = 1e-12  # replaces a range of zero in a division: such a joint stays at rest
ACTIVE_SHARE = 0.02  # of a limit: a smaller margin means that the limit shaped the motion


@dataclass(frozen=True, eq=False)
class JointLimits:
    """Limits (n,) of each joint, all finite: ``lower``, ``upper`` [rad|m], ``speed`` [rad/s|m/s], ``acceleration``
    [rad/s^2|m/s^2]."""

    lower: Array
    upper: Array
    speed: Array
    acceleration: Array

    @staticmethod
    def of(robot: Robot) -> JointLimits:
        """The robot's limits; a joint without a stated limit gets +-pi rad, pi rad/s, pi rad/s^2."""
        lower = np.where(np.isfinite(robot.lower), robot.lower, np.minimum(-FREE_RANGE, robot.upper - 2 * FREE_RANGE))
        upper = np.where(np.isfinite(robot.upper), robot.upper, np.maximum(FREE_RANGE, lower + 2 * FREE_RANGE))
        acceleration = np.array(robot.acceleration_limit or (math.inf,) * robot.n)
        speed = np.where(np.isfinite(robot.velocity_limit), robot.velocity_limit, FREE_SPEED)
        return JointLimits(lower, upper, speed, np.where(np.isfinite(acceleration), acceleration, FREE_SPEED))

    def check_movable(self) -> None:
        """Raises InputError for a joint whose limits allow no motion, with the joint and the limit."""
        for j in range(len(self.lower)):
            ranges = {
                "position": self.upper[j] - self.lower[j],
                "speed": self.speed[j],
                "acceleration": self.acceleration[j],
            }
            for name, size in ranges.items():
                if not size > 0:
                    raise InputError(
                        f"joint {j + 1} cannot move: its {name} limit is {size:g}, expected more than zero"
                    )

    def constraints(self, series: Series, nodes: int) -> Constraints:
        """The limits as constraints on ``nodes`` instants of a period, tightened so that they hold at every instant.

        A trigonometric polynomial of order L is at most 1 / cos(pi L / N) times its largest value on N equidistant
        nodes, for positions about the middle of their range. Source: Ehlich and Zeller (1964).
        """
        Q, V, A = series.basis(np.arange(nodes) / nodes)
        tightened = math.cos(math.pi * series.harmonics / nodes)
        middle, half = (self.upper + self.lower) / 2, tightened * (self.upper - self.lower) / 2
        sizes = [half, tightened * self.speed, tightened * self.acceleration]
        size = np.stack(sizes, axis=1).repeat(nodes, axis=1).ravel()
        centre = np.stack([middle, 0 * middle, 0 * middle], axis=1).repeat(nodes, axis=1).ravel()
        J = block_diag([np.vstack([Q, V, A])] * series.n).tocsr()
        J.eliminate_zeros()
        entries = J.tocoo()
        values = np.asarray(entries.data) / size[entries.row]
        pattern = np.column_stack([entries.row, entries.col]).astype(np.intp)
        ones = np.ones(len(size))
        return Constraints(-ones, ones, pattern, lambda y: (J @ y - centre) / size, lambda y: values)


def joint_margins(robot: Robot, motion: Motion) -> list[Margin]:
    """Margins of position, speed and acceleration of each joint, which hold at every instant."""
    limits, extent = JointLimits.of(robot), motion.extent()
    result = []
    for j, joint in enumerate(robot.joints):
        unit, where = "m" if joint.kind == "prismatic" else "rad", f"joint {j + 1}"
        low, high = extent.lower[j] - limits.lower[j], limits.upper[j] - extent.upper[j]
        reached, allowed = (extent.lower[j], limits.lower[j]) if low < high else (extent.upper[j], limits.upper[j])
        size = limits.upper[j] - limits.lower[j]
        result.append(
            Margin.of(
                "position", where, unit,
                reached=reached, allowed=allowed, margin=min(low, high), active_below=ACTIVE_SHARE * size,
            )
        )  # fmt: skip
        for name, per, reached, allowed in (
            ("speed", "/s", extent.speed[j], limits.speed[j]),
            ("acceleration", "/s^2", extent.acceleration[j], limits.acceleration[j]),
        ):
            result.append(
                Margin.of(
                    name, where, unit + per,
                    reached=reached, allowed=allowed, margin=allowed - reached, active_below=ACTIVE_SHARE * allowed,
                )
            )  # fmt: skip
    return result


def scale_into_limits(
    limits: JointLimits, series: Series, nodes: int, coefficients: Array, size: Array, position: Array
) -> Array:
    """P motions (P, n m) of a series inside the joint limits, from any numbers.

    ``coefficients`` (P, n, m - 1) are the free numbers of each joint but the offset, before scaling. ``size`` (P, n) from 0
    to 1 is the share of the first limit that the joint reaches. ``position`` (P, n) from 0 to 1 places the motion within
    the range that is left.
    """
    Q, V, A = (basis[:, :-1] for basis in series.basis(np.arange(nodes) / nodes))
    tightened = math.cos(math.pi * series.harmonics / nodes)
    q, v, a = coefficients @ Q.T, coefficients @ V.T, coefficients @ A.T
    middle, half = (q.max(axis=2) + q.min(axis=2)) / 2, np.maximum(np.ptp(q, axis=2) / 2 / tightened, STILL)
    half_range = (limits.upper - limits.lower) / 2
    factor = size * np.minimum.reduce(
        [
            half_range / half,
            tightened * limits.speed / np.maximum(np.abs(v).max(axis=2), STILL),
            tightened * limits.acceleration / np.maximum(np.abs(a).max(axis=2), STILL),
        ]
    )
    # one whole turn about zero is enough: the torques repeat after it
    reach = np.minimum(half_range, FREE_RANGE)
    free = np.maximum(reach - factor * half, 0.0)
    centre = np.clip(0.0, limits.lower + reach, limits.upper - reach)
    offset = centre + (2 * position - 1) * free - factor * middle
    scaled = np.concatenate([factor[:, :, None] * coefficients, offset[:, :, None]], axis=2)
    return scaled.reshape(len(coefficients), -1)
