"""Causes between the joint and the file: drives, transducers, gears, clocks and loggers. Joints count from 0 here."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from studies.open_world_second.gaps import bridged
from tests.truth import Disturbance

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class ChannelCause(Disturbance):
    """The reported torque of ``joint`` comes out otherwise, the more the greater ``size``; a subclass says how."""

    joint: int
    size: float

    def shown(self, time: Array, q: Array, torque: Array) -> Array:
        """What is reported (N,) for the true torque (N,) [N m] at times (N,) [s] and positions (N,) [rad]."""
        raise NotImplementedError

    def report(self, time: Array, q: Array, v: Array, torque: Array) -> Array:
        seen = torque.copy()
        whole = bridged(torque[:, [self.joint]])[:, 0]
        changed = self.shown(time, q[:, self.joint], whole)
        seen[:, self.joint] = np.where(np.isnan(torque[:, self.joint]), np.nan, changed)
        return seen


@dataclass(frozen=True, kw_only=True)
class TransducerHysteresis(ChannelCause):
    """A strain gauge whose element slips: its torque follows the true one with a play of ``size`` [N m] to each side."""

    def shown(self, time: Array, q: Array, torque: Array) -> Array:
        followed = np.empty(len(torque))
        at = float(torque[0])
        for i, true in enumerate(torque.tolist()):
            at = min(max(at, true - self.size), true + self.size)
            followed[i] = at
        return followed


@dataclass(frozen=True, kw_only=True)
class GainStep(ChannelCause):
    """A drive that calibrates itself anew at time ``at`` [s]: from then on it reports the share ``size`` more."""

    at: float

    def shown(self, time: Array, q: Array, torque: Array) -> Array:
        return torque * (1 + self.size * (time >= self.at))


@dataclass(frozen=True, kw_only=True)
class EccentricGear(ChannelCause):
    """A gear that sits beside its axis: its ratio, and so the motor's torque, swings by ``size`` over a turn."""

    per_turn: float
    phase: float

    def shown(self, time: Array, q: Array, torque: Array) -> Array:
        return torque * (1 + self.size * np.sin(self.per_turn * q + self.phase))


@dataclass(frozen=True, kw_only=True)
class HotMagnets(ChannelCause):
    """Magnets that weaken with the heat of the current: within ``memory`` [s], by ``size`` where the load is ``usual``."""

    usual: float
    memory: float

    def shown(self, time: Array, q: Array, torque: Array) -> Array:
        keep = np.exp(-float(time[1] - time[0]) / self.memory)
        heat = np.asarray(lfilter([1 - keep], [1.0, -keep], (torque / self.usual) ** 2))
        return torque * (1 + self.size * heat)


@dataclass(frozen=True, kw_only=True)
class CoarseTorque(ChannelCause):
    """A drive that reports its torque in whole steps of ``size`` [N m], a few per cent of its rating."""

    def shown(self, time: Array, q: Array, torque: Array) -> Array:
        return np.round(torque / self.size) * self.size if self.size else torque


@dataclass(frozen=True, kw_only=True)
class SkewedClock(Disturbance):
    """A torque log whose clock runs slow by the share ``size``: what it writes is later and later than the positions."""

    size: float

    def report(self, time: Array, q: Array, v: Array, torque: Array) -> Array:
        past = time - self.size * (time - time[0])
        return np.stack([np.interp(past, time, column) for column in torque.T], axis=1)


@dataclass(frozen=True, kw_only=True)
class FrozenSamples(Disturbance):
    """A busy network: from each of the times ``begins`` [s] on, all torques repeat their last value for ``size`` [s]."""

    begins: tuple[float, ...]
    size: float

    def report(self, time: Array, q: Array, v: Array, torque: Array) -> Array:
        seen = torque.copy()
        for begin in self.begins:
            first = int(np.searchsorted(time, begin))
            after = int(np.searchsorted(time, begin + self.size))
            seen[first:after] = torque[first : first + 1]
        return seen


@dataclass(frozen=True, kw_only=True)
class CoupledDrives(Disturbance):
    """A belt that passes on the share ``size`` of the torque of motor ``source`` to ``joint``."""

    joint: int
    source: int
    size: float

    def deliver(self, time: float, v: Array, torque: Array) -> Array:
        real = torque.copy()
        real[..., self.joint] += self.size * torque[..., self.source]
        return real


@dataclass(frozen=True, kw_only=True)
class SaggingSupply(Disturbance):
    """A weak supply: the drive of ``joint`` delivers up to the share ``size`` less while the arm draws much power.

    Half of that is missing at ``half`` [W]. What a braking joint gives back is burnt and helps no other.
    """

    joint: int
    size: float
    half: float

    def deliver(self, time: float, v: Array, torque: Array) -> Array:
        power = torque * v
        drawn = (power + np.hypot(power, 0.1 * self.half)).sum(axis=-1) / 2
        real = torque.copy()
        real[..., self.joint] *= 1 - self.size * drawn / (drawn + self.half)
        return real
