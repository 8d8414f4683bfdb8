"""Instruments of an ordinary arm: when they sample, how finely, with what noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sensors:
    """How a motion becomes rows.

    ``rate`` [Hz]; ``jitter`` [s] is the deviation of the true instants from the written, even clock; ``resolution`` [rad]
    of the encoders; ``velocity`` is "measured" with ``velocity_noise`` [rad/s], "derived" from the recorded positions, or
    "absent"; ``torque_noise`` (6,) [N m] has ``noise_memory`` [s], zero for white noise; ``dropped`` is the share of rows
    that are missing; ``drive_gains`` (6,) [N m/A] turn the torque into currents.
    """

    rate: float = 125.0  # Hz
    jitter: float = 5e-5  # s
    resolution: float = 2 * np.pi / 2**17  # rad
    velocity: Literal["measured", "derived", "absent"] = "measured"
    velocity_noise: float = 2e-3  # rad/s
    torque_noise: tuple[float, ...] = (0.5, 0.6, 0.4, 0.12, 0.1, 0.08)
    noise_memory: float = 0.0  # s
    dropped: float = 0.0  # share
    drive_gains: tuple[float, ...] | None = None

    def instants(self, duration: float, rng: np.random.Generator) -> tuple[Array, Array]:
        """Written times (N,) [s], and the true ones."""
        written = np.arange(int(duration * self.rate + 1e-9) + 1) / self.rate
        true = written + self.jitter * rng.standard_normal(len(written))
        return written, np.clip(true, 0.0, duration)

    def positions(self, q: Array) -> Array:
        """Positions (N, 6) [rad] on the encoders' grid."""
        return q if self.resolution == 0 else np.round(q / self.resolution) * self.resolution

    def velocities(self, time: Array, shown: Array, v: Array, rng: np.random.Generator) -> Array | None:
        """Velocity channel (N, 6) [rad/s] from shown positions and true velocities, or None."""
        noise = self.velocity_noise * rng.standard_normal(v.shape)
        if self.velocity == "absent":
            return None
        return v + noise if self.velocity == "measured" else np.gradient(shown, time, axis=0)

    def noise(self, count: int, rng: np.random.Generator) -> Array:
        """Torque noise (N, 6) [N m]."""
        white = rng.standard_normal((count, 6))
        if self.noise_memory > 0:
            from scipy.signal import lfilter

            keep = np.exp(-1 / (self.rate * self.noise_memory))
            start = keep * rng.standard_normal((1, 6))  # as if it had always been running
            white, _ = lfilter([np.sqrt(1 - keep**2)], [1, -keep], white, axis=0, zi=start)
        return white * np.array(self.torque_noise)

    def kept(self, count: int, rng: np.random.Generator) -> NDArray[np.bool_]:
        """Which rows (N,) arrive."""
        return rng.random(count) >= self.dropped
