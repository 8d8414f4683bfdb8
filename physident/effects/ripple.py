"""Torque that repeats with a joint's angle: cogging of the motor, teeth and wave generator of the gear."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.effects.effect import Array, Column, Effect, Shape
from physident.recordings.signals import Signals
from physident.robots.robot import Robot


@dataclass(frozen=True)
class TorqueRipple(Effect):
    """tau_j = A_j sin(k q_j) + B_j cos(k q_j), k the ``order`` in periods for each turn of the joint; A, B in N m.

    Whole orders come from the joint's side (1 to 40); a motor turns G times as fast, a harmonic drive's wave generator
    twice that: orders G and 2 G. At velocity v the ripple is at k v / 2 pi Hz, which the filter must let pass.
    """

    order: tuple[float, ...] | None = None

    name: ClassVar[str] = "torque_ripple"
    unit: ClassVar[str] = "N m"
    shapes: ClassVar = (Shape("order", "1", tuple(float(k) for k in range(1, 41)), discrete=True),)
    signature: ClassVar[str] = "a line in the order spectrum"
    rivals: ClassVar[str] = "aliasing: its frequency does not follow k v / 2 pi"

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        return tuple(
            Column(f"{self.name}_{kind}_{j + 1}", self.unit, j + 1, self.name)
            for j in self.active(robot)
            for kind in ("sin", "cos")
        )

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        rows = np.repeat(self.active(robot), 2)
        return np.column_stack([rows, np.arange(len(rows))]).astype(np.intp)

    def values(self, robot: Robot, signals: Signals) -> Array:
        angle = self.shape(robot, "order")[:, None] * signals.q.T[self.active(robot)]
        return np.stack([np.sin(angle), np.cos(angle)], axis=1).reshape(-1, len(signals.time))

    def cutoff_needed(self, robot: Robot, signals: Signals) -> float:
        fastest = np.abs(signals.v[:, self.active(robot)]).max(axis=0, initial=0.0)
        return float((self.shape(robot, "order") * fastest).max(initial=0.0) / (2 * np.pi))
