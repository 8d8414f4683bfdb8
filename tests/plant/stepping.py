"""One step in time: a stiff integrator for what is smooth between two events of dry friction.

ROS2 (Verwer, Spee, Blom, Hundsdorfer, SIAM J. Sci. Comput. 20 (1999), eq. 2.2) with gamma = 1 - 1/sqrt(2): two stages,
L-stable, and of second order for any approximate Jacobian. Ours holds what is stiff: control, friction's slope, bristles,
springs. Elements that stick are taken out of the coordinates, so they do not move at all.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs

from tests.plant.forces import Controlled, Forces, Instant, State
from tests.plant.laws import Bristle

Array = NDArray[np.float64]
GAMMA = 1 - 1 / np.sqrt(2)
_solve, _solve_again = get_lapack_funcs(("posv", "potrs"), dtype=np.float64)


class Stepper:
    """Takes steps of one arm."""

    def __init__(self, arm: Controlled) -> None:
        self.arm = arm
        self.bristles = isinstance(arm.friction.law, Bristle)
        self.known = 0.0, arm.all_D, arm.all_K
        self.dahl = arm.friction.acts["stiffness"]
        # the rotors' places on the diagonal of a matrix (size, size), counted row by row
        self.diagonal = slice(None, None, arm.size + 1) if arm.rigid else arm.rotor * (arm.size + 1)

    def step(self, start: Instant, end: Instant, state: State, one: Forces, basis: Array | None) -> tuple[State, State]:
        """The state after the time between two instants, of forces ``one`` at the first, and the guess of it on the way;
        ``basis`` (size, free): the directions in which the arm can move, None for all."""
        arm = self.arm
        step = end.time - start.time
        g = GAMMA * step
        rise = GAMMA * (end.command - start.command)
        if not arm.rigid:
            own, rise = rise, np.zeros(arm.size)
            rise[arm.rotor] = own
        if g != self.known[0]:  # nearly all steps are of one length
            self.known = g, g * arm.all_D, g * g * arm.all_K
        J = one.mass + self.known[1] + self.known[2]
        slope, pull, share = one.slope, 0.0, one.slope
        if self.bristles:
            share = g * one.feel / (1 + g * one.decay)
            slope = slope + share * one.gain
            pull = arm.elements.T @ (share * one.rate)
        if arm.friction.couplings:
            J += g * (arm.elements.T * slope) @ arm.elements
        else:
            J.flat[self.diagonal] += g * slope
        solver = _Reduced(J, basis)
        w1 = solver.solve(one.net + rise - g * (arm.all_K @ state.w) - pull)
        y1 = state.w + g * w1
        z1, dahl1 = self._rates(one, g, w1, one.rate, one.dahl_rate)
        middle = State(
            state.y + step * y1,
            state.w + step * w1,
            state.z + step * z1 if self.bristles else state.z,
            state.dahl + step * dahl1 if self.dahl else state.dahl,
            state.modes,
        )
        two = arm.at(end, middle)
        left = middle.w - 2 * y1
        a2 = _Reduced(two.mass, basis).solve(two.net)
        pull = arm.elements.T @ (share * (two.rate - 2 * z1)) if self.bristles else 0.0
        w2 = solver.solve(one.mass @ (a2 - 2 * w1) - rise - g * (arm.all_K @ left) - pull)
        y2 = left + g * w2
        h = step / 2
        z, dahl = state.z, state.dahl
        if self.bristles or self.dahl:
            z2, dahl2 = self._rates(one, g, w2, two.rate - 2 * z1, two.dahl_rate - 2 * dahl1)
            z, dahl = z + h * (3 * z1 + z2), dahl + h * (3 * dahl1 + dahl2)
        last = State(state.y + h * (3 * y1 + y2), state.w + h * (3 * w1 + w2), z, dahl, state.modes)
        return last, middle

    def _rates(self, one: Forces, g: float, w: Array, rate: Array, dahl_rate: Array) -> tuple[Array, Array]:
        """Rates of both kinds of bristles in a stage whose accelerations are ``w`` (size,)."""
        dahl = dahl_rate / (1 + g * one.dahl_decay) if self.dahl else dahl_rate
        if not self.bristles:
            return rate, dahl
        return (rate + g * one.gain * (self.arm.elements @ w)) / (1 + g * one.decay), dahl


class _Reduced:
    """A symmetric positive definite system, in the directions (size, free) that are free."""

    def __init__(self, matrix: Array, basis: Array | None) -> None:
        self.basis = basis
        self.matrix = matrix if basis is None else basis.T @ matrix @ basis
        self.factor: Array | None = None

    def solve(self, rhs: Array) -> Array:
        """Solution (size,)."""
        if self.basis is not None:
            rhs = self.basis.T @ rhs
            if not len(rhs):
                return np.zeros(len(self.basis))
        if self.factor is None:
            self.factor, x, _ = _solve(self.matrix, rhs)
        else:
            x, _ = _solve_again(self.factor, rhs)
        return x if self.basis is None else self.basis @ x
