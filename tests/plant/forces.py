"""The forces on a controlled arm at one instant, and how they rise with its speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from tests.plant.arm import Arm
from tests.plant.controller import Controller
from tests.plant.drives import SPRING_DAMPING_TIME
from tests.plant.friction import Friction
from tests.plant.laws import Bristle, Smooth
from tests.truth import Disturbance

Array = NDArray[np.float64]


@dataclass(slots=True)
class State:
    """Positions ``y`` and speeds ``w`` (size,) of the n links and then of the rotors of elastic gears; bristle deflections
    ``z`` (m,) of the law and ``dahl`` (n,) of the presliding hysteresis; ``modes`` (m,) of dry friction: the direction in
    which an element slides, 0 where it is stuck."""

    y: Array
    w: Array
    z: Array
    dahl: Array
    modes: Array


@dataclass(slots=True)
class Instant:
    """``time`` [s], ``command`` (n,) [N m] of control, friction's ``warm``-up factor (n,), ``row`` of the contact's time, and
    the ``bodies`` that are carried then."""

    time: float
    command: Array
    warm: Array
    row: int
    bodies: Any


@dataclass(slots=True)
class Forces:
    """Net force ``net`` (size,) [N m] = mass @ acceleration (stuck elements' friction not yet in it), ``mass`` (size, size),
    ``asked`` (n,) [N m] torque of control, ``total`` (n,) [N m] that load-dependent friction and the load share; of the elements (m,): speed
    ``u``, friction ``torque`` and ``level`` without load, its ``slope`` with speed; of bristles: ``rate``, ``decay``,
    ``gain`` = d rate/du, ``feel`` = d torque/dz; ``dahl_rate``, ``dahl_decay`` (n,)."""

    net: Array
    mass: Array
    asked: Array
    total: Array
    u: Array
    level: Array
    torque: Array
    slope: Array
    rate: Array
    decay: Array
    gain: Array
    feel: Array
    dahl_rate: Array
    dahl_decay: Array


class Controlled:
    """An arm under control, made ready to be integrated."""

    def __init__(self, arm: Arm, controller: Controller, time: Array) -> None:
        self.arm, self.friction, self.drives, self.time = arm, arm.friction, arm.drives, time
        self.n = arm.joints
        self.carried = arm.carried
        self.data = self.carried[0][1].createData()
        self.warm = self.friction.warm(time, arm.temperature(time))
        elastic = self.drives.elastic
        self.size = self.n + len(elastic)
        self.rotor = np.arange(self.n)
        self.rotor[elastic] = self.n + np.arange(len(elastic))
        self.rigid = not len(elastic)
        # of vectors (size,): a slice costs a view, a list of indices a copy
        self.driven = slice(self.n) if self.rigid else self.rotor
        self.rotors = self.drives.rotor_inertia[elastic]
        self.soft = self.drives.compliance > 0
        self.Kp, self.Kd = np.array(controller.proportional), np.array(controller.derivative)
        self.resisting = [d for d in arm.disturbances if type(d).resist is not Disturbance.resist]
        self.delivering = [d for d in arm.disturbances if type(d).deliver is not Disturbance.deliver]
        # (m, size): the speed of each element of friction
        self.elements = np.zeros((len(self.friction.elements), self.size))
        self.elements[:, self.rotor] = self.friction.elements
        self.K, self.D = self._springs()
        self.sprung = bool(self.K.any())
        # stiffness and damping of control, springs and viscous friction together, for the Jacobian
        self.all_K, self.all_D = self.K.copy(), self.D.copy()
        self.all_K[self.rotor, self.rotor] += self.Kp
        self.all_D[self.rotor, self.rotor] += self.Kd
        self.all_D[np.ix_(self.rotor, self.rotor)] += self.friction.wet_slope

    def _springs(self) -> tuple[Array, Array]:
        """Stiffness and damping (size, size) of joint springs and elastic gears."""
        K, D = np.zeros((2, self.size, self.size))
        K[np.arange(self.n), np.arange(self.n)] = self.arm.spring
        for at, joint in enumerate(self.drives.elastic, self.n):
            stiffness = 1 / self.drives.compliance[joint]
            block = np.ix_([joint, at], [joint, at])
            K[block] += stiffness * np.array([[1, -1], [-1, 1]])
            D[block] += SPRING_DAMPING_TIME * stiffness * np.array([[1, -1], [-1, 1]])
        return K, D

    def rest(self, command: Array) -> Array:
        """Positions (size,) at which the arm stands still without friction under the first command (n,) [N m]."""
        compliance, bodies, still = self.drives.compliance, self.carried[0][1], np.zeros(self.n)
        q, torque = command / self.Kp, still
        for _ in range(100):
            torque = pin.computeGeneralizedGravity(bodies, self.data, q) + self.arm.spring * q
            contact = self.arm.contact_torque(self.data, q, 0.0)
            torque = torque if contact is None else torque + contact
            theta = q + compliance * torque
            other = self.drives.ripple(theta) + self.resisted(0.0, theta, still)
            # half a step at a time: converges for any arm the controller can hold
            q = q + 0.5 * ((command - torque - other) / self.Kp - theta)
        return np.concatenate([q, (q + compliance * torque)[self.drives.elastic]])

    def resisted(self, time: float, theta: Array, v: Array) -> Array:
        """Torque (n,) [N m] of the disturbances that drives must overcome."""
        total = np.zeros(self.n)
        for disturbance in self.resisting:
            torque = disturbance.resist(time, theta, v)
            total += 0.0 if torque is None else torque
        return total

    def at(self, now: Instant, state: State) -> Forces:
        """Forces in one state."""
        n, driven, w, friction = self.n, self.driven, state.w, self.friction
        theta, v = state.y[driven], w[driven]
        asked = now.command - self.Kp * theta - self.Kd * v
        acting = asked
        for disturbance in self.delivering:
            acting = disturbance.deliver(now.time, v, acting)
        free = acting - friction.wet(v, now.warm)
        if self.drives.ripples:
            free -= self.drives.ripple(theta)
        if self.resisting:
            free -= self.resisted(now.time, theta, v)
        dahl_rate = dahl_decay = state.dahl  # zero where there is none
        if friction.acts["stiffness"]:
            free -= friction.stiffness * state.dahl
            dahl_decay = np.abs(v) / friction.slip
            dahl_rate = v - dahl_decay * state.dahl
        total = free
        if not self.rigid:
            total = np.zeros(self.size)
            total[driven] = free
        if self.sprung:
            total -= self.K @ state.y + self.D @ w
        if self.arm.contacts:
            contact = self.arm.contact_torque(self.data, state.y[:n], self.time[now.row])
            total[:n] -= 0.0 if contact is None else contact
        u = self.elements @ w if friction.couplings else v
        level = friction.level(u, now.warm)
        direction, torque, slope, rate, decay, gain, feel = _turned(friction, u, level, state)
        total[driven] -= torque @ friction.elements if friction.couplings else torque
        before = total[driven].copy()
        if not self.rigid:
            before[self.soft] = total[:n][self.soft]
        mass = self.mass(now.bodies, state.y[:n])
        bias = pin.nonLinearEffects(now.bodies, self.data, state.y[:n], w[:n])
        if friction.acts["load_dependent"]:
            self._load(total, direction[:n], mass, bias)
        total[:n] -= bias
        return Forces(
            total, mass, asked, before, u, level, torque, slope, rate, decay, gain, feel, dahl_rate, dahl_decay
        )  # fmt: skip

    def mass(self, bodies: Any, q: Array) -> Array:
        """Mass matrix (size, size) at link positions (n,)."""
        if self.rigid:
            return pin.crba(bodies, self.data, q).copy()
        mass = np.zeros((self.size, self.size))
        mass[: self.n, : self.n] = pin.crba(bodies, self.data, q)
        mass[range(self.n, self.size), range(self.n, self.size)] = self.rotors
        return mass

    def _load(self, total: Array, direction: Array, mass: Array, bias: Array) -> None:
        """Take load-dependent friction (n,) off ``total`` (size,).

        A stiff gear carries what its rotor, which turns before it, and its own friction leave: load + mu s |load| = total - J a, with the
        acceleration a that this makes. Behind an elastic one the link feels no friction: load = total.
        """
        mu = self.friction.load_dependent * direction
        load = total[: self.n] / np.where(total[: self.n] > 0, 1 + mu, 1 - mu)
        load[self.soft] = total[: self.n][self.soft]
        stiff = np.where(self.soft, 0.0, self.drives.rotor_inertia)
        moves = np.ones(self.size, dtype=bool)
        moves[self.rotor] = direction != 0  # a stuck joint's rotor stands
        inner = mass[np.ix_(moves, moves)]
        before = np.full(self.n, np.inf)
        while not np.allclose(load, before):  # each round leaves less than a third of what the load is off by
            before = load
            net = total.copy()
            net[self.rotor] -= mu * np.abs(load)
            left = net[: self.n].copy()
            net[: self.n] -= bias
            a = np.zeros(self.size)
            a[moves] = np.linalg.solve(inner, net[moves])
            load = np.where(self.soft, total[: self.n], left - stiff * a[: self.n])
        total[self.rotor] -= mu * np.abs(load)


def _turned(friction: Friction, u: Array, level: Array, state: State) -> tuple[Array, ...]:
    """Direction, torque [N m] and its slope of each element (m,); then rate, decay, gain and feel of its bristle."""
    law, none = friction.law, state.modes
    if isinstance(law, Smooth):
        direction = law.direction(u)
        return direction, direction * level, level * law.slope(u), none, none, none, none
    if isinstance(law, Bristle):
        direction, damped = state.z * law.stiffness / level, law.damped(u)
        decay = np.abs(u) * law.stiffness / level
        rate = u - decay * state.z
        gain = np.clip(1 - direction * np.sign(u), 0.0, 1.0)
        torque = law.stiffness * state.z + damped * rate
        feel = np.maximum(law.stiffness - damped * decay, 0.0)
        return np.clip(direction, -1, 1), torque, damped * gain, rate, decay, gain, feel
    return none, none * level, none * 0.0, none, none, none, none
