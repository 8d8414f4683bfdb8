"""The laws of causes outside of the catalogue, as disturbances of a plant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from tests.truth import Disturbance

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GasSpring(Disturbance):
    """A pressurised strut between two anchors, ``ratio`` times as far from the joint as one another: ``size`` (n,) [N m]
    is its force times the shorter distance, ``place`` [rad] where it points at the joint and has no lever."""

    size: Array
    place: float
    ratio: float

    def resist(self, time: float, q: Array, v: Array) -> Array:
        """Torque (n,) [N m]: the force rises a little as the strut is pushed in."""
        x = q - self.place
        length = np.sqrt(1 + self.ratio**2 - 2 * self.ratio * np.cos(x))
        lever = self.ratio * np.sin(x) / length
        return self.size * lever * (1.3 - 0.3 * length / (1 + self.ratio))


@dataclass(frozen=True, eq=False)
class TightSpot(Disturbance):
    """A damaged place of a gear: around ``place`` [rad], within ``width``, it drags with ``size`` (n,) [N m] once the joint
    moves faster than about ``slow`` [rad/s]."""

    size: Array
    place: float
    width: float
    slow: float

    def resist(self, time: float, q: Array, v: Array) -> Array:
        """Torque (n,) [N m]."""
        near = np.exp(((q - self.place) / self.width) ** 2 * -0.5)
        return self.size * near * v / np.sqrt(v * v + self.slow**2)


@dataclass(frozen=True, eq=False)
class CubicCable(Disturbance):
    """A cable that stiffens as it is wound up: ``size`` (n,) [N m/rad^3] times the third power of q - ``place``."""

    size: Array
    place: float

    def resist(self, time: float, q: Array, v: Array) -> Array:
        """Torque (n,) [N m]."""
        return self.size * (q - self.place) ** 3


@dataclass(frozen=True, eq=False)
class SensorLag(Disturbance):
    """The torque sensor of one joint follows slowly: first order, ``size`` (n,) [s]."""

    size: Array

    def report(self, time: Array, q: Array, v: Array, torque: Array) -> Array:
        """Reported torque (N, n) [N m]."""
        shown = torque.copy()
        for j in np.flatnonzero(self.size):
            keep = np.exp(-(time[1] - time[0]) / self.size[j])
            first = [keep * torque[0, j]]
            shown[:, j], _ = lfilter([1 - keep], [1.0, -keep], torque[:, j], zi=first)
        return shown


@dataclass(frozen=True, eq=False)
class DeadBand(Disturbance):
    """The torque channel shows nothing of small torques: ``size`` (n,) [N m] is taken off either side of zero."""

    size: Array

    def report(self, time: Array, q: Array, v: Array, torque: Array) -> Array:
        """Reported torque (N, n) [N m]."""
        return torque - np.clip(torque, -self.size, self.size)


@dataclass(frozen=True, eq=False)
class Saturation(Disturbance):
    """The iron of a motor saturates: what acts levels off at 1/``size`` (n,) [1/(N m)] where more is asked for and reported.

    The ``knee`` is the sharper the larger it is.
    """

    size: Array
    knee: float

    def deliver(self, time: float, v: Array, torque: Array) -> Array:
        """Torque (n,) [N m] that acts."""
        return torque / (1 + np.abs(self.size * torque) ** self.knee) ** (1 / self.knee)


@dataclass(frozen=True, eq=False)
class ChangingCrossTalk(Disturbance):
    """A share ``mixing`` (n, n) of other joints' torques in a reported one that comes and goes with ``period`` [s]."""

    mixing: Array
    period: float
    phase: float

    def report(self, time: Array, q: Array, v: Array, torque: Array) -> Array:
        """Reported torque (N, n) [N m]."""
        strength = np.sin(2 * np.pi * time / self.period + self.phase)
        return torque + strength[:, None] * (torque @ self.mixing.T)


@dataclass(frozen=True, eq=False)
class BackEmf(Disturbance):
    """A drive short of voltage: above ``free`` [rad/s] it gives less than it is asked for, by a share of up to ``size`` (n,)."""

    size: Array
    free: float

    def deliver(self, time: float, v: Array, torque: Array) -> Array:
        """Torque (n,) [N m] that acts; a motor that brakes has voltage enough."""
        excess = np.maximum(np.abs(v) / self.free - 1.0, 0.0)
        return torque * (1 - self.size * (v * torque > 0) * excess / (0.5 + excess))
