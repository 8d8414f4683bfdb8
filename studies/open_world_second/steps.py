"""Motions made of moves: a production program, single jogs, moves that flow into each other, teaching by hand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from studies.open_world_second.laws import LAWS, peaks
from tests.truth import ArmTruth

Array = NDArray[np.float64]
ROOM = 0.96  # share of the range between the limits that the moves use
CREEP = 0.25  # s, the shortest move of a joint


@dataclass(frozen=True, eq=False)
class Steps:
    """Moves that add up: joint j goes ``way`` (P, n) from ``begins`` (P, n) on, within ``lasts`` (P, n) [s].

    ``start`` (n,) is the first pose; ``law`` names the law of each move.
    """

    kind: str
    duration: float
    start: Array
    way: Array
    begins: Array
    lasts: Array
    law: str

    def states(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities, accelerations (N, n) at times (N,) [s]."""
        q = np.tile(self.start, (len(time), 1))
        v, a = np.zeros_like(q), np.zeros_like(q)
        for way, begin, lasts in zip(self.way, self.begins, self.lasts, strict=True):
            for j in np.flatnonzero(way):
                s0, s1, s2 = LAWS[self.law]((time - begin[j]) / lasts[j])
                q[:, j] += way[j] * s0
                v[:, j] += way[j] * s1 / lasts[j]
                a[:, j] += way[j] * s2 / lasts[j] ** 2
        return q, v, a


@dataclass(frozen=True)
class _Manner:
    """How somebody moves an arm: to ``poses`` places (0: new ones all the time), at a share of top speed, with pauses [s].

    ``together``: all joints arrive at once; ``jogs``: so many joints take part in a move (0: all); ``nearby``: share of
    the range that one move covers at most.
    """

    law: str
    pace: tuple[float, float]
    pauses: tuple[float, float]
    poses: int = 0
    together: bool = True
    jogs: int = 0
    nearby: float = 1.0


def program(arm: ArmTruth, seed: int, duration: float) -> Steps:
    """A production program: the same few poses over and over, with waits for grippers and machines."""
    rng = np.random.default_rng([seed, 411])
    manner = _Manner(
        law=str(rng.choice(["brisk", "gentle", "cycloid"])),
        pace=(0.6, 1.0),
        pauses=(0.2, 1.2),
        poses=int(rng.integers(4, 8)),
        together=bool(rng.random() < 0.6),
    )
    return _moves("program", arm, manner, duration, rng)


def errands(arm: ArmTruth, seed: int, duration: float) -> Steps:
    """From one new pose to the next, each joint as fast as it likes, with short pauses."""
    rng = np.random.default_rng([seed, 412])
    manner = _Manner(law=str(rng.choice(list(LAWS))), pace=(0.4, 1.0), pauses=(0.1, 0.8), together=False, nearby=0.7)
    return _moves("errands", arm, manner, duration, rng)


def teaching(arm: ArmTruth, seed: int, duration: float) -> Steps:
    """Slow jogs of one to three joints at a time with irregular pauses, as somebody looks for a pose."""
    rng = np.random.default_rng([seed, 413])
    manner = _Manner(law="least_snap", pace=(0.06, 0.3), pauses=(0.2, 1.8), jogs=3, nearby=0.2)
    return _moves("teaching", arm, manner, duration, rng)


def _moves(kind: str, arm: ArmTruth, manner: _Manner, duration: float, rng: np.random.Generator) -> Steps:
    known = [_pose(arm, rng) for _ in range(manner.poses)]
    now, here = rng.uniform(0.3, 0.8), known[0] if known else _pose(arm, rng)
    start, ways, begins, lasts = here, [], [], []
    rest = 0.3
    while (left := duration - rest - now) > 2 * CREEP:
        target = known[(len(ways) + 1) % len(known)] if known else _next(arm, here, manner, rng)
        way = target - here
        times = _times(way, arm, manner, rng.uniform(*manner.pace))
        if times.max() > left:  # the last move goes as far as the time allows
            way, times = way * (left / times.max()) ** 2, np.minimum(times, left)
        ways.append(way)
        begins.append(np.full(len(way), now))
        lasts.append(times)
        here = here + way
        now += times.max() + rng.uniform(*manner.pauses)
    return Steps(kind, duration, start, np.array(ways), np.array(begins), np.array(lasts), manner.law)


def _times(way: Array, arm: ArmTruth, manner: _Manner, pace: float) -> Array:
    """Time (n,) [s] that each joint takes; at full pace the slowest is at a limit of speed or acceleration."""
    speed, acceleration = peaks(manner.law)
    by_speed = speed * np.abs(way) / (pace * arm.top_speed)
    by_push = np.sqrt(acceleration * np.abs(way) / arm.top_acceleration)
    times = np.maximum(np.maximum(by_speed, by_push), CREEP)
    return np.full(len(way), times.max()) if manner.together else times


def _pose(arm: ArmTruth, rng: np.random.Generator) -> Array:
    middle, half = (arm.lower + arm.upper) / 2, ROOM * (arm.upper - arm.lower) / 2
    return middle + half * rng.uniform(-1, 1, arm.joints)


def _next(arm: ArmTruth, here: Array, manner: _Manner, rng: np.random.Generator) -> Array:
    """The next new pose: nearby, and with few joints moved where the manner says so."""
    way = manner.nearby * (_pose(arm, rng) - here)
    if manner.jogs:
        count = int(rng.integers(1, min(manner.jogs, arm.joints) + 1))
        still = rng.permutation(arm.joints)[count:]
        way[still] = 0.0
    return here + way
