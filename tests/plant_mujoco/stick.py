"""Friction near zero speed over one step, in the form that the step takes: a level, or a line in speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tests.plant_mujoco.friction import Bristle, Friction, bend, saturating

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Sticking:
    """Rows (n,): the ``level`` of dry friction [N m]; else ``force`` + ``slope`` v [N m] at speeds v [rad/s].

    ``bristles`` are those of the law and those of the hidden hysteresis, None where there are none.
    """

    level: Array
    force: Array
    slope: Array
    bristles: tuple[Bristle | None, Bristle | None]

    def at(self, v: Array) -> Array:
        """Friction (n,) [N m] at speeds (n,) [rad/s], dry friction left out."""
        return self.force + self.slope * v

    def bent(self, v: Array) -> Array:
        """Deflections (2, n) [rad] of the bristles after the step."""
        if self.bristles == (None, None):
            return np.zeros((2, len(v)))
        return np.array([np.zeros(len(v)) if b is None else b.kept + b.gained * v for b in self.bristles])


def sticking(law: Friction, guess: Array, load: Array, warm: Array, z: Array, step: float) -> Sticking:
    """Friction about guessed speeds (n,) [rad/s] of joints with bristles bent by z (2, n) [rad], for one step [s]."""
    level = law.level(guess, load, warm)
    force, slope = np.zeros(len(guess)), np.zeros(len(guess))
    own, hidden = None, None
    if law.kind == "smooth":
        line = saturating(level, law.width, np.zeros(len(guess)), guess)
        force, slope = line.force, line.slope
    if law.kind == "bristle":
        rate = law.bristle_stiffness * np.abs(guess) / np.maximum(level, 1e-9)
        own = bend(z[0], rate, step, law.bristle_stiffness, law.bristle_damping)
    if law.hysteretic:
        hidden = bend(z[1], np.abs(guess) / law.slip, step, law.hysteresis, np.zeros(len(guess)))
    for b in (own, hidden):
        if b is not None:
            force, slope = force + b.force, slope + b.slope
    return Sticking(level, force, slope, (own, hidden))
