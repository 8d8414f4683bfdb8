"""Random motions inside the arm's limits, at rest at both ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
LOWER = np.array([-2.5, -2.6, -2.2, -2.8, -2.5, -2.8])  # rad: elbow up, away from the floor
UPPER = np.array([2.5, -0.5, 2.2, 2.8, 2.5, 2.8])
TOP_SPEED = 1.5  # rad/s at speed 1; the drives allow pi
TOP_ACCELERATION = np.array([5.0, 5.0, 6.0, 8.0, 8.0, 8.0])  # rad/s^2
REST = 0.25  # s at both ends
RISE = 1.5  # s
SHORTEST_MOVE = 0.5  # s
SINES = 6
FREQUENCIES = (0.05, 0.7)  # Hz


class Motion(Protocol):
    """A plan of six joints over time."""

    @property
    def duration(self) -> float:
        """How long it lasts [s]."""
        ...

    def states(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities, accelerations (N, 6) at times (N,) [s]."""
        ...


@dataclass(frozen=True, eq=False)
class Multisine:
    """q = centre + w(t) sum_k amplitude_k sin(2 pi frequency_k t + phase_k), w rising from and falling to zero.

    ``centre`` (6,) [rad]; ``amplitude`` [rad], ``frequency`` [Hz], ``phase`` [rad] are (K, 6).
    """

    duration: float
    centre: Array
    amplitude: Array
    frequency: Array
    phase: Array

    def states(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities, accelerations (N, 6) at times (N,) [s]."""
        angle = 2 * np.pi * self.frequency * time[:, None, None] + self.phase
        rate = 2 * np.pi * self.frequency
        s0 = (self.amplitude * np.sin(angle)).sum(axis=1)
        s1 = (self.amplitude * rate * np.cos(angle)).sum(axis=1)
        s2 = -(self.amplitude * rate**2 * np.sin(angle)).sum(axis=1)
        up, down = _step((time - REST) / RISE), _step((self.duration - REST - time) / RISE)
        w0 = (up[0] * down[0])[:, None]
        w1 = ((up[1] * down[0] - up[0] * down[1]) / RISE)[:, None]
        w2 = ((up[2] * down[0] - 2 * up[1] * down[1] + up[0] * down[2]) / RISE**2)[:, None]
        return self.centre + w0 * s0, w1 * s0 + w0 * s1, w2 * s0 + 2 * w1 * s1 + w0 * s2


@dataclass(frozen=True, eq=False)
class PointToPoint:
    """All joints move together from point to point (P, 6) [rad] with fifth-order profiles and rest between.

    Move p lasts from ``begins[p]`` to ``ends[p]`` [s] and leads from point p to point p + 1.
    """

    duration: float
    points: Array
    begins: Array
    ends: Array

    def states(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities, accelerations (N, 6) at times (N,) [s]."""
        q = np.tile(self.points[0], (len(time), 1))
        v, a = np.zeros_like(q), np.zeros_like(q)
        for way, begin, end in zip(np.diff(self.points, axis=0), self.begins, self.ends, strict=True):
            s = _step((time - begin) / (end - begin))
            q += s[0][:, None] * way
            v += s[1][:, None] * way / (end - begin)
            a += s[2][:, None] * way / (end - begin) ** 2
        return q, v, a


def multisine(seed: int, speed: float = 1.0, duration: float = 20.0) -> Multisine:
    """Sines of random frequencies, phases and amplitudes for each joint; ``speed`` scales its peak velocity and pace."""
    rng = np.random.default_rng([seed, 1])
    shape = (SINES, 6)
    frequency = rng.uniform(*FREQUENCIES, shape) * speed
    amplitude = rng.uniform(0.3, 1.0, shape) / frequency
    phase = rng.uniform(0, 2 * np.pi, shape)
    peak = TOP_SPEED * speed * rng.uniform(0.6, 1.0, 6)
    trial = Multisine(duration, np.zeros(6), amplitude, frequency, phase)
    q, v, a = trial.states(np.arange(0, duration, 0.01))
    room = UPPER - LOWER
    scale = np.minimum.reduce(
        [peak / np.abs(v).max(axis=0), 0.98 * room / np.ptp(q, axis=0), TOP_ACCELERATION / np.abs(a).max(axis=0)]
    )
    low, high = scale * q.min(axis=0), scale * q.max(axis=0)
    centre = LOWER - low + rng.uniform(0.02, 0.98, 6) * (room - (high - low))
    return Multisine(duration, centre, amplitude * scale, frequency, phase)


def point_to_point(seed: int, speed: float = 1.0, duration: float = 20.0) -> PointToPoint:
    """Moves between random points with short rests; in each the slowest joint is at its limit of speed or acceleration."""
    rng = np.random.default_rng([seed, 2])
    points, begins, ends = [rng.uniform(LOWER, UPPER)], [], []
    now = REST
    while (left := duration - REST - now) > SHORTEST_MOVE:
        way = rng.uniform(LOWER, UPPER) - points[-1]
        longest = min(left, duration / 4)
        if (lasts := _least_time(way, speed)) > longest:
            way = way * (longest / lasts) ** 2
            lasts = _least_time(way, speed)
        points.append(points[-1] + way)
        begins.append(now)
        ends.append(now + lasts)
        now += lasts + rng.uniform(0.1, 0.5)
    return PointToPoint(duration, np.array(points), np.array(begins), np.array(ends))


def _least_time(way: Array, speed: float) -> float:
    """Time [s] of a fifth-order move, whose peaks are 15/8 way/T and 10/sqrt(3) way/T^2."""
    by_speed = 15 / 8 * np.abs(way) / (TOP_SPEED * speed)
    by_acceleration = np.sqrt(10 / np.sqrt(3) * np.abs(way) / TOP_ACCELERATION)
    return float(max(by_speed.max(), by_acceleration.max(), SHORTEST_MOVE))


def _step(x: Array) -> tuple[Array, Array, Array]:
    """10 x^3 - 15 x^4 + 6 x^5 from 0 to 1, and its first two derivatives."""
    x = np.clip(x, 0, 1)
    return x**3 * (10 - 15 * x + 6 * x * x), 30 * x**2 * (1 - x) ** 2, 60 * x * (1 - x) * (1 - 2 * x)
