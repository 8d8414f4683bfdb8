"""Physics that is in every recording of an arm, before and after, and in no catalogue: two to ten per cent of its torque."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from studies.open_world.scale import States, friction_torque, prismatic, rigid_torque, rms
from tests.truth import ArmTruth, Disturbance

Array = NDArray[np.float64]
SHARE = (0.02, 0.10)  # of each joint's RMS torque, all kinds together
Rng = np.random.Generator


@dataclass(frozen=True, eq=False)
class Cable(Disturbance):
    """A cable bundle that pulls once a joint and its neighbour have wound it up beyond some angle.

    ``size`` (n,) [N m]; the bundle of each joint sees q + ``share`` times the neighbour's q, is slack around ``middle`` [rad] and
    bends from slack to taut within ``bend`` [rad] on the one side and twice that on the other.
    """

    size: Array
    neighbour: NDArray[np.intp]
    share: Array
    middle: Array
    slack: Array
    bend: Array

    def resist(self, time: float, q: Array, v: Array) -> Array:
        """Torque (n,) [N m]."""
        at, torque = q.tolist(), []
        for own, (size, k, share, middle, slack, bend) in zip(at, self._rows, strict=True):
            x = own + share * at[k] - middle
            torque.append(size * (_beyond((x - slack) / bend) - 2 * _beyond(-(x + slack) / (2 * bend))))
        return np.array(torque)

    @cached_property
    def _rows(self) -> list[tuple[float, int, float, float, float, float]]:
        """The fields joint by joint: this is asked at every step, and plain numbers are quicker than short arrays."""
        fields = (self.size, self.neighbour, self.share, self.middle, self.slack, self.bend)
        return list(zip(*(field.tolist() for field in fields), strict=True))


@dataclass(frozen=True, eq=False)
class Cogging(Disturbance):
    """Ripple over the angle whose phase wanders with the angle and, slowly, with time, so that it is no clean line.

    ``size`` (n,) [N m], ``order`` [1/rad], ``phase`` [rad]; the phase wanders by ``wander`` [rad] over about a turn.
    """

    size: Array
    order: Array
    phase: Array
    wander: Array
    pitch: Array
    period: float

    def resist(self, time: float, q: Array, v: Array) -> Array:
        """Torque (n,) [N m]."""
        turn = 2 * math.pi * time / self.period
        return np.array(
            [
                size * math.sin(order * x + phase + wander * math.sin(pitch * x + turn + 3 * phase))
                for x, (size, order, phase, wander, pitch) in zip(q.tolist(), self._rows, strict=True)
            ]
        )

    @cached_property
    def _rows(self) -> list[tuple[float, float, float, float, float]]:
        """The fields joint by joint."""
        fields = (self.size, self.order, self.phase, self.wander, self.pitch)
        return list(zip(*(field.tolist() for field in fields), strict=True))


@dataclass(frozen=True, eq=False)
class CrossTalk(Disturbance):
    """Each reported torque holds a little of the others': ``size`` (n,) times a ``mixing`` matrix (n, n) without diagonal."""

    size: Array
    mixing: Array

    def report(self, time: Array, q: Array, v: Array, torque: Array) -> Array:
        """Reported torque (N, n) [N m]."""
        return torque + (torque @ self.mixing.T) * self.size


@dataclass(frozen=True, eq=False)
class BentFriction(Disturbance):
    """Drag that rises with velocity, has a hump at ``speed`` (n,) [rad/s] and falls again: ``size`` (n,) [N m] at the hump.

    The hump of a worn joint leans: it is ``lean`` times higher in one direction.
    """

    size: Array
    speed: Array
    lean: Array

    def resist(self, time: float, q: Array, v: Array) -> Array:
        """Torque (n,) [N m]."""
        torque = []
        for speed, (size, hump, lean) in zip(v.tolist(), self._rows, strict=True):
            x = speed / hump
            torque.append(size * 2 * x / (1 + x * x) * (1 + lean * x / (1 + abs(x))))
        return np.array(torque)

    @cached_property
    def _rows(self) -> list[tuple[float, float, float]]:
        """The fields joint by joint."""
        return list(zip(self.size.tolist(), self.speed.tolist(), self.lean.tolist(), strict=True))


def _beyond(x: float) -> float:
    """Zero far below zero, x far above it, and bent between: log(1 + exp x)."""
    return max(x, 0.0) + math.log1p(math.exp(-abs(x)))


KINDS = ("cable", "cogging", "cross_talk", "bent_friction")


def draw(arm: ArmTruth, states: States, rng: Rng) -> tuple[Disturbance, ...]:
    """One to three kinds, scaled so that together they have the drawn share of each joint's RMS torque along states."""
    count = int(rng.integers(1, 4))
    share = rng.uniform(*SHARE, arm.joints) / np.sqrt(count)
    torque = rigid_torque(arm, states) + friction_torque(arm, states)
    result = []
    for name in rng.permutation(KINDS)[:count]:
        unit = _unit(name, arm, states, rng)
        alone = _added(unit, states, torque)
        alone = alone - alone.mean(axis=0)  # a constant is an offset, which every model has
        factor = share * rms(torque) / np.maximum(rms(alone), 1e-9 * rms(torque))
        result.append(replace(unit, size=unit.size * factor))
    return tuple(result)


def share_of(arm: ArmTruth, states: States) -> Array:
    """RMS (n,) of an arm's background along states, over the RMS torque; for a look at what was drawn."""
    torque = rigid_torque(arm, states) + friction_torque(arm, states)
    total = sum((_added(one, states, torque) for one in arm.background), np.zeros_like(torque))
    return rms(total - total.mean(axis=0)) / rms(torque)


def _added(one: Disturbance, states: States, torque: Array) -> Array:
    """What a disturbance adds to the reported torque (N, n) along states that are followed all the same."""
    resisted = [one.resist(t, q, v) for t, q, v in zip(states.time, states.q, states.v, strict=True)]
    added = np.zeros_like(torque) if resisted[0] is None else np.array(resisted, dtype=float)
    return one.report(states.time, states.q, states.v, torque + added) - torque


def _unit(name: str, arm: ArmTruth, states: States, rng: Rng) -> Cable | Cogging | CrossTalk | BentFriction:
    """A kind of background of size one at every joint."""
    n, slides = arm.joints, prismatic(arm.urdf)
    ones, room = np.ones(n), arm.upper - arm.lower
    if name == "cable":
        neighbour = np.array([j - 1 if j else min(1, n - 1) for j in range(n)])
        share = rng.uniform(-0.4, 0.4, n) * (slides == slides[neighbour])
        middle = arm.lower + rng.uniform(0.3, 0.7, n) * room
        return Cable(
            ones, neighbour, share, middle, rng.uniform(0.05, 0.25, n) * room, rng.uniform(0.03, 0.12, n) * room
        )
    if name == "cogging":
        length = np.where(slides, 0.05, 1.0)  # m of a spindle for a radian of a joint
        order = rng.uniform(3.3, 30.0, n) / length
        return Cogging(
            ones, order, rng.uniform(0, 2 * np.pi, n), rng.uniform(0.8, 2.5, n), rng.uniform(0.5, 1.4, n) / length,
            float(rng.uniform(25.0, 90.0)),
        )  # fmt: skip
    if name == "cross_talk":
        mixing = rng.standard_normal((n, n))
        np.fill_diagonal(mixing, 0.0)
        return CrossTalk(ones, mixing)
    return BentFriction(ones, rms(states.v) * rng.uniform(0.3, 1.2, n), rng.uniform(-0.4, 0.4, n))
