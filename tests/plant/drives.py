"""Drives: rotors, gears and the torque they report."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ROTOR_INERTIA = (0.7, 0.7, 0.7, 0.21, 0.21, 0.21)  # kg m^2 at the joint, an ordinary UR5
SPRING_DAMPING_TIME = 1e-3  # s: damping of an elastic gear over its stiffness


def _zeros() -> Array:
    return np.zeros(6)


@dataclass(frozen=True)
class Ripple:
    """Torque amplitude sin(order q + phase) that the drive of one joint (index from 0) must overcome [N m, -, rad]."""

    joint: int
    amplitude: float
    order: float
    phase: float


@dataclass(frozen=True, eq=False)
class Drives:
    """n drives, each field (n,) unless said, by default a UR5's.

    An elastic gear (``compliance`` > 0) is two masses: the rotor, with encoder, friction, ripple and control, and the link,
    joined by a spring 1/compliance with a damper. The reported torque is
    (1 + torque_constant) tau_m(t - delays) + torque_offset.
    """

    rotor_inertia: Array = field(default_factory=lambda: np.array(ROTOR_INERTIA))  # kg m^2 at the joint
    compliance: Array = field(default_factory=_zeros)  # rad/(N m)
    ripples: tuple[Ripple, ...] = ()
    torque_constant: Array = field(default_factory=_zeros)  # -
    torque_offset: Array = field(default_factory=_zeros)  # N m
    time_delay: float = 0.0  # s, all joints
    channel_delay: Array = field(default_factory=_zeros)  # s, beside that of all joints

    @property
    def elastic(self) -> NDArray[np.intp]:
        """Indices of the joints with an elastic gear."""
        return np.flatnonzero(self.compliance)

    @property
    def delays(self) -> Array:
        """How late (n,) [s] the torque of each joint is reported."""
        return self.channel_delay + self.time_delay

    def ripple(self, q: Array) -> Array:
        """Ripple torque (..., n) [N m] at motor positions (..., n) [rad]."""
        torque = np.zeros_like(q)
        for r in self.ripples:
            torque[..., r.joint] += r.amplitude * np.sin(r.order * q[..., r.joint] + r.phase)
        return torque

    def reported(self, torque: Array) -> Array:
        """Torque (..., n) [N m] as its measurement scales and shifts it; the delay is the recorder's."""
        return (1.0 + self.torque_constant) * torque + self.torque_offset
