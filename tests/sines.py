"""Motions that are sums of sines, with their exact derivatives."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def sines(
    rng: np.random.Generator, time: Array, parts: int, joints: int, speeds: tuple[float, float], size: float
) -> tuple[Array, Array, Array]:
    """Position, velocity and acceleration (N, joints): ``parts`` sines for each joint, of an amplitude of ``size`` [rad] and angular frequencies
    drawn from ``speeds`` [rad/s], at random phases."""
    omega, phase = rng.uniform(*speeds, (parts, joints)), rng.uniform(0, 2 * np.pi, (parts, joints))
    angle = time[:, None, None] * omega + phase
    q, v, a = (size * one.sum(axis=1) for one in (np.sin(angle), omega * np.cos(angle), -(omega**2) * np.sin(angle)))
    return q, v, a
