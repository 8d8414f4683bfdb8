"""Friction of the joints: what the drives must overcome, by speed, load, distance, time and each other's motion."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SMOOTHING = 0.01  # rad/s: sgn v = tanh(v / SMOOTHING)
COULOMB = (8.0, 9.0, 7.5, 1.4, 2.0, 2.0)  # N m, an ordinary UR5
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
    """Friction of six joints, each field (6,); positive values oppose the motion.

    tau = w (coulomb sgn v + viscous v) + asymmetry |v| + stribeck sgn v exp(-(v/stribeck_speed)^2)
    + power sgn v |v|^exponent + load_dependent sgn v |tau_load| + stiffness z + couplings, with
    dz/dt = v - |v| z/slip, which levels off at stiffness * slip [N m], and the warm-up
    w = 1 + warmth exp(-t/warm_time), or 1 + warmth_per_degree (temperature - the arm's first one).
    """

    viscous: Array = field(default_factory=lambda: np.array(VISCOUS))
    coulomb: Array = field(default_factory=lambda: np.array(COULOMB))
    asymmetry: Array = field(default_factory=_zeros)  # N m s/rad
    stribeck: Array = field(default_factory=_zeros)  # N m
    stribeck_speed: float = 0.05  # rad/s
    power: Array = field(default_factory=_zeros)  # N m (s/rad)^exponent
    exponent: float = 0.5
    load_dependent: Array = field(default_factory=_zeros)  # -
    stiffness: Array = field(default_factory=_zeros)  # N m/rad
    slip: float = 0.01  # rad
    warmth: Array = field(default_factory=_zeros)  # -
    warm_time: float = 10.0  # s
    warmth_per_degree: Array = field(default_factory=_zeros)  # 1/K
    couplings: tuple[Coupling, ...] = ()

    @cached_property
    def acts(self) -> dict[str, bool]:
        """Which kinds are there at all, so that the others cost nothing."""
        names = ("asymmetry", "stribeck", "power", "load_dependent", "stiffness", "warmth", "warmth_per_degree")
        return {name: bool(getattr(self, name).any()) for name in names} | {"couplings": bool(self.couplings)}

    @cached_property
    def sums(self) -> Array:
        """(pairs, 6): which joints' motions each coupling adds."""
        sums = np.zeros((len(self.couplings), 6))
        for row, pair in zip(sums, self.couplings, strict=True):
            row[[pair.first, pair.second]] = 1.0
        return sums

    def warm(self, time: Array, temperature: Array) -> Array:
        """Factor (N, 6) on Coulomb and viscous friction at times (N,) [s] and temperatures (N, 6) [degC]."""
        fading = self.warmth * np.exp(-time[:, None] / self.warm_time)
        return 1.0 + fading + self.warmth_per_degree * (temperature - temperature[:1])

    def dry(self, v: Array, warm: Array) -> Array:
        """What multiplies sgn v, without load (..., 6) [N m]."""
        total = warm * self.coulomb
        if self.acts["stribeck"]:
            total = total + self.stribeck * np.exp(-((v / self.stribeck_speed) ** 2))
        if self.acts["power"]:
            total = total + self.power * np.abs(v) ** self.exponent
        return total

    def wet(self, v: Array, warm: Array) -> Array:
        """What has no sgn v of the joint alone (..., 6) [N m]."""
        total = warm * self.viscous * v
        if self.acts["asymmetry"]:
            total = total + self.asymmetry * np.abs(v)
        if self.acts["couplings"]:
            total = total + self._coupled(v @ self.sums.T)
        return total

    def slope(self, warm: Array, coupled_speed: Array, dry_slope: Array) -> Array:
        """(6, 6) [N m s/rad]: how friction rises with speed at one instant, near enough for an implicit step.

        ``dry_slope`` (6,) is that of sgn v times its factor; ``coupled_speed`` (pairs,) [rad/s].
        """
        slope = np.diag(dry_slope + warm * self.viscous)
        coulomb, viscous = self._pairs
        rise = coulomb * (1 - np.tanh(coupled_speed / SMOOTHING) ** 2) / SMOOTHING + viscous
        return slope + self.sums.T @ (rise[:, None] * self.sums)

    @cached_property
    def _pairs(self) -> tuple[Array, Array]:
        return np.array([p.coulomb for p in self.couplings]), np.array([p.viscous for p in self.couplings])

    def _coupled(self, speed: Array) -> Array:
        coulomb, viscous = self._pairs
        return (coulomb * np.tanh(speed / SMOOTHING) + viscous * speed) @ self.sums
