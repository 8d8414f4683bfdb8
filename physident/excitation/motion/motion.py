"""The base class of planned motions: states, extent, violated limits, and files."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.files import write_json
from physident.outputs import write_with
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
SCHEMA = "physident.trajectory/1"
LIMIT_TOLERANCE = 1e-4  # relative: rounding, for a motion that was designed to reach a limit
MAX_SAMPLES = 10_000_000
LARGEST = 1e9  # of any number of a motion, so that its squares and sums are finite


@dataclass(frozen=True, eq=False)
class Extent:
    """The extent of a motion, (n,) each: positions from ``lower`` to ``upper`` [rad|m], and the largest absolute ``speed``
    [rad/s|m/s] and ``acceleration`` [rad/s^2|m/s^2]."""

    lower: Array
    upper: Array
    speed: Array
    acceleration: Array


class Motion(ABC):
    """A planned motion of n joints over ``duration`` [s]."""

    kind: ClassVar[str]
    duration: float

    @property
    @abstractmethod
    def n(self) -> int:
        """Number of joints."""

    @abstractmethod
    def states(self, time: Array) -> Signals:
        """Position, velocity and acceleration at instants (N,) [s]; at standstill before the start and after the end."""

    @abstractmethod
    def extent(self) -> Extent:
        """Bounds of position, speed and acceleration that hold at every instant, not only on a grid."""

    @abstractmethod
    def as_dict(self) -> dict[str, Any]:
        """The kind and the settings of the motion, for JSON."""

    def sample(self, rate: float) -> tuple[Array, Array, Array, Array]:
        """Time (N,) [s] and q [rad|m], v [rad/s|m/s], a [rad/s^2|m/s^2] (N, n) at a rate [Hz], from the start on."""
        if not (math.isfinite(rate) and rate > 0) or self.duration * rate > MAX_SAMPLES:
            raise InputError(
                f"rate is {rate} Hz for {self.duration:g} s, expected a positive rate that gives at most {MAX_SAMPLES} samples"
            )
        time = np.arange(math.floor(self.duration * rate + 1e-6) + 1) / rate
        states = self.states(time)
        return time, states.q, states.v, states.a

    def evenly(self, count: int) -> Signals:
        """The states at ``count`` even instants from start to end, with their rate, which effects of a torsion need."""
        states = self.states(np.linspace(0.0, self.duration, count))
        return replace(states, rate=(count - 1) / self.duration)

    def violations(self, robot: Robot) -> list[str]:
        """One sentence for each limit of the robot that the motion violates: the joint, the value reached and the limit."""
        if self.n != robot.n:
            return [f"the motion has {self.n} joints, but robot {robot.name} has {robot.n}"]
        extent = self.extent()
        acceleration_limit = robot.acceleration_limit or (math.inf,) * robot.n
        broken = []
        for j in range(robot.n):
            unit = "m" if robot.joints[j].kind == "prismatic" else "rad"
            slack = LIMIT_TOLERANCE * max(1.0, extent.upper[j] - extent.lower[j])
            low, high = extent.lower[j], extent.upper[j]
            if low < robot.lower[j] - slack or high > robot.upper[j] + slack:
                broken.append(
                    f"joint {j + 1} goes from {low:.4g} to {high:.4g} {unit}, allowed is {robot.lower[j]:.4g} to {robot.upper[j]:.4g} {unit}"
                )
            for article, name, per, reached, limit in (
                ("a", "speed", "s", extent.speed[j], robot.velocity_limit[j]),
                ("an", "acceleration", "s^2", extent.acceleration[j], acceleration_limit[j]),
            ):
                if reached > limit * (1 + LIMIT_TOLERANCE):
                    broken.append(
                        f"joint {j + 1} reaches {article} {name} of {reached:.4g} {unit}/{per}, allowed is {limit:.4g}"
                    )
        return broken

    def save(self, path: str | Path) -> None:
        """Write the motion as JSON (schema physident.trajectory/1), whole or not at all."""
        write_json(path, {"schema": SCHEMA, **self.as_dict()})

    def write_csv(self, path: str | Path, rate: float) -> None:
        """Write a table ``time,q_1..,dq_1..,ddq_1..`` at a rate [Hz], for a robot's controller."""
        table = np.column_stack(self.sample(rate))
        joints = range(1, self.n + 1)
        names = ["time", *(f"{channel}_{j}" for channel in ("q", "dq", "ddq") for j in joints)]
        write_with(
            path, lambda file: np.savetxt(file, table, "%.10g", delimiter=",", header=",".join(names), comments="")
        )


def checked(name: str, values: Any, shape: tuple[int | None, ...]) -> Array:
    """A read-only array of numbers up to 1e9; raises InputError for another shape, where None means any length."""
    try:
        array = np.array(values, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"trajectory: {name} has a value that is no number, expected an array of numbers") from None
    fits = array.ndim == len(shape) and all(
        size in (None, given) for size, given in zip(shape, array.shape, strict=True)
    )
    if not fits or not array.size:
        expected = ", ".join("any" if s is None else str(s) for s in shape)
        raise InputError(f"trajectory: {name} has shape {array.shape}, expected numbers of shape ({expected})")
    if not (np.abs(array) <= LARGEST).all():
        bad = array[~(np.abs(array) <= LARGEST)][0]
        raise InputError(f"trajectory: {name} contains {bad:g}, expected finite numbers up to {LARGEST:g}")
    array.setflags(write=False)
    return array
