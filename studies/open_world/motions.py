"""Four kinds of motion that people record: periodic excitation, work from point to point, slow teaching, a poor chirp."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tests.truth import ArmTruth, Motion

Array = NDArray[np.float64]
KINDS = ("fourier", "point_to_point", "teaching", "chirp")
SHARES = (0.35, 0.3, 0.2, 0.15)
REST = 0.4  # s at standstill at both ends
FADE = 2.0  # s in which a periodic motion swells and fades


@dataclass(frozen=True, eq=False)
class Fourier:
    """Harmonics (K, n) of one base ``frequency`` [Hz] about a ``centre`` (n,), swelling from rest and fading to it."""

    duration: float
    frequency: float
    centre: Array
    sine: Array
    cosine: Array
    kind: str = "fourier"

    def states(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities, accelerations (N, n) at times (N,) [s]."""
        rate = 2 * np.pi * self.frequency * np.arange(1, len(self.sine) + 1)
        s, c = np.sin(np.outer(time, rate)), np.cos(np.outer(time, rate))
        swing = (
            s @ self.sine + c @ self.cosine,
            (c * rate) @ self.sine - (s * rate) @ self.cosine,
            -(s * rate**2) @ self.sine - (c * rate**2) @ self.cosine,
        )
        return _about(self.centre, _envelope(time, self.duration), swing)


@dataclass(frozen=True, eq=False)
class Chirp:
    """All joints swing alike, ever faster: one sine from ``low`` to ``high`` [Hz] times an ``amplitude`` (n,)."""

    duration: float
    low: float
    high: float
    centre: Array
    amplitude: Array
    kind: str = "chirp"

    def states(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities, accelerations (N, n) at times (N,) [s]."""
        t = np.clip(time, 0.0, self.duration)
        bend = 2 * np.pi * (self.high - self.low) / self.duration
        rate = 2 * np.pi * self.low + bend * t
        angle = 2 * np.pi * self.low * t + bend * t * t / 2
        s, c = np.sin(angle)[:, None], np.cos(angle)[:, None]
        rate = rate[:, None]
        swing = (s * self.amplitude, c * rate * self.amplitude, (c * bend - s * rate**2) * self.amplitude)
        return _about(self.centre, _envelope(time, self.duration), swing)


@dataclass(frozen=True, eq=False)
class Moves:
    """Moves of single joints with rests between: move m takes ``joint[m]`` by ``way[m]`` from ``begin[m]`` on, for ``lasts[m]`` [s].

    Each has the bell-shaped speed of a fifth-order polynomial; moves of one joint may overlap, as those of a hand do.
    """

    duration: float
    start: Array
    joint: NDArray[np.intp]
    begin: Array
    lasts: Array
    way: Array
    kind: str

    def states(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities, accelerations (N, n) at times (N,) [s]."""
        q = np.tile(self.start, (len(time), 1))
        v, a = np.zeros_like(q), np.zeros_like(q)
        for j, begin, lasts, way in zip(self.joint, self.begin, self.lasts, self.way, strict=True):
            rows = slice(*np.searchsorted(time, (begin, begin + lasts)))
            s, ds, dds = _bell((time[rows] - begin) / lasts)
            q[rows, j] += way * s
            q[rows.stop :, j] += way
            v[rows, j] += way * ds / lasts
            a[rows, j] += way * dds / lasts**2
        return q, v, a


def motion(arm: ArmTruth, seed: int, duration: float) -> Motion:
    """A random motion; ten seeds in a row share its kind and pace, as the recordings of one day do."""
    day = np.random.default_rng([seed // 10, 3])
    kind, pace = str(day.choice(KINDS, p=SHARES)), float(day.uniform(0.6, 1.0))
    rng = np.random.default_rng([seed, 5])
    make = {"fourier": fourier, "point_to_point": point_to_point, "teaching": teaching, "chirp": chirp}[kind]
    return make(arm, rng, duration, pace)


def fourier(arm: ArmTruth, rng: np.random.Generator, duration: float, pace: float) -> Fourier:
    """Five random harmonics of a tenth of a hertz or so, as wide and as fast as the limits and the pace allow."""
    shape = (5, arm.joints)
    weight = 1 / np.arange(1, 6)[:, None] ** 0.7
    trial = Fourier(
        duration, pace * float(rng.uniform(0.08, 0.14)), np.zeros(arm.joints),
        weight * rng.standard_normal(shape), weight * rng.standard_normal(shape),
    )  # fmt: skip
    centre, size = _fitted(arm, trial, rng, pace)
    return Fourier(duration, trial.frequency, centre, trial.sine * size, trial.cosine * size)


def chirp(arm: ArmTruth, rng: np.random.Generator, duration: float, pace: float) -> Chirp:
    """The first motion that comes to mind: it hardly tells the joints apart."""
    low, high = float(rng.uniform(0.04, 0.1)), pace * float(rng.uniform(0.35, 0.7))
    trial = Chirp(duration, low, high, np.zeros(arm.joints), np.ones(arm.joints))
    centre, size = _fitted(arm, trial, rng, pace)
    return Chirp(duration, low, high, centre, size)


def point_to_point(arm: ArmTruth, rng: np.random.Generator, duration: float, pace: float) -> Moves:
    """All joints, or some of them, move to the next random pose, then stand for a third of a second to two."""
    now, here = REST, rng.uniform(arm.lower, arm.upper)
    start, moves = here.copy(), []
    while now < duration - REST - 1.0:
        goal = rng.uniform(arm.lower, arm.upper)
        goal = np.where(rng.random(arm.joints) < 0.8, goal, here)
        lasts = _least_time(arm, goal - here, pace)
        room = duration - REST - now
        if lasts > min(room, duration / 4):
            goal = here + (goal - here) * (min(room, duration / 4) / lasts) ** 2
            lasts = _least_time(arm, goal - here, pace)
        moves += [(j, now, lasts, way) for j, way in enumerate(goal - here) if way]
        now, here = now + lasts + float(rng.uniform(0.3, 2.0)), goal
    return _moves(duration, start, moves, "point_to_point")


def teaching(arm: ArmTruth, rng: np.random.Generator, duration: float, pace: float) -> Moves:
    """Slow and irregular, as by a hand: each joint for itself creeps, hesitates and stops, at a tenth of its speed or so."""
    start = rng.uniform(arm.lower, arm.upper)
    moves = []
    for j in range(arm.joints):
        now, here = REST + float(rng.uniform(0.0, 1.5)), start[j]
        while True:
            lasts = float(rng.uniform(0.6, 2.5))
            if now + lasts > duration - REST:
                break
            speed = arm.top_speed[j] * pace * float(rng.uniform(0.04, 0.3))
            way = float(rng.choice((-1.0, 1.0))) * speed * lasts * 8 / 15
            way = -way if not arm.lower[j] < here + way < arm.upper[j] else way
            way = float(np.clip(here + way, arm.lower[j], arm.upper[j]) - here)
            moves.append((j, now, lasts, way))
            here += way
            # half of the moves blend with the next one, the others end in a stop
            now += lasts * float(rng.uniform(0.6, 0.95)) if rng.random() < 0.5 else lasts + float(rng.uniform(0.1, 1.2))
    return _moves(duration, start, moves, "teaching")


def _moves(duration: float, start: Array, moves: list[tuple[int, float, float, float]], kind: str) -> Moves:
    joint, begin, lasts, way = zip(*moves, strict=True)
    return Moves(duration, start, np.array(joint), np.array(begin), np.array(lasts), np.array(way), kind)


def _fitted(arm: ArmTruth, trial: Motion, rng: np.random.Generator, pace: float) -> tuple[Array, Array]:
    """Centre and size (n,) with which a motion about zero keeps inside the arm's limits."""
    q, v, a = trial.states(np.arange(0.0, trial.duration, 0.01))
    room = arm.upper - arm.lower
    fastest = arm.top_speed * pace * rng.uniform(0.6, 1.0, arm.joints)
    size = np.minimum.reduce(
        [fastest / np.abs(v).max(axis=0), 0.95 * room / np.ptp(q, axis=0), arm.top_acceleration / np.abs(a).max(axis=0)]
    )
    low, high = size * q.min(axis=0), size * q.max(axis=0)
    return arm.lower - low + rng.uniform(0.03, 0.97, arm.joints) * (room - (high - low)), size


def _least_time(arm: ArmTruth, way: Array, pace: float) -> float:
    """Time [s] of a bell-shaped move, whose peaks are 15/8 way/T and 10/sqrt(3) way/T^2."""
    by_speed = 15 / 8 * np.abs(way) / (arm.top_speed * pace)
    by_acceleration = np.sqrt(10 / np.sqrt(3) * np.abs(way) / arm.top_acceleration)
    return float(max(by_speed.max(), by_acceleration.max(), 0.4))


def _bell(x: Array) -> tuple[Array, Array, Array]:
    """10 x^3 - 15 x^4 + 6 x^5 for x from 0 to 1, and its first two derivatives."""
    x = np.clip(x, 0.0, 1.0)
    return x**3 * (10 - 15 * x + 6 * x * x), 30 * (x * (1 - x)) ** 2, 60 * x * (1 - x) * (1 - 2 * x)


def _envelope(time: Array, duration: float) -> tuple[Array, Array, Array]:
    """A factor (N, 1) that rises from zero, stays one and falls to zero, and its derivatives."""
    up, down = _bell((time - REST) / FADE), _bell((duration - REST - time) / FADE)
    w = up[0] * down[0], (up[1] * down[0] - up[0] * down[1]) / FADE
    second = (up[2] * down[0] - 2 * up[1] * down[1] + up[0] * down[2]) / FADE**2
    return w[0][:, None], w[1][:, None], second[:, None]


def _about(centre: Array, w: tuple[Array, Array, Array], s: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
    """States of centre + w s by the product rule."""
    q = centre + w[0] * s[0]
    return q, w[1] * s[0] + w[0] * s[1], w[2] * s[0] + 2 * w[1] * s[1] + w[0] * s[2]
