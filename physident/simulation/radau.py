"""One implicit step of the plant: Radau IIA collocation, solved for the accelerations by Newton's method.

Three stages, order five, L-stable and algebraically stable: dry friction and stiff controllers are damped, not
resolved, and friction that is monotone in velocity takes energy out of the motion at any step. The stages satisfy the
equation of motion itself, not a solved form of it, so that an effect may depend on the acceleration or on the load.
Source: Hairer and Wanner, "Solving Ordinary Differential Equations II" (1996), table IV.5.6 and theorem IV.12.9.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs

from physident.simulation.controllers import Law
from physident.simulation.plant import Instants, Plant

Array = NDArray[np.float64]
ExtraTorque = Callable[[float, Array, Array], Array]
ROOT6 = 6**0.5
NODES = np.array([(4 - ROOT6) / 10, (4 + ROOT6) / 10, 1.0])
WEIGHTS = np.array(
    [
        [(88 - 7 * ROOT6) / 360, (296 - 169 * ROOT6) / 1800, (-2 + 3 * ROOT6) / 225],
        [(296 + 169 * ROOT6) / 1800, (88 + 7 * ROOT6) / 360, (-2 - 3 * ROOT6) / 225],
        [(16 - ROOT6) / 36, (16 + ROOT6) / 36, 1 / 9],
    ]
)
WEIGHTS2 = WEIGHTS @ WEIGHTS
# the polynomial through the rates of one step, continued over the next: where Newton's method starts
CONTINUED = np.vander(1 + NODES, 3) @ np.linalg.inv(np.vander(NODES, 3))
BEGINNING = np.linalg.inv(np.vander(NODES, 3))[-1]  # the same polynomial where its step begins
ROUGH = 2e-3  # rad/s: largest jump of acceleration times step between the end of one step and the start of the next
ITERATIONS = 12
BACKTRACKS = 6
SETTLED = (
    1e-6  # rad/s: the change of velocity over a step at which Newton's method ends; the remaining error is far smaller
)
(gesv,) = get_lapack_funcs(("gesv",), (WEIGHTS,))
DIFFERENCE = 1e-6  # rad/s and the states' unit, small beside any friction law's width


@dataclass(frozen=True, eq=False)
class State:
    """The plant at one instant: ``q``, ``v`` (n,), the effects' ``z`` (S,) and the ``rates`` (3, n + S) of the step that
    led there: accelerations and derivatives of z at its three nodes."""

    q: Array
    v: Array
    z: Array
    rates: Array


class Stepper:
    """Advances a plant under a control law and an external torque."""

    def __init__(self, plant: Plant, law: Law, extra: ExtraTorque | None) -> None:
        self.plant, self.law, self.extra = plant, law, extra
        n, S = plant.n, plant.states
        self.n, self.m = n, n + S
        self.size = np.ones(n + S)  # of one unit of acceleration in each equation
        # instants evaluated together at each stage: the state itself, then each velocity, z, acceleration moved a little
        moved = 1 + self.m + (n if plant.feels_acceleration else 0)
        shift = np.zeros((moved, 2 * n + S))
        shift[1:, : moved - 1] = DIFFERENCE * np.eye(2 * n + S)[: moved - 1, : moved - 1]
        self.moved, self.zero = moved, np.zeros((moved, 1))
        self.dv, self.dz, self.da = shift[:, :n], shift[:, n : n + S], shift[:, n + S :]

    def step(self, state: State, time: float, h: float, plan: Array, rough: bool = True) -> State | None:
        """The state a step h [s] later, or None where Newton's method does not settle.

        ``plan`` (4, 3, n) is the law's plan at the three nodes. Unless ``rough``, None also where the accelerations do
        not join those of the step before: their difference is the embedded error estimate of third order, times four.
        """
        n = self.n
        rates = self._solve(state, time, h, plan, CONTINUED @ state.rates)
        if rates is None:
            rates = self._solve(state, time, h, plan, np.tile(state.rates[-1], (3, 1)))
        if rates is None or (not rough and h * np.abs(state.rates[-1] - BEGINNING @ rates)[:n].max() > ROUGH):
            return None
        q = state.q + h * state.v + h**2 * (WEIGHTS2[2] @ rates[:, :n])
        v = state.v + h * (WEIGHTS[2] @ rates[:, :n])
        return State(q, v, state.z + h * (WEIGHTS[2] @ rates[:, n:]), rates)

    def _solve(self, state: State, time: float, h: float, plan: Array, rates: Array) -> Array | None:
        M = self.plant.inertia(state.q)
        self.size[: self.n] = np.abs(M.diagonal())
        step = max(h, 1e-3)
        residual, J = self._residual(state, time, h, plan, rates, M)
        error = np.abs(residual / self.size).max()
        for _ in range(ITERATIONS):
            if not np.isfinite(error):
                return None
            change, failed = gesv(J, residual.ravel())[2:]
            if failed:
                return None
            change = change.reshape(rates.shape)
            if step * np.abs(change).max() < SETTLED:
                return rates - change
            for _ in range(BACKTRACKS):
                trial = rates - change
                residual, J = self._residual(state, time, h, plan, trial, M)
                new_error = np.abs(residual / self.size).max()
                if new_error < error or step * new_error < SETTLED:
                    break
                change = change / 2
            else:
                return None
            rates, error = trial, new_error
        return None

    def _residual(
        self, state: State, time: float, h: float, plan: Array, rates: Array, M: Array
    ) -> tuple[Array, Array]:
        """Residual of the equations of motion at the three nodes (3, n + S), and its derivative (3 (n + S), 3 (n + S))."""
        n, m, P = self.n, self.m, self.moved
        a, zdot = rates[:, :n], rates[:, n:]
        q = state.q + h * NODES[:, None] * state.v + h**2 * (WEIGHTS2 @ a)
        v = state.v + h * (WEIGHTS @ a)
        inertial = np.array([self.plant.inertial(*stage) for stage in zip(q, v, a, strict=True)])
        at = self._instants(time + h * NODES, q, v, a, inertial, state.z + h * (WEIGHTS @ zdot), M)
        torque = self.plant.torque(at).reshape(3, P, n)
        drive = self.law.torque(plan, q, v)
        residual = np.empty((3, m))
        residual[:, :n] = inertial + torque[:, 0] - drive
        if self.extra is not None:
            residual[:, :n] -= [self.extra(time + h * c, *stage) for c, *stage in zip(NODES, q, v, strict=True)]
        stiffness, damping = self.law.gains(M)
        slopes = np.zeros((3, m, m))  # of the residual with each velocity and z
        slopes[:, :n] = (torque[:, 1 : m + 1] - torque[:, :1]).swapaxes(1, 2) / DIFFERENCE
        slopes[:, :n, :n] += damping
        if m > n:
            rate = self.plant.state_rate(at).T.reshape(3, P, m - n)
            residual[:, n:] = zdot - rate[:, 0]
            slopes[:, n:] = (rate[:, :1] - rate[:, 1 : m + 1]).swapaxes(1, 2) / DIFFERENCE
        J = (h * WEIGHTS)[:, None, :, None] * slopes[:, :, None, :]
        J[:, :n, :, :n] += h**2 * WEIGHTS2[:, None, :, None] * stiffness[:, None, :]
        for i in range(3):
            J[i, :n, i, :n] += M
            if self.plant.feels_acceleration:
                J[i, :n, i, :n] += (torque[i, m + 1 :] - torque[i, :1]).T / DIFFERENCE
            J[i, n:, i, n:] += np.eye(m - n)
        return residual, J.reshape(3 * m, 3 * m)

    def _instants(self, time: Array, q: Array, v: Array, a: Array, inertial: Array, z: Array, M: Array) -> Instants:
        """The three nodes, each followed by itself with one velocity, z or acceleration moved a little."""
        P = self.moved

        def rows(values: Array, shift: Array) -> Array:
            return (values[:, None] + shift).reshape(3 * P, -1)

        return Instants(
            np.repeat(time, P), rows(q, self.zero), rows(v, self.dv), rows(a, self.da), rows(inertial, self.da @ M),
            rows(z, self.dz).T,
        )  # fmt: skip
