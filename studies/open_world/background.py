"""Physics that is in every recording of an arm, before and after, and in no catalogue: two to ten per cent of its torque."""

from __future__ import annotations

from dataclasses import dataclass, replace

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
        x = q + self.share * q[self.neighbour] - self.middle
        pulled = np.logaddexp(0.0, (x - self.slack) / self.bend)
        pushed = np.logaddexp(0.0, -(x + self.slack) / (2 * self.bend))
        return self.size * (pulled - 2 * pushed)


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
        drift = np.sin(self.pitch * q + 2 * np.pi * time / self.period + 3 * self.phase)
        return self.size * np.sin(self.order * q + self.phase + self.wander * drift)


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
        x = v / self.speed
        return self.size * 2 * x / (1 + x * x) * (1 + self.lean * x / (1 + np.abs(x)))


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
