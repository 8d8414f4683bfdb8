"""The motion of links behind elastic gears whose rotors move as recorded."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from tests.plant.arm import Arm
from tests.plant.drives import SPRING_DAMPING_TIME

Array = NDArray[np.float64]
FINE = 0.4  # of the fastest rate of a gear's oscillation, for each step of Runge-Kutta


def link_motion(arm: Arm, time: Array, theta: Array, v: Array, a: Array) -> tuple[Array, Array, Array]:
    """Positions, speeds, accelerations (N, n) of the links under the motion (N, n) of the rotors, from standstill."""
    return _Links(arm, time).follow(theta, v, a)


class _Links:
    """The links behind elastic gears (s of n), driven by all rotors, which move by cubics between their rows."""

    def __init__(self, arm: Arm, time: Array) -> None:
        self.arm, self.time, self.soft = arm, time, arm.drives.elastic
        self.data = arm.bodies.createData()
        self.K = 1 / arm.drives.compliance[self.soft]
        self.D = SPRING_DAMPING_TIME * self.K
        self.step = float(time[1] - time[0])
        self.bodies = [[b for start, b in arm.carried if start <= t + 1e-9][-1] for t in time]

    def follow(self, theta: Array, v: Array, a: Array) -> tuple[Array, Array, Array]:
        soft = self.soft
        q, w, b = theta.copy(), v.copy(), a.copy()
        q[0, soft] = self._rest(theta[0])
        state = np.array([q[0, soft], v[0, soft]])
        pieces = self._pieces(q[0])
        for k in range(len(self.time)):
            q[k, soft], w[k, soft] = state
            b[k, soft] = self._rates(k, (theta[k], v[k], a[k]), state)[1]
            if k + 1 < len(self.time):
                edge = (theta[k], v[k], theta[k + 1], v[k + 1])
                for piece in range(pieces):
                    state = self._runge_kutta(k, edge, piece / pieces, 1 / pieces, state)
        return q, w, b

    def _pieces(self, q: Array) -> int:
        mass = pin.crba(self.bodies[0], self.data, q)[np.ix_(self.soft, self.soft)]
        square = float(np.linalg.eigvals(np.linalg.solve(mass, np.diag(self.K))).real.max())
        return int(np.ceil(self.step * (np.sqrt(square) + SPRING_DAMPING_TIME * square) / FINE))

    def _rest(self, theta: Array) -> Array:
        """Positions (s,) of the links at standstill."""
        q = theta.copy()
        for _ in range(100):
            torque = pin.computeGeneralizedGravity(self.bodies[0], self.data, q) + self.arm.spring * q
            contact = self.arm.contact_torque(self.data, q, self.time[0])
            torque = torque if contact is None else torque + contact
            q[self.soft] += 0.5 * (theta[self.soft] - torque[self.soft] / self.K - q[self.soft])
        return q[self.soft]

    def _runge_kutta(self, row: int, edge: Any, share: float, part: float, state: Array) -> Array:
        h = part * self.step
        first, middle, last = (self._rotors(edge, share + x * part) for x in (0.0, 0.5, 1.0))
        k1 = self._rates(row, first, state)
        k2 = self._rates(row, middle, state + h / 2 * k1)
        k3 = self._rates(row, middle, state + h / 2 * k2)
        k4 = self._rates(row, last, state + h * k3)
        return state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)

    def _rotors(self, edge: Any, x: float) -> tuple[Array, Array, Array]:
        """Motion (n,) of the rotors at a share of the step between two rows' positions and speeds."""
        q0, v0, q1, v1 = edge
        way = (q1 - q0) / self.step
        bend, twist = 3 * way - 2 * v0 - v1, v0 + v1 - 2 * way
        q = q0 + self.step * x * (v0 + x * (bend + x * twist))
        return q, v0 + x * (2 * bend + 3 * x * twist), (2 * bend + 6 * x * twist) / self.step

    def _rates(self, row: int, rotors: tuple[Array, Array, Array], state: Array) -> Array:
        """Speeds and accelerations (2, s) of the links."""
        soft, bodies = self.soft, self.bodies[row]
        q, w, other = (x.copy() for x in rotors)
        wound = self.K * (q[soft] - state[0]) + self.D * (w[soft] - state[1]) - self.arm.spring[soft] * state[0]
        q[soft], w[soft] = state
        other[soft] = 0.0
        if self.arm.contacts:
            contact = self.arm.contact_torque(self.data, q, self.time[row])
            wound -= 0.0 if contact is None else contact[soft]
        needed = pin.rnea(bodies, self.data, q, w, other)[soft]
        mass = pin.crba(bodies, self.data, q)[np.ix_(soft, soft)]
        return np.array([state[1], np.linalg.solve(mass, wound - needed)])
