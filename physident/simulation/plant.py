"""The plant: the torque that a motion of the simulated arm requires, with every effect that acts on the plant."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.effects.effect import Effect
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
MIN_MASS = 1e-6  # kg: pinocchio divides a link's first moment by its mass


@dataclass(frozen=True, eq=False)
class Instants:
    """N unrelated instants of n joints: ``time`` (N,) [s], ``q`` [rad|m], ``v`` [rad/s|m/s], ``a`` [rad/s^2|m/s^2] and
    ``inertial`` [N m|N] (N, n), the torque of inertia and gravity; ``state`` (S, N) of the effects that have one."""

    time: Array
    q: Array
    v: Array
    a: Array
    inertial: Array
    state: Array


class Plant:
    """A model prepared for integration: inertia in pinocchio, all other effects as one weighted sum.

    ``temperature`` gives the joints' temperature (N, n) [degC] at times (N,) [s], for effects that feel it.
    """

    def __init__(self, model: Model, temperature: Callable[[Array], Array] | None = None) -> None:
        robot = model.robot
        self.robot, self.n, self.temperature = robot, robot.n, temperature
        self.links, self.armature, gravity = np.zeros(10 * robot.n), np.zeros(robot.n), np.array(robot.gravity)
        self.effects: list[tuple[Effect, slice]] = []
        weights = [np.zeros((robot.n, 0))]
        at = states = 0
        for effect in model.effects:
            k = len(effect.columns(robot))
            theta, at = model.theta[at : at + k], at + k
            if effect.acts_on != "plant":
                continue
            added = effect.inertia(robot, theta)
            if added is not None:
                self.links, self.armature = self.links + added.links, self.armature + added.armature
                gravity = gravity + added.gravity
                continue
            size = effect.state_size(robot)
            self.effects.append((effect, slice(states, states + size)))
            states += size
            weights.append(_weights(effect.pattern(robot), theta, robot.n))
        stated = [widths for effect in model.effects if (widths := effect.transition(robot)) is not None]
        self.transition = np.max(stated, axis=0) if stated else None  # as in ``Model.refer``
        self.weights = np.concatenate(weights, axis=1)
        self.states = states
        self.bodies = _bodies(robot.pinocchio, self.links, gravity)

    def inertial(self, q: Array, v: Array, a: Array) -> Array:
        """Torque (n,) [N m|N] of inertia and gravity in one state (n,)."""
        torque = self.armature * a
        for sign, body, data in self.bodies:
            torque += sign * pinocchio.rnea(body, data, q, v, a)
        return torque

    def inertia(self, q: Array) -> Array:
        """Inertia matrix (n, n) [kg m^2|kg] in one position (n,), armature included."""
        M = np.diag(self.armature)
        for sign, body, data in self.bodies:
            M += sign * pinocchio.crba(body, data, q)
        return M

    def torque(self, at: Instants) -> Array:
        """Torque (N, n) [N m|N] of all effects except inertia and gravity, which are ``at.inertial``."""
        if not self.effects:
            return np.zeros_like(at.v)
        signals = self._signals(at)
        load = signals.from_model("load")
        values = [effect.torque_at(self.robot, signals, at.state[places], load) for effect, places in self.effects]
        return (self.weights @ np.concatenate(values)).T

    def state_rate(self, at: Instants) -> Array:
        """Derivative (S, N) of the effects' internal states."""
        if not self.states:
            return at.state
        signals = self._signals(at)
        rates = [effect.state_rate(self.robot, signals, at.state[places]) for effect, places in self.effects]
        return np.concatenate(rates)

    def _signals(self, at: Instants) -> Signals:
        warmth = None if self.temperature is None else self.temperature(at.time)
        load = at.inertial - self.armature * at.a  # what the gears carry: rotors turn before them
        return Signals(
            at.time, at.q, at.v, at.a, temperature=warmth, transition=self.transition, links=self.links,
            rotors=self.armature, load=load, source="simulation",
        )  # fmt: skip

    @cached_property
    def feels_acceleration(self) -> bool:
        """Whether an effect other than inertia depends on the acceleration or the load, tested at random states."""
        q, v, a, inertial = np.random.default_rng(0).standard_normal((4, 5, self.n))
        time, state = np.arange(5.0), np.zeros((self.states, 5))
        torques = [self.torque(Instants(time, q, v, k * a, k * inertial, state)) for k in (1.0, 2.0)]
        return not np.allclose(*torques, rtol=1e-9, atol=1e-12)


def _weights(pattern: NDArray[np.intp], theta: Array, n: int) -> Array:
    """(n, E): an effect's structural non-zeros times this are its joint torques."""
    weights = np.zeros((n, len(pattern)))
    weights[pattern[:, 0], np.arange(len(pattern))] = theta[pattern[:, 1]]
    return weights


def _bodies(model: Any, links: Array, gravity: Array) -> list[tuple[float, Any, Any]]:
    """Pinocchio models whose signed sum has the dynamics of any link parameters (10 n,).

    Torque is linear in the parameters. Where an estimate leaves a link's mass at zero beside a first moment, which no
    body can have, a mass is added to every link and its torque subtracted again.
    """
    if (np.abs(links[::10]) > MIN_MASS).all():
        parts = [(1.0, links)]
    else:
        extra = np.zeros_like(links)
        extra[::10] = 1.0 + np.abs(links[::10])
        parts = [(1.0, links + extra), (-1.0, extra)]
    return [(sign, m := _with_links(model, phi, gravity), m.createData()) for sign, phi in parts]


def _with_links(model: Any, links: Array, gravity: Array) -> Any:
    copy = model.copy()
    copy.gravity.linear = gravity
    for i, phi in enumerate(links.reshape(-1, 10), 1):
        copy.inertias[i] = pinocchio.Inertia.FromDynamicParameters(phi)
    return copy
