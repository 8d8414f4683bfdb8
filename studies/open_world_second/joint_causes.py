"""Causes at one joint that no catalogue names: parts that are worn, rub, or give way slowly. Joints count from 0 here."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from tests.truth import Disturbance

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class JointCause(Disturbance):
    """Torque at ``joint`` in proportion to ``size``; a subclass writes it for one instant."""

    joint: int
    size: float

    def unit(self, time: float, q: float, v: float) -> float:
        """Torque [N m] at size 1, position [rad] and speed [rad/s] of the joint."""
        raise NotImplementedError

    def resist(self, time: float, q: Array, v: Array) -> Array:
        torque = np.zeros(len(q))
        torque[self.joint] = self.size * self.unit(time, float(q[self.joint]), float(v[self.joint]))
        return torque


@dataclass(frozen=True, kw_only=True)
class RubberStop(JointCause):
    """A bumper mounted too early: stiffness ``size`` [N m/rad] beyond ``edge`` [rad], on the ``side`` +1 or -1."""

    edge: float
    side: float
    rounding: float

    def unit(self, time: float, q: float, v: float) -> float:
        past = self.side * (q - self.edge)
        return self.side * (past + np.hypot(past, self.rounding)) / 2


@dataclass(frozen=True, kw_only=True)
class ChippedTooth(JointCause):
    """A tooth that climbs and falls, ``size`` [N m] at most, ``wide`` [rad], met again every ``pitch`` [rad]."""

    at: float
    wide: float
    pitch: float

    def unit(self, time: float, q: float, v: float) -> float:
        away = (q - self.at) - self.pitch * np.round((q - self.at) / self.pitch)
        x = away / self.wide
        return float(x * np.exp(0.5 - x * x / 2))


@dataclass(frozen=True, kw_only=True)
class ResonantSpeed(JointCause):
    """A cover that rattles at one speed and takes power there: drag ``size`` [N m] around ``critical`` [rad/s]."""

    critical: float
    wide: float

    def unit(self, time: float, q: float, v: float) -> float:
        x = (abs(v) - self.critical) / self.wide
        return float(v / self.critical * np.exp(-x * x))


@dataclass(frozen=True, kw_only=True)
class DraggingBrake(JointCause):
    """A brake that closes a little now and then, more at one angle of its disc than at another.

    ``size`` [N m]; it drags for about half of each ``period`` [s] from ``phase`` [rad] on; ``slow`` [rad/s] is the speed
    from which it drags fully.
    """

    period: float
    phase: float
    slow: float
    per_turn: float

    def unit(self, time: float, q: float, v: float) -> float:
        closed = 1 / (1 + np.exp(-8 * np.sin(2 * np.pi * time / self.period + self.phase)))
        disc = 1 + 0.5 * np.sin(self.per_turn * q + self.phase)
        return float(closed * disc * v / np.hypot(v, self.slow))


@dataclass(frozen=True, kw_only=True)
class RelaxingSeal(Disturbance):
    """A rubber seal that resists like a spring of ``size`` [N m/rad] and yields within ``memory`` [s].

    It depends on the past, so it acts as what the drive must report along the motion, not on the motion itself.
    """

    joint: int
    size: float
    memory: float

    def report(self, time: Array, q: Array, v: Array, torque: Array) -> Array:
        step = float(time[1] - time[0])
        keep = np.exp(-step / self.memory)
        moved = np.diff(q[:, self.joint], prepend=q[0, self.joint])
        strain = lfilter([(1 + keep) / 2], [1.0, -keep], moved)
        seen = torque.copy()
        seen[:, self.joint] += self.size * np.asarray(strain)
        return seen
