"""Contact: a force on the tool for some seconds of one recording."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.inverse_dynamics import gravity_torque
from physident.effects.classification import Detection, Family, Scope, every_joint_pattern
from physident.effects.effect import Array, Column, Effect
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

PIECE = 0.5  # s: how long the force is taken as constant


@dataclass(frozen=True)
class Contact(Effect):
    """tau = J(q)^T F: the tool pushes with force F [N] in the base frame, constant over pieces of 0.5 s.

    Where it is ``steady``, F is constant over each of the ``intervals`` (start, end) [s], which count from the first row
    of the recording. ``recording`` is the hash of that recording, empty for any. J is the Jacobian of the tool's position;
    the tool is the last fixed frame of the robot.
    """

    intervals: tuple[tuple[float, float], ...] = ((0.0, PIECE),)
    recording: str = ""
    steady: bool = False

    name: ClassVar[str] = "contact"
    unit: ClassVar[str] = "N"
    family: ClassVar[Family] = Family.CONTACT
    scope: ClassVar[Scope] = Scope.WHOLE_ARM
    detection: ClassVar[Detection] = Detection.BY_TIME
    signature: ClassVar[str] = "short, and on all joints at once, as a force at the tool causes it"
    mistaken_for: ClassVar[str] = "sensor dropouts: they affect a single joint"

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "intervals", tuple((float(a), float(b)) for a, b in self.intervals))
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

    def moved_to_start(self) -> tuple[Effect, float]:
        lengths = [end - start for start, end in self.intervals]
        ends = list(itertools.accumulate(lengths))
        intervals = tuple((end - length, end) for end, length in zip(ends, lengths, strict=True))
        return Contact(intervals=intervals, steady=self.steady), ends[-1]

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        return tuple(
            Column(f"{self.name}_F{axis}_{start:g}s", self.unit, robot.n, self.name)
            for start, _ in self.pieces()
            for axis in "xyz"
        )

    def in_words(self, robot: Robot, theta: Array) -> str:
        return "The tool pushes with this force, and is pushed with its opposite; a push elsewhere on the arm has another force."

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        return every_joint_pattern(robot.n, 3 * len(self.pieces()))

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

    The gravity torque of a unit mass at the tool is -J^T g, so unit gravity along each axis gives minus one row of J.
    """
    x, y, z = robot.tool
    point = np.zeros(10 * robot.n)
    point[-10:] = [1, x, y, z, y * y + z * z, -x * y, x * x + z * z, -x * z, -y * z, x * x + y * y]
    return np.stack([-gravity_torque(robot, point, q, axis) for axis in np.eye(3)], axis=1)
