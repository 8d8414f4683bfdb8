"""Dry friction at rest: which elements stick, and which break away, decided by the torque they would have to take."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs

from tests.plant.forces import Controlled, Forces, Instant, State

Array = NDArray[np.float64]
TIGHT = 1e-10  # relative: a torque this near its limit is at it
_solve = get_lapack_funcs(("posv",), dtype=np.float64)[0]


@dataclass(slots=True)
class Held:
    """Forces once every resting element has its mode (m,), and the accelerations ``a`` (size,)."""

    forces: Forces
    modes: Array
    a: Array


class Sticking:
    """Finds the modes of resting elements, for one arm."""

    def __init__(self, arm: Controlled) -> None:
        self.arm = arm
        self.friction = arm.friction
        self._bases: dict[bytes, Array | None] = {}

    def basis(self, modes: Array) -> Array | None:
        """Orthonormal directions (size, free) in which the arm can move while the elements of mode 0 stick; None: all."""
        key = (modes == 0).tobytes()
        if key not in self._bases:
            self._bases[key] = self._free(modes == 0)
        return self._bases[key]

    def _free(self, stuck: NDArray[np.bool_]) -> Array | None:
        if not stuck.any():
            return None
        n, size = self.arm.n, self.arm.size
        fixed = np.zeros(size, dtype=bool)
        fixed[self.arm.rotor[stuck[:n]]] = True
        rows = self.arm.elements[n:][stuck[n:]] * ~fixed
        if not rows.any():
            return np.eye(size)[:, ~fixed]
        # coordinates that stick stay exact zeros: only the others take part in the decomposition
        _, values, ways = np.linalg.svd(rows[:, ~fixed])
        basis = np.zeros((size, int((~fixed).sum()) - int((values > 1e-9).sum())))
        basis[~fixed] = ways[int((values > 1e-9).sum()) :].T
        return basis

    def settle(self, now: Instant, state: State, forces: Forces) -> Held:
        """Modes of the elements at rest: each sticks below its limit, or slides the way it is accelerated.

        Changing one that contradicts itself at a time, the first, ends in the one answer there is (Murty's rule).
        """
        resting = state.modes == 0
        modes = state.modes
        for _ in range(200):
            a = self.accelerations(forces, modes)
            wrong = self._wrong(forces, modes, a) & resting
            if not wrong.any():
                break
            first = int(np.argmax(wrong))
            modes = modes.copy()
            modes[first] = np.sign(self._taken(forces, modes, a)[first]) if modes[first] == 0 else 0.0
            forces = self.arm.at(now, replace(state, modes=modes))
        else:
            raise RuntimeError("dry friction found no answer")
        return Held(forces, modes, a)

    def accelerations(self, forces: Forces, modes: Array | None) -> Array:
        """Accelerations (size,) while the elements of mode 0 stick, or none (None)."""
        basis = None if modes is None else self.basis(modes)
        if basis is None:
            return _solve(forces.mass, forces.net)[1]
        if not basis.shape[1]:
            return np.zeros(self.arm.size)
        return basis @ _solve(basis.T @ forces.mass @ basis, basis.T @ forces.net)[1]

    def _wrong(self, forces: Forces, modes: Array, a: Array) -> NDArray[np.bool_]:
        stuck = modes == 0
        taken = self._taken(forces, modes, a)
        over = stuck & (np.abs(taken) > self._limits(forces, taken) * (1 + TIGHT))
        return over | (~stuck & (modes * (self.arm.elements @ a) < -TIGHT))

    def _limits(self, forces: Forces, taken: Array) -> Array:
        """The most torque (m,) [N m] that stuck elements take, load included."""
        if not self.friction.acts["load_dependent"]:
            return forces.level
        n = self.arm.n
        load = forces.total - taken[:n]
        load[self.arm.soft] = forces.total[self.arm.soft]
        return forces.level + np.append(self.friction.load_dependent * np.abs(load), np.zeros(len(taken) - n))

    def _taken(self, forces: Forces, modes: Array, a: Array) -> Array:
        """Torque (m,) [N m] that stuck elements take, zero for others; of a pair whose joints stick, the share that leaves
        each of them below its own level where any does."""
        n, stuck = self.arm.n, modes == 0
        left = (forces.net - forces.mass @ a)[self.arm.rotor]
        taken = np.zeros(len(modes))
        for i, pair in enumerate(self.friction.couplings, n):
            if not stuck[i]:
                continue
            ends = [pair.first, pair.second]
            both = stuck[ends]
            if both.all():
                low, high = (left[ends] - forces.level[ends]).max(), (left[ends] + forces.level[ends]).min()
                share = np.clip(0.0, low, high) if low <= high else (low + high) / 2
                taken[i] = np.clip(share, -forces.level[i], forces.level[i])
            else:
                # the sliding end's balance has nothing else in it; with two, both ends have the same
                taken[i] = left[ends][~both].mean()
            left[ends] -= taken[i]
        taken[:n] = np.where(stuck[:n], left, 0.0)
        return taken
