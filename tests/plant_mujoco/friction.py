"""Friction laws of the joints: the level at which a joint slides, and what happens near zero speed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Friction:
    """All friction of n joints; rows are (n,), in N m and rad (or N and m).

    ``dips`` are further peaks (row, speed) at zero speed, ``powers`` are (row, exponent) terms of |v|, ``load`` is the
    share of the load that is added, ``hysteresis`` [N m/rad] a bristle of its own that yields over ``slip`` [rad].
    """

    kind: Literal["dry", "bristle", "smooth"]
    coulomb: Array
    viscous: Array
    breakaway: Array
    stribeck_speed: Array
    bristle_stiffness: Array
    bristle_damping: Array
    width: Array
    asymmetry: Array
    load: Array
    hysteresis: Array
    slip: Array
    dips: tuple[tuple[Array, float], ...] = ()
    powers: tuple[tuple[Array, float], ...] = ()

    @cached_property
    def loaded(self) -> bool:
        """Whether any friction grows with load."""
        return bool(self.load.any())

    @cached_property
    def hysteretic(self) -> bool:
        """Whether any joint has a hidden bristle."""
        return bool(self.hysteresis.any())

    def level(self, v: Array, load: Array, warm: Array) -> Array:
        """Friction (..., n) [N m] of a joint that slides at v (..., n) [rad/s] under a load [N m], viscous part left out."""
        rare = np.maximum(self.stribeck_speed, 1e-12)
        total = warm * (self.coulomb + (self.breakaway - self.coulomb) / np.cosh(np.clip(v / rare, -700, 700)))
        for row, speed in self.dips:
            total = total + row * np.exp(-np.square(v / speed))
        for row, exponent in self.powers:
            total = total + row * np.abs(v) ** exponent
        if self.loaded:
            total = total + self.load * np.abs(load)
        return np.maximum(total, 0.0)

    def wet(self, v: Array, warm: Array) -> Array:
        """Viscous friction and its difference between directions (..., n) [N m]."""
        return warm * self.viscous * v + self.asymmetry * np.abs(v)


@dataclass(frozen=True, eq=False)
class Linear:
    """Friction (n,) near a speed: ``force`` [N m] at the guessed speed, and its ``slope`` [N m s/rad] there."""

    force: Array
    slope: Array


def saturating(level: Array, width: Array, v: Array, guess: Array) -> Linear:
    """Smooth friction level erf(v/width) at v (n,), by its tangent at the guess (n,)."""
    x = guess / width
    slope = level * (2 / np.sqrt(np.pi)) / width * np.exp(-x * x)
    return Linear(level * erf(x) + slope * (v - guess), slope)


def smooth(level: Array, width: Array, v: Array) -> Array:
    """Smooth friction (..., n) [N m] at v (..., n) [rad/s]."""
    return level * erf(v / width)


@dataclass(frozen=True, eq=False)
class Bristle:
    """Bristles (n,) that bend by dz = v - rate |z|: exact over one step of constant speed.

    Over a step the mean force is ``force`` + ``slope`` v, and the deflection at its end ``kept`` + ``gained`` v.
    """

    force: Array
    slope: Array
    kept: Array
    gained: Array


def bend(z: Array, rate: Array, step: float, stiffness: Array, damping: Array) -> Bristle:
    """Bristles of deflection z (n,) [rad] that relax at a rate (n,) [1/s] for one step [s]."""
    x = np.maximum(rate * step, 1e-12)
    lost = -np.expm1(-x)
    mean = lost / x
    near = x < 1e-3  # the closed form cancels there
    half = np.where(near, 0.5 - x / 6, (1 - mean) / np.where(near, 1.0, x))
    return Bristle(
        z * (stiffness * mean - damping * lost / step),
        stiffness * step * half + damping * mean,
        z * (1 - lost),
        step * mean,
    )
