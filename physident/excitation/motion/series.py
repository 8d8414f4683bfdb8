"""The motions that a design chooses from: Fourier series at rest at both ends, linear in their free numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.excitation.motion.trajectory import MAX_HARMONICS, Trajectory

Array = NDArray[np.float64]
MIN_HARMONICS = 2  # with one harmonic, a motion that starts at rest does not move
SLOWEST, FASTEST = 1e-5, 1e3  # Hz: a period of a day, and one that no arm can follow


@dataclass(frozen=True)
class Series:
    """Fourier series of ``n`` joints with ``harmonics`` L of ``base_frequency`` [Hz], at rest where a period begins.

    A joint has m = 2 L - 1 free numbers y, all of the size of a position: 2 (L - 1) coordinates of a and b on the
    subspace sum_l l a_l = 0, sum_l l^2 b_l = 0, and the offset q0. Source: thesis eq. 3.54-3.58.
    Raises InputError for fewer than two harmonics or a frequency that is not positive.
    """

    n: int
    harmonics: int
    base_frequency: float

    def __post_init__(self) -> None:
        if not isinstance(self.harmonics, int) or not MIN_HARMONICS <= self.harmonics <= MAX_HARMONICS // 2:
            raise InputError(
                f"harmonics is {self.harmonics}, expected a whole number from {MIN_HARMONICS} to {MAX_HARMONICS // 2}"
            )
        if not SLOWEST <= self.base_frequency <= FASTEST:
            raise InputError(f"base_frequency is {self.base_frequency} Hz, expected {SLOWEST:g} to {FASTEST:g} Hz")

    @property
    def m(self) -> int:
        """Free numbers of a joint."""
        return 2 * self.harmonics - 1

    @property
    def size(self) -> int:
        """Free numbers of all joints, joint by joint."""
        return self.n * self.m

    @property
    def period(self) -> float:
        """Length of a period [s]."""
        return 1 / self.base_frequency

    @cached_property
    def _maps(self) -> tuple[Array, Array]:
        """A, B (L, L - 1) with a = A y and b = B y; their columns, times the order l, are orthonormal."""
        order = np.arange(1.0, self.harmonics + 1)
        maps = []
        for normal in (np.ones_like(order), order):  # of l a_l and of l b_l
            basis = np.linalg.svd(normal[None])[2][1:].T
            maps.append(basis / order[:, None])
        return maps[0], maps[1]

    def basis(self, phase: Array) -> tuple[Array, Array, Array]:
        """Q, V, A (K, m) at phases (K,) of a period, from 0 to 1: the derivatives of a joint's position, velocity [1/s] and
        acceleration [1/s^2] by its free numbers."""
        order = np.arange(1, self.harmonics + 1)
        omega = 2 * math.pi * self.base_frequency * order
        angle = 2 * math.pi * np.outer(phase, order)
        sine, cosine = np.sin(angle), np.cos(angle)
        A, B = self._maps
        offset, still = np.ones((len(phase), 1)), np.zeros((len(phase), 1))
        return (
            np.hstack([sine @ A, -cosine @ B, offset]),
            np.hstack([(cosine * omega) @ A, (sine * omega) @ B, still]),
            np.hstack([-(sine * omega**2) @ A, (cosine * omega**2) @ B, still]),
        )

    def trajectory(self, y: Array, periods: int = 1) -> Trajectory:
        """The motion of free numbers (n m,) over a number of periods."""
        rows = y.reshape(self.n, self.m)
        A, B = self._maps
        half = self.harmonics - 1
        return Trajectory(
            rows[:, :half] @ A.T, rows[:, half:-1] @ B.T, rows[:, -1], self.base_frequency, periods * self.period
        ).to_rest()

    def numbers(self, trajectory: Trajectory) -> Array:
        """The free numbers (n m,) of a motion of this series."""
        A, B = (np.linalg.pinv(matrix) for matrix in self._maps)
        return np.hstack([trajectory.a @ A.T, trajectory.b @ B.T, trajectory.q0[:, None]]).ravel()
