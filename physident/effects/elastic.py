"""Springs: one that pulls a joint to zero, and the elasticity of the drive."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.inverse_dynamics import inverse_dynamics, torque_changes
from physident.effects.classification import Family, JointTerm, Variable, every_joint_pattern, nonnegative
from physident.effects.effect import Array, Cone, Effect
from physident.recordings.preparation import derivative, half_window
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

PASSBAND = 1.5  # times the cutoff of the common filter: more would only add twice differentiated noise


@dataclass(frozen=True)
class JointSpring(Effect):
    """tau_j = K_j q_j: a spring or a cable bundle that pulls the joint to zero; K in N m/rad. Cone: K >= 0.

    One that is relaxed at r has the torque_offset -K_j r beside it.
    """

    name: ClassVar[str] = "joint_spring"
    unit: ClassVar[str] = "N m/rad"
    variable: ClassVar[Variable | None] = "position"
    family: ClassVar[Family] = Family.TRANSMISSION
    formulas: ClassVar[tuple[str, ...]] = ("q",)
    goes_with: ClassVar[str] = "torque_offset"
    signature: ClassVar[str] = "independent of velocity, also on joints without gravity torque"
    mistaken_for: ClassVar[str] = "gravity of a wrong mass: follows the sine of the angle"

    def values(self, robot: Robot, signals: Signals) -> Array:
        return signals.q.T[self.active(robot)]

    def nominal(self, robot: Robot) -> Array:
        return robot.spring_stiffness[self.active(robot)]

    def joint_terms(self, robot: Robot, theta: Array) -> tuple[JointTerm, ...]:
        return tuple(JointTerm((j,), stiffness=float(K)) for j, K in zip(self.active(robot), theta, strict=True))

    def cones(self, robot: Robot) -> tuple[Cone, ...]:
        return (nonnegative(len(self.active(robot))),)


@dataclass(frozen=True)
class JointElasticity(Effect):
    """tau = -c_i d/ds ID(q + s tau_i e_i, v + s tau_i' e_i, a + s tau_i'' e_i): the link lags its encoder by c_i tau_i.

    The encoder is on the motor side; tau_i is the torque of the links on joint i, primes are its derivatives in time.
    Acts on the rows of all joints. Compliance c in rad/(N m), to first order. Cone: c >= 0. Source: Spong, "Modeling and control of
    elastic joint robots" (1987), eq. 7, solved for small compliance.
    """

    name: ClassVar[str] = "joint_elasticity"
    unit: ClassVar[str] = "rad/(N m)"
    family: ClassVar[Family] = Family.TRANSMISSION
    pointwise: ClassVar[bool] = False
    needs_model: ClassVar[bool] = True
    signature: ClassVar[str] = "a resonance peak that moves with the pose"
    mistaken_for: ClassVar[str] = "time_delay: the same delay in every joint and pose"

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        return every_joint_pattern(robot.n, len(self.active(robot)))

    def values(self, robot: Robot, signals: Signals) -> Array:
        links, state, active = signals.from_model("links"), (signals.q, signals.v, signals.a), tuple(self.active(robot))
        torque = inverse_dynamics(robot, links, *state)
        deflections = np.empty(
            (len(active), 3, len(signals.time))
        )  # for unit compliance: angle, velocity, acceleration
        passband = PASSBAND * signals.cutoff
        for deflection, i in zip(deflections, active, strict=True):
            deflection[0] = torque[:, i]
            deflection[1:] = [derivative(torque[:, i], order, signals.rate, passband) for order in (1, 2)]
        return -torque_changes(robot, links, state, active, deflections).reshape(-1, len(signals.time))

    def around(self, robot: Robot, signals: Signals, samples: slice) -> slice:
        # a fit sees half a window on either side, and the fits at the ends another half
        half = 2 * half_window(signals.rate, PASSBAND * signals.cutoff, len(signals.time))
        return slice(max(0, samples.start - half), min(len(signals.time), samples.stop + half))

    def torque_at(self, robot: Robot, signals: Signals, state: Array, load: Array) -> Array:
        """Zero: the simulated links move as before, and ``measure`` gives what the encoders show."""
        return np.zeros((len(self.pattern(robot)), len(signals.time)))

    def measure(self, robot: Robot, theta: Array, signals: Signals) -> Signals:
        deflection = np.zeros_like(signals.q)
        active = self.active(robot)
        deflection[:, active] = theta * signals.from_model("load")[:, active]
        rate = np.gradient(deflection, 1 / signals.rate, axis=0)
        acceleration = np.gradient(rate, 1 / signals.rate, axis=0)
        return replace(signals, q=signals.q + deflection, v=signals.v + rate, a=signals.a + acceleration)

    def cones(self, robot: Robot) -> tuple[Cone, ...]:
        return (nonnegative(len(self.active(robot))),)
