"""Laws of motion from 0 to 1 in unit time, with rest at both ends: progress and its first two derivatives."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PPoly

Array = NDArray[np.float64]
Law = Callable[[Array], tuple[Array, Array, Array]]


def seven_phases(ramp: float, rounding: float) -> Law:
    """A trapezoid of speed that takes the share ``ramp`` of the time to speed up; ``rounding`` of that is jerk."""
    corner = ramp * rounding / 2
    times = np.array([0, corner, ramp - corner, ramp, 1 - ramp, 1 - ramp + corner, 1 - corner, 1])
    pushes = np.array([0, 1, 1, 0, 0, -1, -1, 0.0])
    slopes = np.diff(pushes) / np.diff(times)
    acceleration = PPoly(np.array([slopes, pushes[:-1]]), times)
    speed = acceleration.antiderivative()
    way = speed.antiderivative()
    total = float(way(1.0))

    def law(x: Array) -> tuple[Array, Array, Array]:
        inside = np.clip(x, 0, 1)
        return way(inside) / total, speed(inside) / total, acceleration(inside) / total

    return law


def cycloid(x: Array) -> tuple[Array, Array, Array]:
    """The cam of machine tools, x - sin(2 pi x) / (2 pi)."""
    x = np.clip(x, 0, 1)
    turn = 2 * np.pi * x
    return x - np.sin(turn) / (2 * np.pi), 1 - np.cos(turn), 2 * np.pi * np.sin(turn)


def least_snap(x: Array) -> tuple[Array, Array, Array]:
    """The polynomial of seventh order with no speed, acceleration or jerk at its ends."""
    x = np.clip(x, 0, 1)
    rest = x * (1 - x)
    return x**4 * (35 + x * (-84 + x * (70 - 20 * x))), 140 * rest**3, 420 * rest**2 * (1 - 2 * x)


LAWS: dict[str, Law] = {
    "brisk": seven_phases(0.2, 0.5),
    "gentle": seven_phases(0.4, 0.95),
    "cycloid": cycloid,
    "least_snap": least_snap,
}


def peaks(name: str) -> tuple[float, float]:
    """Largest speed and acceleration of a law."""
    _, speed, acceleration = LAWS[name](np.linspace(0, 1, 2001))
    return float(np.abs(speed).max()), float(np.abs(acceleration).max())


def window(time: Array, duration: float, rise: float) -> tuple[Array, Array, Array]:
    """Weight (N, 1) that rises from 0 to 1 at the begin and falls at the end, and its derivatives in time [s]."""
    up0, up1, up2 = least_snap(time / rise)
    down0, down1, down2 = least_snap((duration - time) / rise)
    first = (up1 * down0 - up0 * down1) / rise
    second = (up2 * down0 - 2 * up1 * down1 + up0 * down2) / rise**2
    return (up0 * down0)[:, None], first[:, None], second[:, None]
