"""Springs: one that pulls a joint to zero, and the elasticity of its drive."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.inverse_dynamics import inverse_dynamics, torque_changes
from physident.effects.effect import Array, Cone, Effect, nonnegative
from physident.recordings.preparation import derivative
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

PASSBAND = 1.5  # times the cutoff of the common filter


@dataclass(frozen=True)
class JointSpring(Effect):
    """tau_j = K_j q_j: a spring or a cable bundle that pulls the joint to zero; K in N m/rad. Cone: K >= 0."""

    name: ClassVar[str] = "joint_spring"
    unit: ClassVar[str] = "N m/rad"
    signature: ClassVar[str] = "free of velocity, acts where gravity cannot"
    rivals: ClassVar[str] = "gravity of a wrong mass: goes with the sine of the angle"

    def values(self, robot: Robot, signals: Signals) -> Array:
        return signals.q.T[self.active(robot)]

    def cones(self, robot: Robot) -> tuple[Cone, ...]:
        return (nonnegative(len(self.active(robot))),)


@dataclass(frozen=True)
class JointElasticity(Effect):
    """tau = -c_i d/ds ID(q + s tau_i e_i, v + s tau_i' e_i, a + s tau_i'' e_i): the link lags its encoder by c_i tau_i.

    The encoder sits on the motor's side; tau_i is the torque of the links on joint i, dots its derivatives in time.
    Acts on all rows. Compliance c in rad/(N m), to first order. Cone: c >= 0. Source: Spong, "Modeling and control of
    elastic joint robots" (1987), eq. 7, solved for small compliance.
    """

    name: ClassVar[str] = "joint_elasticity"
    unit: ClassVar[str] = "rad/(N m)"
    pointwise: ClassVar[bool] = False
    needs_model: ClassVar[bool] = True
    signature: ClassVar[str] = "a peak that moves with the pose"
    rivals: ClassVar[str] = "time_delay: the same milliseconds in every joint and pose"

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        count = len(self.active(robot))
        return np.array([(j, c) for c in range(count) for j in range(robot.n)], dtype=np.intp).reshape(-1, 2)

    def values(self, robot: Robot, signals: Signals) -> Array:
        links, state, active = signals.from_model("links"), (signals.q, signals.v, signals.a), tuple(self.active(robot))
        torque = inverse_dynamics(robot, links, *state)
        bends = np.empty((len(active), 3, len(signals.time)))
        passband = (
            PASSBAND * signals.cutoff
        )  # no more than the filter's band: twice differentiated noise drowns the bend
        for bend, i in zip(bends, active, strict=True):
            bend[0] = torque[:, i]
            bend[1:] = [derivative(torque[:, i], order, signals.rate, passband) for order in (1, 2)]
        return -torque_changes(robot, links, state, active, bends).reshape(-1, len(signals.time))

    def torque_at(self, robot: Robot, signals: Signals, state: Array, load: Array) -> Array:
        """Nothing: the plant moves its links; what the encoders show of them is ``measure``."""
        return np.zeros((len(self.pattern(robot)), len(signals.time)))

    def measure(self, robot: Robot, theta: Array, signals: Signals) -> Signals:
        bend = np.zeros_like(signals.q)
        active = self.active(robot)
        bend[:, active] = theta * signals.from_model("load")[:, active]
        rate = np.gradient(bend, 1 / signals.rate, axis=0)
        shifted = (signals.q + bend, signals.v + rate, signals.a + np.gradient(rate, 1 / signals.rate, axis=0))
        return replace(signals, q=shifted[0], v=shifted[1], a=shifted[2])

    def cones(self, robot: Robot) -> tuple[Cone, ...]:
        return (nonnegative(len(self.active(robot))),)
