"""Friction of the gears: it grows with the load they carry, and couples joints whose gears share a shaft."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.effects.effect import Array, Column, Cone, Effect, nonnegative
from physident.effects.friction import smooth_sign
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot


@dataclass(frozen=True)
class LoadDependentFriction(Effect):
    """tau_j = mu_j sgn(v_j) abs(tau_load_j), tau_load the torque of inertia and gravity; mu has no unit. Cone: mu >= 0.

    Source: Hamon, Gautier, Garrec, "Dynamic identification of robots with a dry friction model depending on load and
    velocity" (2010), eq. 6.
    """

    name: ClassVar[str] = "load_dependent_friction"
    unit: ClassVar[str] = "1"
    needs_model: ClassVar[bool] = True
    signature: ClassVar[str] = "grows with load, its sign flips with the velocity"
    rivals: ClassVar[str] = "torque_constant: has no sgn v"

    def values(self, robot: Robot, signals: Signals) -> Array:
        active = self.active(robot)
        return smooth_sign(signals.v.T[active]) * np.abs(signals.from_model("load").T[active])

    def torque_at(self, robot: Robot, signals: Signals, state: Array, load: Array) -> Array:
        active = self.active(robot)
        return smooth_sign(signals.v.T[active]) * np.abs(load.T[active])

    def cones(self, robot: Robot) -> tuple[Cone, ...]:
        return (nonnegative(len(self.active(robot))),)


@dataclass(frozen=True)
class CoupledFriction(Effect):
    """tau_j = tau_k = Fc sgn(v_j + v_k) + Fv (v_j + v_k): a motor that turns two joints rubs on both.

    ``joints`` (j, k) is the pair; None for every pair of neighbours. Fc in N m, Fv in N m s/rad. Source: Gautier and
    Khalil's wrist of the Staubli TX40, "Modeling, Identification and Control of Robots" (2002), sec. 12.
    """

    name: ClassVar[str] = "coupled_friction"
    unit: ClassVar[str] = "N m, N m s/rad"
    signature: ClassVar[str] = "the residual of one joint follows the motion of another"
    rivals: ClassVar[str] = "a joint's own friction: move the two joints one at a time"

    def __post_init__(self) -> None:
        if self.joints is not None and len(set(self.joints)) != 2:
            raise InputError(f"coupled_friction: joints are {self.joints}, expected two different ones, (j, k)")

    def pairs(self, robot: Robot) -> list[tuple[int, int]]:
        """The coupled pairs, as indices from 0."""
        active = self.active(robot)
        if len(active) < 2:
            raise InputError(f"coupled_friction: robot {robot.name} has one joint, expected two that share a motor")
        return [(j, j + 1) for j in active[:-1]] if self.joints is None else [(active[0], active[1])]

    def columns(self, robot: Robot) -> tuple[Column, ...]:
        kinds = (("coulomb", "N m"), ("viscous", "N m s/rad"))
        return tuple(
            Column(f"{self.name}_{kind}_{j + 1}_{k + 1}", unit, j + 1, self.name)
            for j, k in self.pairs(robot)
            for kind, unit in kinds
        )

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        pairs = self.pairs(robot)
        rows = [(row, 2 * p + c) for p, pair in enumerate(pairs) for c in (0, 1) for row in pair]
        return np.array(rows, dtype=np.intp).reshape(-1, 2)

    def values(self, robot: Robot, signals: Signals) -> Array:
        rows = []
        for j, k in self.pairs(robot):
            together = signals.v[:, j] + signals.v[:, k]
            dry = smooth_sign(together)
            rows += [dry, dry, together, together]
        return np.array(rows).reshape(-1, len(signals.time))
