"""Trajectory: a finite Fourier series for each joint."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from physident.errors import InputError
from physident.excitation.motion.motion import LARGEST, SCHEMA, Array, Extent, Motion, checked
from physident.excitation.motion.point_to_point import PointToPoint
from physident.excitation.motion.recorded import RecordedMotion
from physident.files import naming, read_json
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

NODES = 400  # for each period of the highest harmonic: the bound of a peak is then at most 3e-5 too large
REST = 1e-9  # rad/s, rad/s^2: below the resolution of any encoder
MAX_FILE = 20_000_000  # bytes
MAX_HARMONICS = 200  # each harmonic costs 400 nodes
FREE_RANGE = math.pi  # rad: the position limit of a joint that states none
FREE_SPEED = math.pi  # rad/s, rad/s^2: the speed and acceleration limits of a joint that states none, as of a UR5


@dataclass(frozen=True, eq=False)
class Trajectory(Motion):
    """q(t) = q0 + sum_l a_l sin(l w t) - b_l cos(l w t) for each joint, w = 2 pi base_frequency, L harmonics.

    ``a``, ``b`` (n, L) [rad|m], ``q0`` (n,) [rad|m], ``base_frequency`` [Hz], ``duration`` [s]. Velocity is
    sum_l l w (a_l cos(l w t) + b_l sin(l w t)), acceleration its derivative. Both are zero at the start and at the end if
    sum_l l a_l = 0, sum_l l^2 b_l = 0 and the duration is a whole number of periods; see ``at_rest`` and ``to_rest``.
    Source: thesis eq. 3.54-3.56 and 3.58, with the sign of the velocity's second term corrected. Raises InputError for
    arrays of different shapes, and for a frequency or a duration that is not positive.
    """

    a: Array
    b: Array
    q0: Array
    base_frequency: float
    duration: float

    kind: ClassVar[str] = "fourier"

    def __post_init__(self) -> None:
        a = checked("a", self.a, (None, None))
        values: dict[str, Any] = {
            "a": a,
            "b": checked("b", self.b, a.shape),
            "q0": checked("q0", self.q0, a.shape[:1]),
        }
        for key in ("base_frequency", "duration"):
            values[key] = checked(key, getattr(self, key), ()).item()
            if values[key] < 1 / LARGEST:
                raise InputError(
                    f"trajectory: {key} is {values[key]:g}, expected a positive number, {1 / LARGEST:g} at least"
                )
        if a.shape[1] > MAX_HARMONICS:
            raise InputError(f"trajectory: {a.shape[1]} harmonics, expected at most {MAX_HARMONICS}")
        for key, value in values.items():
            object.__setattr__(self, key, value)

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.q0)

    @property
    def harmonics(self) -> int:
        """Number L of harmonics."""
        return self.a.shape[1]

    @property
    def at_rest(self) -> bool:
        """Whether velocity and acceleration are zero at the start and at the end."""
        periods = self.duration * self.base_frequency
        start = self.states(np.zeros(1))
        return abs(periods - round(periods)) < 1e-9 and float(max(abs(start.v).max(), abs(start.a).max())) < REST

    def to_rest(self) -> Trajectory:
        """The nearest trajectory at rest at both ends: the smallest change of a and b, and whole periods."""
        order = np.arange(1.0, self.harmonics + 1)
        if self.harmonics < 2:
            raise InputError("trajectory: one harmonic cannot start at rest and move, expected at least two")
        a, b = _without(self.a, order), _without(self.b, order**2)
        periods = max(1, round(self.duration * self.base_frequency))
        return replace(self, a=a, b=b, duration=periods / self.base_frequency)

    def states(self, time: Array) -> Signals:
        """Position, velocity and acceleration at instants (N,) [s]; before the start and after the end the arm stands still
        where it starts and ends."""
        time = np.asarray(time, dtype=float)
        inside = np.clip(time, 0.0, self.duration)
        order = np.arange(1, self.harmonics + 1)
        omega = 2 * math.pi * self.base_frequency * order
        # the phase within the period, so that rest at the end is exact after many periods too
        angle = 2 * math.pi * np.outer(np.mod(self.base_frequency * inside, 1.0), order)
        sine, cosine = np.sin(angle), np.cos(angle)
        q = self.q0 + sine @ self.a.T - cosine @ self.b.T
        v = cosine @ (omega * self.a).T + sine @ (omega * self.b).T
        a = cosine @ (omega**2 * self.b).T - sine @ (omega**2 * self.a).T
        moving = ((time >= 0) & (time <= self.duration))[:, None]
        return Signals(time, q, v * moving, a * moving, source="trajectory")

    def extent(self) -> Extent:
        """Bounds of position, speed and acceleration over a period, which hold between the nodes too.

        A trigonometric polynomial of order L is at most 1 / cos(pi L / N) times its largest value on N equidistant
        nodes; for the positions, about the middle of their range. Source: Ehlich and Zeller, "Schwankung von Polynomen zwischen Gitterpunkten" (1964).
        """
        nodes = NODES * self.harmonics
        period = replace(self, duration=1 / self.base_frequency)
        s = period.states(np.arange(nodes) / nodes * period.duration)
        wide = 1 / math.cos(math.pi / NODES)
        middle, half = (s.q.max(axis=0) + s.q.min(axis=0)) / 2, wide * np.ptp(s.q, axis=0) / 2
        return Extent(middle - half, middle + half, wide * np.abs(s.v).max(axis=0), wide * np.abs(s.a).max(axis=0))

    def as_dict(self) -> dict[str, Any]:
        """The kind and the settings of the motion, for JSON."""
        arrays = {key: getattr(self, key).tolist() for key in ("a", "b", "q0")}
        return {"kind": self.kind, "base_frequency": self.base_frequency, "duration": self.duration, **arrays}

    def __repr__(self) -> str:
        extent = self.extent()
        periods = self.duration * self.base_frequency
        rest = "starts and ends at rest" if self.at_rest else "does NOT start and end at rest"
        rows = [
            f"Trajectory: {self.n} joints, {self.harmonics} harmonics of {self.base_frequency:g} Hz, {self.duration:g} s ({periods:g} periods)",
            "  joint   from [rad]   to [rad]   speed [rad/s]   acceleration [rad/s^2]",
        ]
        columns = zip(extent.lower, extent.upper, extent.speed, extent.acceleration, strict=True)
        rows += [f"  {j:>5}   {a:10.3f} {b:10.3f} {c:15.3f} {d:24.3f}" for j, (a, b, c, d) in enumerate(columns, 1)]
        return "\n".join([*rows, f"  It {rest}."])


def random_trajectory(
    robot: Robot,
    seed: int,
    harmonics: int = 5,
    base_frequency: float = 0.1,
    duration: float | None = None,
    scale: float = 0.8,
) -> Trajectory:
    """A random trajectory at rest at both ends, inside the robot's limits of position, speed and acceleration.

    Each joint is scaled until it reaches ``scale`` (0 to 1) of the first of its limits; a joint without limits gets +-pi
    rad, pi rad/s, pi rad/s^2. ``duration`` [s] is a whole number of periods, one by default. Raises InputError for fewer
    than two harmonics, a scale outside (0, 1], and a duration that is no whole number of periods.
    """
    if not 0 < scale <= 1:
        raise InputError(f"scale is {scale}, expected a share of the limits, above 0 and at most 1")
    if not isinstance(harmonics, int) or not 2 <= harmonics <= 100:
        raise InputError(f"harmonics is {harmonics}, expected a whole number from 2 to 100")
    if not (math.isfinite(base_frequency) and base_frequency > 0):
        raise InputError(f"base_frequency is {base_frequency} Hz, expected a positive number")
    length = 1 / base_frequency if duration is None else duration
    periods = length * base_frequency
    if not (math.isfinite(periods) and round(periods) >= 1 and abs(periods - round(periods)) < 1e-6):
        raise InputError(f"duration is {length:g} s, expected a whole number of periods of {1 / base_frequency:g} s")
    rng = np.random.default_rng(seed)
    order = np.arange(1, harmonics + 1)
    a, b = rng.standard_normal((2, robot.n, harmonics)) / order
    shape = Trajectory(a, b, np.zeros(robot.n), base_frequency, round(periods) / base_frequency).to_rest()
    extent = shape.extent()
    lower, upper = np.maximum(robot.lower, -FREE_RANGE), np.minimum(robot.upper, FREE_RANGE)
    # limits that lie beyond half a turn altogether are used as they are
    lower, upper = np.where(lower < upper, [lower, upper], [robot.lower, robot.upper])
    speed = np.minimum(robot.velocity_limit, FREE_SPEED)
    acceleration = robot.acceleration_limit or (FREE_SPEED,) * robot.n
    acceleration = np.where(np.isfinite(acceleration), acceleration, FREE_SPEED)
    factor = scale * np.minimum.reduce(
        [
            (upper - lower) / (extent.upper - extent.lower),
            speed / extent.speed,
            acceleration / extent.acceleration,
        ]
    )
    room = (upper - lower) - factor * (extent.upper - extent.lower)
    q0 = lower + rng.uniform(size=robot.n) * room - factor * extent.lower
    return replace(shape, a=factor[:, None] * shape.a, b=factor[:, None] * shape.b, q0=q0)


def load_trajectory(path: str | Path) -> Motion:
    """The motion in a trajectory file (schema physident.trajectory/1): a Fourier series, point-to-point moves, or the motion of a recording.

    Raises InputError for a file that is missing, no JSON, of another schema or incomplete.
    """
    data = read_json(path, MAX_FILE, "a trajectory file", SCHEMA)
    kinds: dict[Any, type[Motion]] = {kind.kind: kind for kind in (Trajectory, PointToPoint, RecordedMotion)}
    kind = data.get("kind", Trajectory.kind)
    if not isinstance(kind, str) or kind not in kinds:
        raise InputError(f"{path}: kind is {kind!r}, expected one of {', '.join(kinds)}")
    with naming(path, "trajectory", "write it again"):
        return kinds[kind](**{key: value for key, value in data.items() if key not in ("schema", "kind")})


def _without(values: Array, direction: Array) -> Array:
    """Rows (n, L) without their component along a direction (L,)."""
    return values - np.outer(values @ direction, direction) / float(direction @ direction)
