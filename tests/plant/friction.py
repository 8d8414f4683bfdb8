"""Friction of the joints: what the drives must overcome, by speed, load, distance, time and each other's motion."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tests.plant.laws import Law, Smooth

Array = NDArray[np.float64]
COULOMB = (8.0, 9.0, 7.5, 1.4, 2.0, 2.0)  # N m, an ordinary UR5
LEAST = 1e-9  # N m: effects that let friction fall never leave less, for bristles divide by it
VISCOUS = (9.0, 9.0, 7.0, 1.5, 1.5, 1.5)  # N m s/rad


def _zeros() -> Array:
    return np.zeros(6)


@dataclass(frozen=True)
class Coupling:
    """Friction of the summed motion of two joints (indices from 0), felt by both: ``coulomb`` [N m], ``viscous``
    [N m s/rad]."""

    first: int
    second: int
    coulomb: float
    viscous: float


@dataclass(frozen=True, eq=False)
class Friction:
    """Friction of n joints, each field (n,), by default of a UR5; positive values oppose the motion.

    tau = w ((coulomb + onset exp(-|v|/onset_speed)) sgn v + viscous v) + asymmetry |v|
    + stribeck sgn v exp(-(v/stribeck_speed)^2) + power sgn v |v|^exponent + load_dependent sgn v |tau_load|
    + stiffness z + couplings, with dz/dt = v - |v| z/slip, which levels off at stiffness * slip [N m], and the warm-up
    w = 1 + warmth exp(-t/warm_time), or 1 + warmth_per_degree (temperature - the arm's first one).
    ``law`` says what sgn v is near zero speed. Its *elements* are the n joints, then the coupled pairs.
    """

    viscous: Array = field(default_factory=lambda: np.array(VISCOUS))
    coulomb: Array = field(default_factory=lambda: np.array(COULOMB))
    asymmetry: Array = field(default_factory=_zeros)  # N m s/rad
    stribeck: Array = field(default_factory=_zeros)  # N m
    stribeck_speed: float = 0.05  # rad/s
    power: Array = field(default_factory=_zeros)  # N m (s/rad)^exponent
    exponent: float = 0.5  # -
    load_dependent: Array = field(default_factory=_zeros)  # -
    stiffness: Array = field(default_factory=_zeros)  # N m/rad
    slip: float = 0.01  # rad
    warmth: Array = field(default_factory=_zeros)  # -
    warm_time: float = 10.0  # s
    warmth_per_degree: Array = field(default_factory=_zeros)  # 1/K
    couplings: tuple[Coupling, ...] = ()
    onset: Array = field(default_factory=_zeros)  # N m: breakaway less Coulomb friction
    onset_speed: Array = field(default_factory=lambda: np.full(6, 0.02))  # rad/s
    law: Law = field(default_factory=Smooth)

    @cached_property
    def acts(self) -> dict[str, bool]:
        """Which kinds are there at all, so that the others cost nothing."""
        names = (
            "asymmetry",
            "stribeck",
            "power",
            "load_dependent",
            "stiffness",
            "warmth",
            "warmth_per_degree",
            "onset",
        )
        return {name: bool(getattr(self, name).any()) for name in names} | {"couplings": bool(self.couplings)}

    @cached_property
    def elements(self) -> Array:
        """(m, n): which joints' motions each element adds."""
        rows = np.eye(len(self.coulomb))
        return np.vstack([rows, *(rows[[pair.first]] + rows[[pair.second]] for pair in self.couplings)])

    def warm(self, time: Array, temperature: Array) -> Array:
        """Factor (N, n) on Coulomb and viscous friction at times (N,) [s] and temperatures (N, n) [degC]."""
        fading = self.warmth * np.exp(-time[:, None] / self.warm_time)
        return 1.0 + fading + self.warmth_per_degree * (temperature - temperature[:1])

    def level(self, u: Array, warm: Array) -> Array:
        """What multiplies sgn u, without load (..., m) [N m], at speeds (..., m) and warm-up factors (..., n)."""
        acts = self.acts
        v = u[..., : len(self.coulomb)]
        total = self.coulomb if not acts["onset"] else self.coulomb + self.onset * np.exp(-np.abs(v) / self.onset_speed)
        total = warm * total
        if acts["stribeck"]:
            total = total + self.stribeck * np.exp(-((v / self.stribeck_speed) ** 2))
        if acts["power"]:
            total = total + self.power * np.abs(v) ** self.exponent
        if not isinstance(self.law, Smooth):
            total = np.maximum(total, LEAST)
        if not acts["couplings"]:
            return total
        shape = u.shape[:-1]
        total = np.broadcast_to(total, v.shape)
        return np.concatenate([total, np.broadcast_to(self.pairs[0], (*shape, len(self.couplings)))], axis=-1)

    def wet(self, v: Array, warm: Array) -> Array:
        """What has no sgn v (..., n) [N m]."""
        total = warm * self.viscous * v
        if self.acts["asymmetry"]:
            total = total + self.asymmetry * np.abs(v)
        if self.acts["couplings"]:
            sums = self.elements[len(self.coulomb) :]
            total = total + (self.pairs[1] * (v @ sums.T)) @ sums
        return total

    @cached_property
    def wet_slope(self) -> Array:
        """(n, n) [N m s/rad]: how viscous friction rises with speed, near enough for an implicit step."""
        sums = self.elements[len(self.coulomb) :]
        return np.diag(self.viscous) + sums.T @ (self.pairs[1][:, None] * sums)

    @cached_property
    def pairs(self) -> tuple[Array, Array]:
        """Coulomb [N m] and viscous [N m s/rad] friction of the coupled pairs."""
        return np.array([p.coulomb for p in self.couplings]), np.array([p.viscous for p in self.couplings])
