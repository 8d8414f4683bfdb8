"""How friction turns over a step: how much of it, and what bristles remember of the way."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tests.plant.forces import Controlled, Forces, State
from tests.plant.friction import LEAST, Friction
from tests.plant.laws import Bristle, Dry, Smooth, carry, path

Array = NDArray[np.float64]


class Turns:
    """The turns of one arm's friction."""

    def __init__(self, arm: Controlled) -> None:
        self.arm, self.friction, self.law = arm, arm.friction, arm.friction.law
        self.even = isinstance(self.law, Dry) and not (self.friction.acts["onset"] or self.friction.acts["stribeck"])
        self.simple = arm.rigid and not arm.friction.couplings  # each element's motion is that of one link
        self.remembers = isinstance(self.law, Bristle) or self.friction.acts["stiffness"]

    def turned(self, row: int, forces: Forces, before: State, *after: State) -> float:
        """The largest change of an element's friction from one state to others, as a share of its level."""
        if self.even:
            return 0.0
        law = self.law
        if isinstance(law, Bristle):
            change = law.stiffness * (np.array([state.z for state in after]) - before.z)
        else:
            u = np.array([state.w for state in after])
            if not self.simple:
                u = u @ self.arm.elements.T
            direction = law.direction(u) if isinstance(law, Smooth) else before.modes
            change = direction * self.friction.level(u, self.arm.warm[row]) - forces.torque
        return float((np.abs(change) / (forces.level + LEAST)).max())

    def remembered(self, row: int, step: float, before: State, after: State) -> State:
        """The state after a row's step with bristles as the rows alone give them, however finely the step was cut: so a
        recorded motion tells its bristles exactly."""
        if not self.remembers:
            return after
        rotor = self.arm.rotor
        q, v = np.array([before.y[rotor], after.y[rotor]]), np.array([before.w[rotor], after.w[rotor]])
        laws, dahl = kept(self.friction, step, q, v, self.arm.warm[row : row + 1])
        z = after.z if laws is None else laws[0][0] * before.z + laws[1][0]
        dahl = after.dahl if dahl is None else dahl[0][0] * before.dahl + dahl[1][0]
        return State(after.y, after.w, z, dahl, after.modes)


Kept = tuple[Array, Array] | None


def kept(friction: Friction, step: float, q: Array, v: Array, warm: Array) -> tuple[Kept, Kept]:
    """What each step of a motion (N, n) does to the deflections of the law's bristles and of the hysteresis: ``keep`` and
    ``gain`` (N-1, ...), None where there are none. ``warm`` (N-1, n) are friction's factors."""
    laws = dahl = None
    if isinstance(friction.law, Bristle):
        distance, speed = path(q @ friction.elements.T, v @ friction.elements.T, step)
        laws = carry(distance, friction.level(speed, warm[:, None]) / friction.law.stiffness)
    if friction.acts["stiffness"]:
        distance, _ = path(q, v, step)
        dahl = carry(distance, np.full_like(distance, friction.slip))
    return laws, dahl
