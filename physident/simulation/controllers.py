"""Controllers that make the simulated arm follow a motion; each acts continuously, without a sampling period."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.errors import InputError
from physident.excitation.motion.motion import Motion
from physident.simulation.plant import Instants, Plant

Array = NDArray[np.float64]
MIN_INERTIA = (
    0.05  # of the largest of joints that turn, or slide, for the gains: the friction of a light wrist is not small
)
STABLE = (
    1.5  # times inertia over a step, the largest damping: twice would turn a speed around in every step of a simulation
)
BANDWIDTH = 8.0  # Hz


class Law(ABC):
    """A controller at work on one motion: a plan in advance, a torque from the state, and how stiff that torque is."""

    @abstractmethod
    def plan(self, time: Array) -> Array:
        """(4, N, n): wanted q, v, a (NaN where nothing is wanted) and a torque in advance [N m|N] at times (N,) [s]."""

    @abstractmethod
    def torque(self, plan: Array, q: Array, v: Array) -> Array:
        """Torque (N, n) [N m|N] in states q, v (N, n) under a plan (4, N, n)."""

    @abstractmethod
    def gains(self, M: Array) -> tuple[Array, Array]:
        """Stiffness [N m/rad] and damping [N m s/rad] (n, n) near a state with inertia matrix M (n, n)."""


class Controller(ABC):
    """What makes the arm follow a motion."""

    @abstractmethod
    def law(self, plant: Plant, motion: Motion) -> Law:
        """The controller at work on an arm along a motion."""


@dataclass(frozen=True)
class PD(Controller):
    """tau = g(q_wanted) + stiffness (q_wanted - q) + damping (v_wanted - v), g the gravity of the robot's description.

    ``stiffness`` (n,) [N m/rad|N/m], ``damping`` (n,) [N m s/rad|N s/m]. Raises InputError for a gain that is negative
    or not finite: it would drive the arm away from the motion.
    """

    stiffness: tuple[float, ...]
    damping: tuple[float, ...]

    def __post_init__(self) -> None:
        for name in ("stiffness", "damping"):
            gains = getattr(self, name)
            if not np.isfinite(gains).all() or (np.array(gains) < 0).any():
                raise InputError(
                    f"controller: {name} is {list(gains)}, expected finite numbers, none negative: such a gain is unstable"
                )

    @staticmethod
    def of_bandwidth(
        model: Model, q: Array, frequency: float = BANDWIDTH, damping_ratio: float = 0.7, step: float | None = None
    ) -> PD:
        """Gains for a natural frequency [Hz] with the inertia that each joint feels in position q (n,).

        A joint lighter than a twentieth of the heaviest that turns, or slides, as it does gets the gains of that twentieth, but no more
        damping than a simulation can take whose explicit ``step`` [s] is given.
        """
        inertia = np.diag(Plant(model).inertia(np.asarray(q, dtype=float)))
        kinds = np.array([joint.kind for joint in model.robot.joints])
        heaviest = np.array([inertia[kinds == kind].max() for kind in kinds])
        omega = 2 * math.pi * frequency
        most = inertia * STABLE / (2 * damping_ratio * omega * step) if step and damping_ratio else np.inf
        inertia = np.minimum(np.maximum(inertia, MIN_INERTIA * heaviest), most)
        return PD(tuple(omega**2 * inertia), tuple(2 * damping_ratio * omega * inertia))

    def law(self, plant: Plant, motion: Motion) -> Law:
        for name in ("stiffness", "damping"):
            if len(getattr(self, name)) != plant.n:
                raise InputError(
                    f"controller: {len(getattr(self, name))} values of {name}, expected {plant.n}, one for each joint"
                )
        described = Model.nominal(plant.robot, ["rigid_body"])
        return _PDLaw(Plant(described), motion, np.array(self.stiffness), np.array(self.damping))


class _PDLaw(Law):
    def __init__(self, plant: Plant, motion: Motion, stiffness: Array, damping: Array) -> None:
        self.plant, self.motion, self.stiffness, self.damping = plant, motion, stiffness, damping
        self.matrices = (np.diag(stiffness), np.diag(damping))

    def plan(self, time: Array) -> Array:
        s = self.motion.states(time)
        still = np.zeros(self.plant.n)
        return np.stack([s.q, s.v, s.a, np.array([self.plant.inertial(q, still, still) for q in s.q])])

    def torque(self, plan: Array, q: Array, v: Array) -> Array:
        return plan[3] + self.stiffness * (plan[0] - q) + self.damping * (plan[1] - v)

    def gains(self, M: Array) -> tuple[Array, Array]:
        return self.matrices


@dataclass(frozen=True)
class ComputedTorque(Controller):
    """tau = ID(q, v, a_wanted + w^2 (q_wanted - q) + 2 damping_ratio w (v_wanted - v)), w = 2 pi frequency [Hz].

    ID is the inverse dynamics of ``model``, by default that of the simulated arm; torques other than inertia and gravity
    are those of the wanted motion. Source: Spong, Hutchinson, Vidyasagar, "Robot Modeling and Control" (2006), eq. 8.21.
    """

    frequency: float = BANDWIDTH
    damping_ratio: float = 1.0
    model: Model | None = None

    def __post_init__(self) -> None:
        if not (0 < self.frequency < math.inf and 0 <= self.damping_ratio < math.inf):
            raise InputError(
                f"controller: frequency {self.frequency} Hz, damping ratio {self.damping_ratio}; expected a positive one and one not negative"
            )

    def law(self, plant: Plant, motion: Motion) -> Law:
        known = plant if self.model is None else Plant(self.model, plant.temperature)
        if known.n != plant.n:
            raise InputError(f"controller: its model has {known.n} joints, but robot {plant.robot.name} has {plant.n}")
        omega = 2 * math.pi * self.frequency
        return _ComputedTorqueLaw(known, motion, omega**2, 2 * self.damping_ratio * omega)


class _ComputedTorqueLaw(Law):
    def __init__(self, plant: Plant, motion: Motion, stiffness: float, damping: float) -> None:
        self.plant, self.motion, self.stiffness, self.damping = plant, motion, stiffness, damping

    def plan(self, time: Array) -> Array:
        s = self.motion.states(time)
        inertial = np.array([self.plant.inertial(*state) for state in zip(s.q, s.v, s.a, strict=True)])
        known = self.plant.torque(Instants(time, s.q, s.v, s.a, inertial, np.zeros((self.plant.states, len(time)))))
        return np.stack([s.q, s.v, s.a, known])

    def torque(self, plan: Array, q: Array, v: Array) -> Array:
        a = plan[2] + self.stiffness * (plan[0] - q) + self.damping * (plan[1] - v)
        return plan[3] + np.array([self.plant.inertial(*state) for state in zip(q, v, a, strict=True)])

    def gains(self, M: Array) -> tuple[Array, Array]:
        return self.stiffness * M, self.damping * M


@dataclass(frozen=True)
class Released(Controller):
    """No torque: the arm moves freely, or under an external torque alone."""

    def law(self, plant: Plant, motion: Motion) -> Law:
        return _ReleasedLaw(plant.n)


class _ReleasedLaw(Law):
    def __init__(self, n: int) -> None:
        self.none = np.zeros((n, n))

    def plan(self, time: Array) -> Array:
        plan = np.full((4, len(time), len(self.none)), np.nan)
        plan[3] = 0.0
        return plan

    def torque(self, plan: Array, q: Array, v: Array) -> Array:
        return plan[3]

    def gains(self, M: Array) -> tuple[Array, Array]:
        return self.none, self.none
