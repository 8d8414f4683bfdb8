"""Instruments of an arm, as keyword arguments of a sensor class: their clock, encoders, velocity channel and noise."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def draw(seed: int, load: Array, slides: NDArray[np.bool_]) -> dict[str, Any]:
    """Settings for joints with usual torque ``load`` (n,) [N m or N]; encoders of sliding joints (n,) count tenths."""
    rng = np.random.default_rng([seed, 441])
    unit = np.where(slides, 0.1, 1.0)
    bits = int(rng.integers(15, 20))
    encoder_step = 2 * np.pi / 2**bits * unit
    absent = rng.random() < 0.25
    speed_noise = float(np.exp(rng.uniform(np.log(2e-4), np.log(8e-3)))) * (rng.random() < 0.8)
    # each joint has its own amplifier; a small share of its usual torque, never the same for all
    torque_noise = load * np.exp(rng.uniform(np.log(0.004), np.log(0.035), len(load)))
    return {
        "rate": float(rng.choice([100.0, 120.0, 200.0, 250.0, 400.0, 500.0, 1000.0])),
        "jitter": float(rng.choice([0.0, 2e-5, 1e-4, 3e-4])),
        "dropped": float(rng.choice([0.0, 0.001, 0.015], p=[0.5, 0.3, 0.2])),
        "encoder_step": tuple(encoder_step.tolist()),
        "velocity": "absent" if absent else "measured",
        "velocity_noise": tuple((speed_noise * unit).tolist()),
        "torque_noise": tuple(torque_noise.tolist()),
    }
