"""Contact: a force on the tool for some seconds of one recording."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.inverse_dynamics import gravity_torque
from physident.effects.effect import Array, Column, Effect
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

PIECE = 0.5  # s


@dataclass(frozen=True)
class Contact(Effect):
    """tau = J(q)^T F: the arm pushes with F at its tool; F in the base frame, in N, constant over pieces of 0.5 s, or over
    each interval where it is ``steady``.

    ``intervals`` (start, end) [s] on the recording's own clock, counted from its first row; ``recording`` the hash of the
    recording they belong to, empty for any. J is the Jacobian of the tool's position: the last fixed frame of the robot.
    """

    intervals: tuple[tuple[float, float], ...] = ((0.0, PIECE),)
    recording: str = ""
    steady: bool = False

    name: ClassVar[str] = "contact"
    unit: ClassVar[str] = "N"
    signature: ClassVar[str] = "transient, coherent over the joints through one Jacobian"
    rivals: ClassVar[str] = "dropouts: they keep to one joint"

    def __post_init__(self) -> None:
        object.__setattr__(self, "intervals", tuple((float(a), float(b)) for a, b in self.intervals))
        if self.joints is not None:
            raise InputError("contact acts on the whole arm; expected no joints setting")
        if not self.intervals or not all(np.isfinite(i).all() and i[0] < i[1] for i in map(np.array, self.intervals)):
            raise InputError(
                f"contact: intervals are {self.intervals}, expected (start, end) [s] with start before end"
            )

    def pieces(self) -> list[tuple[float, float]]:
        """Start and end [s] of each piece with a constant force."""
        if self.steady:
            return list(self.intervals)
        edges = [np.append(np.arange(start, end - 1e-9, PIECE), end) for start, end in self.intervals]
        return [(float(a), float(b)) for e in edges for a, b in itertools.pairwise(e)]

    def anywhere(self) -> tuple[Effect, float]:
        lengths = [end - start for start, end in self.intervals]
        ends = list(itertools.accumulate(lengths))
        laid = tuple((end - length, end) for end, length in zip(ends, lengths, strict=True))
        return Contact(intervals=laid, steady=self.steady), ends[-1]

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        return tuple(
            Column(f"{self.name}_F{axis}_{start:g}s", self.unit, robot.n, self.name)
            for start, _ in self.pieces()
            for axis in "xyz"
        )

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        count = 3 * len(self.pieces())
        return np.array([(j, c) for c in range(count) for j in range(robot.n)], dtype=np.intp)

    def values(self, robot: Robot, signals: Signals) -> Array:
        pieces, time = self.pieces(), signals.time - signals.origin
        values = np.zeros((len(pieces), 3, robot.n, len(time)))
        if self.recording in ("", signals.recording):
            for piece, (start, end) in zip(values, pieces, strict=True):
                inside = (time >= start) & (time < end)
                if inside.any():
                    piece[:, :, inside] = tool_jacobian(robot, signals.q[inside]).transpose(1, 2, 0)
        return values.reshape(-1, len(time))


def tool_jacobian(robot: Robot, q: Array) -> Array:
    """Jacobian (N, 3, n) [m|1] of the tool's position in the base frame at positions (N, n).

    A unit mass at the tool weighs -J^T g: its gravity torque under unit gravity along each axis is minus a row of J.
    """
    x, y, z = robot.tool
    point = np.zeros(10 * robot.n)
    point[-10:] = [1, x, y, z, y * y + z * z, -x * y, x * x + z * z, -x * z, -y * z, x * x + y * y]
    return np.stack([-gravity_torque(robot, point, q, axis) for axis in np.eye(3)], axis=1)
