"""What a joint may do: position, velocity and acceleration, as linear constraints on a Fourier series."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import block_diag

from physident.errors import InputError
from physident.excitation.motion.series import Series
from physident.excitation.motion.trajectory import FREE_RANGE, FREE_SPEED
from physident.excitation.search.nlp import Rows
from physident.robots.robot import Robot

Array = NDArray[np.float64]
STILL = 1e-12  # of a shape that is zero: it stays so


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
        """The robot's limits; a joint without one gets +-pi rad, pi rad/s, pi rad/s^2."""
        lower = np.where(np.isfinite(robot.lower), robot.lower, np.minimum(-FREE_RANGE, robot.upper - 2 * FREE_RANGE))
        upper = np.where(np.isfinite(robot.upper), robot.upper, np.maximum(FREE_RANGE, lower + 2 * FREE_RANGE))
        acceleration = np.array(robot.acceleration_limit or (math.inf,) * robot.n)
        speed = np.where(np.isfinite(robot.velocity_limit), robot.velocity_limit, FREE_SPEED)
        return JointLimits(lower, upper, speed, np.where(np.isfinite(acceleration), acceleration, FREE_SPEED))

    def refuse_stuck(self) -> None:
        """Raises InputError for a joint whose limits leave no motion, naming it and the limit."""
        for j in range(len(self.lower)):
            room = {
                "position": self.upper[j] - self.lower[j],
                "speed": self.speed[j],
                "acceleration": self.acceleration[j],
            }
            for name, size in room.items():
                if not size > 0:
                    raise InputError(f"joint {j + 1} cannot move: its {name} limit leaves {size:g}, expected room")

    def rows(self, series: Series, nodes: int) -> Rows:
        """The limits as constraints on ``nodes`` instants of a period, tightened so that they hold at every instant.

        A trigonometric polynomial of order L is at most 1 / cos(pi L / N) times its largest value on N equidistant
        nodes, for positions about the middle of their range. Source: Ehlich and Zeller (1964).
        """
        Q, V, A = series.basis(np.arange(nodes) / nodes)
        inside = math.cos(math.pi * series.harmonics / nodes)
        middle, half = (self.upper + self.lower) / 2, inside * (self.upper - self.lower) / 2
        ends = np.stack([half, inside * self.speed, inside * self.acceleration], axis=1).repeat(nodes, axis=1).ravel()
        centre = np.stack([middle, 0 * middle, 0 * middle], axis=1).repeat(nodes, axis=1).ravel()
        J = block_diag([np.vstack([Q, V, A])] * series.n).tocsr()
        J.eliminate_zeros()
        entries = J.tocoo()
        values = np.asarray(entries.data) / ends[entries.row]
        pattern = np.column_stack([entries.row, entries.col]).astype(np.intp)
        one = np.ones(len(ends))
        return Rows(-one, one, pattern, lambda y: (J @ y - centre) / ends, lambda y: values)


def spread(limits: JointLimits, series: Series, nodes: int, shapes: Array, share: Array, place: Array) -> Array:
    """Motions (P, n m) inside the joint limits from any numbers.

    ``shapes`` (P, n, m - 1) say how each joint moves, ``share`` (P, n) from 0 to 1 how much of the first limit it meets
    it uses, ``place`` (P, n) from 0 to 1 where in its range it does so.
    """
    Q, V, A = (basis[:, :-1] for basis in series.basis(np.arange(nodes) / nodes))
    inside = math.cos(math.pi * series.harmonics / nodes)
    q, v, a = shapes @ Q.T, shapes @ V.T, shapes @ A.T
    middle, half = (q.max(axis=2) + q.min(axis=2)) / 2, np.maximum(np.ptp(q, axis=2) / 2 / inside, STILL)
    room = (limits.upper - limits.lower) / 2
    factor = share * np.minimum.reduce(
        [
            room / half,
            inside * limits.speed / np.maximum(np.abs(v).max(axis=2), STILL),
            inside * limits.acceleration / np.maximum(np.abs(a).max(axis=2), STILL),
        ]
    )
    # a whole turn of positions is enough: sines know no more
    reach = np.minimum(room, FREE_RANGE)
    free = np.maximum(reach - factor * half, 0.0)
    centre = np.clip(0.0, limits.lower + reach, limits.upper - reach)
    offset = centre + (2 * place - 1) * free - factor * middle
    return np.concatenate([factor[:, :, None] * shapes, offset[:, :, None]], axis=2).reshape(len(shapes), -1)
