"""What every arm has and no model mentions. ``size`` (n,) scales each joint's row of a disturbance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from studies.open_world_second.gaps import bridged
from tests.truth import Disturbance

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Background(Disturbance):
    """A disturbance of all joints that grows in proportion to ``size`` (n,)."""

    size: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class DressPack(Background):
    """Hoses along the arm: slack near ``rest`` (n,) [rad] and stiff beyond ``slack`` (n,), bent by the next joint as well.

    ``shared`` (n,) is the part of the next joint's angle that bends the piece of hose over a joint.
    """

    rest: Array
    slack: Array
    shared: Array

    def resist(self, time: float, q: Array, v: Array) -> Array:
        following = np.zeros_like(q)
        following[..., :-1] = q[..., 1:]
        bent = (q + self.shared * following - self.rest) / self.slack
        return self.size * bent**3 / (1 + bent * bent)


@dataclass(frozen=True, kw_only=True, eq=False)
class WanderingCogging(Background):
    """Cogging of ``order`` (n,) per turn whose phase slides to and fro by ``depth`` (n,) [rad] in ``period`` [s]."""

    order: Array
    phase: Array
    depth: Array
    period: float

    def resist(self, time: float, q: Array, v: Array) -> Array:
        slide = self.depth * np.sin(2 * np.pi * time / self.period + self.phase)
        return self.size * np.sin(self.order * q + 2 * self.phase + slide)


@dataclass(frozen=True, kw_only=True, eq=False)
class ThickeningGrease(Background):
    """Drag that rises with speed, is greatest at ``crest`` (n,) [rad/s] and thins out above it by ``thinning`` (n,)."""

    crest: Array
    thinning: Array

    def resist(self, time: float, q: Array, v: Array) -> Array:
        x = v / self.crest
        return self.size * x / (1 + x * x) ** self.thinning


@dataclass(frozen=True, kw_only=True, eq=False)
class UnevenPreload(Background):
    """Bearings that run harder at one angle than at another: drag times 1 + cos(q + ``phase``), for speeds (n,) [rad/s]."""

    phase: Array
    speed: Array
    per_turn: Array

    def resist(self, time: float, q: Array, v: Array) -> Array:
        return self.size * (1 + np.cos(self.per_turn * q + self.phase)) * v / self.speed


@dataclass(frozen=True, kw_only=True, eq=False)
class Crosstalk(Background):
    """Each torque channel hears the others: ``mix`` (n, n) without diagonal, in units of each channel's usual torque."""

    mix: Array
    usual: Array

    def report(self, time: Array, q: Array, v: Array, torque: Array) -> Array:
        return torque + self.size * ((bridged(torque) / self.usual) @ self.mix.T)


@dataclass(frozen=True, kw_only=True, eq=False)
class WanderingZero(Background):
    """Amplifiers whose zero wanders with the air in the room: sines of ``period`` (K, n) [s] and ``phase`` (K, n)."""

    period: Array
    phase: Array

    def report(self, time: Array, q: Array, v: Array, torque: Array) -> Array:
        angle = 2 * np.pi * time[:, None, None] / self.period + self.phase
        return torque + self.size * np.sin(angle).sum(axis=1)


@dataclass(frozen=True, kw_only=True, eq=False)
class RingingFrame(Background):
    """A light structure that rings at ``frequency`` [Hz] with damping ratio ``damping`` when the drives push."""

    frequency: float
    damping: float

    def report(self, time: Array, q: Array, v: Array, torque: Array) -> Array:
        step = time[1] - time[0]
        # bilinear transform with the resonance kept at its frequency
        k = 1 / np.tan(np.pi * self.frequency * step)
        bottom = np.array([k * k + 2 * self.damping * k + 1, 2 - 2 * k * k, k * k - 2 * self.damping * k + 1])
        top = np.array([1.0, 2.0, 1.0])
        whole = bridged(torque)
        moving = whole - whole[:1]
        rung = lfilter(top / bottom[0], bottom / bottom[0], moving, axis=0)
        return torque + self.size * (rung - moving)


@dataclass(frozen=True, kw_only=True, eq=False)
class Breathing(Background):
    """Pneumatics at the tool that switch to and fro: a rounded square wave in time, whose reaction reaches all joints.

    ``period`` [s], ``edge`` is how sharp it switches, ``lever`` (n,) and ``turn`` (n,) [rad] how it acts along positions.
    """

    period: float
    edge: float
    lever: Array
    turn: Array

    def resist(self, time: float, q: Array, v: Array) -> Array:
        state = np.tanh(self.edge * np.sin(2 * np.pi * time / self.period))
        return self.size * state * (self.lever + np.cos(q + self.turn))
