"""Forward dynamics of the controlled arm in time: pinocchio's articulated-body algorithm in a stiff integrator.

Coordinates y are the six link positions, then the rotor positions of the elastic gears. ROS2 (Verwer, Spee, Blom,
Hundsdorfer, SIAM J. Sci. Comput. 20 (1999), eq. 2.2) with gamma = 1 - 1/sqrt(2): two stages, L-stable, and of second
order for any approximate Jacobian. Ours holds what is stiff: control, friction's slope, springs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs

from tests.plant.arm import Arm
from tests.plant.controller import Controller
from tests.plant.drives import SPRING_DAMPING_TIME
from tests.plant.friction import SMOOTHING
from tests.plant.motions import Motion

Array = NDArray[np.float64]
GAMMA = 1 - 1 / np.sqrt(2)
STEP = 1e-3  # s
_solve, _solve_again = get_lapack_funcs(("posv", "potrs"), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Run:
    """A simulated motion at steps (N,) [s]: ``q`` [rad], ``v`` [rad/s], ``a`` [rad/s^2] (N, 6) of the rotors at the joints
    (those of the links where the gear is stiff), ``link_q``, ``link_v``, ``link_a`` of the links, the ``torque`` (N, 6)
    [N m] of the motors and the bristle deflection ``z`` (N, 6) [rad]."""

    time: Array
    q: Array
    v: Array
    a: Array
    link_q: Array
    link_v: Array
    link_a: Array
    torque: Array
    z: Array


def simulate(arm: Arm, motion: Motion, controller: Controller | None = None, step: float = STEP) -> Run:
    """The arm following a motion under control, from rest, in steps of ``step`` [s]."""
    controller = controller or Controller()
    time: Array = np.arange(round(motion.duration / step) + 1, dtype=float) * np.float64(step)
    command = controller.ahead(*motion.states(time))
    # the controller sees the encoders: true position less the zero offset
    command = command + np.array(controller.proportional) * arm.zero_offset
    plant = _Plant(arm, controller, time)
    y, w, a, z = plant.integrate(command, step)
    rotor = plant.rotor
    torque = command - plant.Kp * y[:, rotor] - plant.Kd * w[:, rotor]
    return Run(time, y[:, rotor], w[:, rotor], a[:, rotor], y[:, :6], w[:, :6], a[:, :6], torque, z)


class _Plant:
    """An arm under control, made ready to be integrated."""

    def __init__(self, arm: Arm, controller: Controller, time: Array) -> None:
        self.arm, self.friction, self.drives = arm, arm.friction, arm.drives
        self.model, self.time = arm.bodies, time
        self.data = self.model.createData()
        self.warm = self.friction.warm(time, arm.temperature(time))
        elastic = self.drives.elastic
        self.size = 6 + len(elastic)
        self.rotor = np.arange(6)
        self.rotor[elastic] = 6 + np.arange(len(elastic))
        self.stiff = self.drives.compliance == 0
        self.rotors = self.drives.rotor_inertia[elastic]
        self.Kp, self.Kd = np.array(controller.proportional), np.array(controller.derivative)
        self.K, self.D = self._springs()
        self.sprung = bool(self.K.any())
        # stiffness and damping of control and springs together, for the Jacobian
        self.all_K, self.all_D = self.K.copy(), self.D.copy()
        self.all_K[self.rotor, self.rotor] += self.Kp
        self.all_D[self.rotor, self.rotor] += self.Kd

    def _springs(self) -> tuple[Array, Array]:
        """Stiffness and damping (size, size) of joint springs and elastic gears."""
        K, D = np.zeros((2, self.size, self.size))
        K[np.arange(6), np.arange(6)] = self.arm.spring
        for at, joint in enumerate(self.drives.elastic, 6):
            stiffness = 1 / self.drives.compliance[joint]
            block = np.ix_([joint, at], [joint, at])
            K[block] += stiffness * np.array([[1, -1], [-1, 1]])
            D[block] += SPRING_DAMPING_TIME * stiffness * np.array([[1, -1], [-1, 1]])
        return K, D

    def rest(self, command: Array) -> Array:
        """Positions at which the arm stands still under the first command (6,) [N m]."""
        compliance = self.drives.compliance
        q, torque = command / self.Kp, np.zeros(6)
        for _ in range(100):
            torque = pin.computeGeneralizedGravity(self.model, self.data, q) + self.arm.spring * q
            contact = self.arm.contact_torque(self.data, q, 0.0)
            torque = torque if contact is None else torque + contact
            ripple = self.drives.ripple(q + compliance * torque)
            # half a step at a time: converges for any arm the controller can hold
            q = q + 0.5 * ((command - torque - ripple) / self.Kp - compliance * torque - q)
        return np.concatenate([q, (q + compliance * torque)[self.drives.elastic]])

    def accelerations(self, step: int, command: Array, y: Array, w: Array, z: Array, warm: Array) -> _Stage:
        """Accelerations and bristle rates of one state, and friction's slope there."""
        friction = self.friction
        acts = friction.acts
        v = w[self.rotor]
        sign = np.tanh(v / SMOOTHING)
        dry = friction.dry(v, warm)
        net = command - self.Kp * y[self.rotor] - self.Kd * v - sign * dry - friction.wet(v, warm)
        rate, stuck = z, z
        if acts["stiffness"]:
            net -= friction.stiffness * z
            stuck = np.abs(v) / friction.slip
            rate = v - stuck * z
        if self.drives.ripples:
            net -= self.drives.ripple(y[self.rotor])
        total = np.zeros(self.size)
        total[self.rotor] = net
        if self.sprung:
            total -= self.K @ y + self.D @ w
        if self.arm.contacts:
            contact = self.arm.contact_torque(self.data, y[:6], self.time[step])
            total[:6] -= 0.0 if contact is None else contact
        if acts["load_dependent"]:
            dry = dry + friction.load_dependent * self._loaded(total, sign)
        a = pin.aba(self.model, self.data, y[:6], w[:6], total[:6])
        if len(self.rotors):
            a = np.concatenate([a, total[6:] / self.rotors])
        slope = dry * (1 - sign * sign) / SMOOTHING
        return _Stage(a, rate, stuck, v, slope)

    def _loaded(self, total: Array, sign: Array) -> Array:
        """|tau_load| (6,); takes its friction off ``total``.

        A stiff gear carries load = torque left after its own friction: load + mu sgn v |load| = total, solved by cases.
        Behind an elastic one the link feels no friction: load = total.
        """
        mu = self.friction.load_dependent * sign
        load = total[:6] / np.where(total[:6] > 0, 1 + mu, 1 - mu)
        soft = ~self.stiff
        if soft.any():
            load[soft] = total[:6][soft]
        total[self.rotor] -= mu * np.abs(load)
        return np.abs(load)

    def integrate(self, command: Array, step: float) -> tuple[Array, Array, Array, Array]:
        """Positions, velocities, accelerations (N, size) and bristles (N, 6) under the commands (N, 6)."""
        count, size, rotor = len(command), self.size, self.rotor
        y, w, z = self.rest(command[0]), np.zeros(size), np.zeros(6)
        Y, W, A = np.empty((3, count, size))
        Z = np.empty((count, 6))
        g = GAMMA * step
        K, D = self.all_K, self.all_D
        implicit = g * D + g * g * K
        rise = np.zeros(size)
        slopes = np.zeros(size)
        coupled = self.friction.acts["couplings"]
        mass = np.zeros((size, size))
        mass[np.arange(6, size), np.arange(6, size)] = self.rotors
        for k in range(count):
            one = self.accelerations(k, command[k], y, w, z, self.warm[k])
            Y[k], W[k], A[k], Z[k] = y, w, one.a, z
            if k + 1 == count:
                break
            mass[:6, :6] = pin.crba(self.model, self.data, y[:6])
            J = mass + implicit
            if coupled:
                sums = self.friction.sums
                J[np.ix_(rotor, rotor)] += g * self.friction.slope(self.warm[k], sums @ one.v, one.slope)
            else:
                slopes[rotor] = one.slope + self.warm[k] * self.friction.viscous
                J.flat[:: size + 1] += g * slopes
            rise[rotor] = GAMMA * (command[k + 1] - command[k])
            factor, w1, _ = _solve(J, mass @ one.a + rise - g * (K @ w))
            y1 = w + g * w1
            z1 = one.rate / (1 + g * one.stuck)
            # a contact's force jumps between steps, so both stages of a step take the same one
            two = self.accelerations(k, command[k + 1], y + step * y1, w + step * w1, z + step * z1, self.warm[k + 1])
            left = w + step * w1 - 2 * y1
            w2, _ = _solve_again(factor, mass @ (two.a - 2 * w1) - rise - g * (K @ left))
            y2 = left + g * w2
            z2 = (two.rate - 2 * z1) / (1 + g * one.stuck)
            y = y + step * (1.5 * y1 + 0.5 * y2)
            w = w + step * (1.5 * w1 + 0.5 * w2)
            z = z + step * (1.5 * z1 + 0.5 * z2)
        return Y, W, A, Z


@dataclass(slots=True)
class _Stage:
    """Accelerations (size,), bristle rates and their decay (6,), rotor speeds (6,), slope of sgn v friction (6,)."""

    a: Array
    rate: Array
    stuck: Array
    v: Array
    slope: Array
