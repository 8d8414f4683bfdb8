"""Instruments: when they sample, how finely, with what noise - and the file that a user gets of a run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from tests.truth import Run

Array = NDArray[np.float64]
Each = float | tuple[float, ...]  # one number for all joints, or one for each


@dataclass(frozen=True, kw_only=True)
class Sensors:
    """How a run becomes the rows of a file.

    ``rate`` [Hz] of the written, even clock; ``jitter`` [s] is the deviation of the true instants from it; ``dropped`` is
    the share of rows that never arrive. ``encoder_step`` [rad|m]; ``velocity`` is "measured", with ``velocity_noise``
    [rad/s|m/s], or "absent"; ``torque_noise`` (n,) [N m|N].
    """

    rate: float = 125.0
    jitter: float = 0.0
    dropped: float = 0.0
    encoder_step: Each = 5e-5
    velocity: Literal["measured", "absent"] = "measured"
    velocity_noise: Each = 1e-3
    torque_noise: tuple[float, ...] = ()

    @property
    def kind(self) -> str:
        """Its velocity channel in a word."""
        if self.velocity == "absent":
            return "absent"
        noise = float(np.max(self.velocity_noise))
        return "clean" if noise == 0 else "noisy" if noise < 3e-3 else "very noisy"

    def write(self, run: Run, seed: int, path: Path) -> None:
        """Write a CSV file with the columns time, q_1.., dq_1.. where velocity is measured, and tau_1..; the seed draws the noise."""
        rng = np.random.default_rng([seed, 13])
        written = np.arange(run.time[0], run.time[-1], 1 / self.rate)
        true = np.clip(written + self.jitter * rng.standard_normal(len(written)), run.time[0], run.time[-1])
        q = CubicHermiteSpline(run.time, run.q, run.v)(true)
        step = np.broadcast_to(self.encoder_step, q.shape[1])
        channels = {"q": np.round(q / step) * step}
        v = _at(true, run.time, run.v) + rng.standard_normal(q.shape) * np.broadcast_to(self.velocity_noise, q.shape[1])
        if self.velocity == "measured":
            channels["dq"] = v
        channels["tau"] = _at(true, run.time, run.torque) + rng.standard_normal(q.shape) * np.array(self.torque_noise)
        kept = rng.random(len(written)) >= self.dropped
        header = ["time", *(f"{name}_{j + 1}" for name in channels for j in range(q.shape[1]))]
        rows = np.column_stack([written, *channels.values()])[kept]
        path.parent.mkdir(parents=True, exist_ok=True)
        text = path.with_suffix(".part")
        np.savetxt(text, rows, "%.8g", ",", header=",".join(header), comments="")
        text.replace(path)


def _at(instants: Array, time: Array, values: Array) -> Array:
    """Values (M, n) between dense rows (N, n); linear, because dry friction jumps."""
    return np.column_stack([np.interp(instants, time, column) for column in values.T])


def draw(seed: int, torque: Array, slides: NDArray[np.bool_]) -> Sensors:
    """Instruments of an arm with RMS torques (n,), finer in metres where a joint slides than in radians where it turns."""
    rng = np.random.default_rng([seed, 17])
    unit = np.where(slides, 0.1, 1.0)
    noise = float(rng.choice((0.0, 1e-3, 5e-3), p=(0.25, 0.45, 0.3)))
    absent = rng.random() < 0.3
    fine = float(np.exp(rng.uniform(np.log(1e-5), np.log(2e-4))))
    rate = float(rng.choice((100.0, 125.0, 200.0, 250.0, 500.0, 1000.0), p=(0.2, 0.25, 0.15, 0.15, 0.15, 0.1)))
    level = np.exp(rng.uniform(np.log(0.005), np.log(0.03))) * rng.uniform(0.7, 1.4, len(torque))
    return Sensors(
        rate=rate,
        jitter=float(rng.choice((0.0, 5e-5, 2e-4))),
        dropped=float(rng.choice((0.0, 0.002, 0.01), p=(0.6, 0.25, 0.15))),
        encoder_step=tuple(float(x) for x in fine * unit),
        velocity="absent" if absent else "measured",
        velocity_noise=tuple(float(x) for x in noise * unit),
        # a current sensor's noise is white over its own band: the faster it samples, the more of it a row shows
        torque_noise=tuple(float(x) for x in level * np.sqrt(rate / 125.0) * torque),
    )
