"""Lost motion between a joint's encoder and its link: teeth that lie on one flank or on the other, as the load pushes them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.inverse_dynamics import inverse_dynamics, torque_changes
from physident.effects.classification import Family, every_joint_pattern
from physident.effects.effect import Effect
from physident.recordings.preparation import derivative
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
PASSBAND = 1.5  # times the cutoff of the common filter: more would only add twice differentiated noise
TURNS = 0.1  # of the load's size on the joint: below it the teeth are between their flanks


@dataclass(frozen=True)
class LostMotion(Effect):
    """tau = -b_i / 2 d/ds ID(q + s sgn(tau_i) e_i, ...): the link of joint i lies behind its encoder by half the lost motion b.

    The encoder is on the motor side; tau_i is the torque of the links on joint i, whose sign turns over a tenth of its size, and the
    steps between the flanks move the link as well. Acts on the rows of all joints; b in rad, to first order.
    """

    name: ClassVar[str] = "lost_motion"
    unit: ClassVar[str] = "rad"
    family: ClassVar[Family] = Family.TRANSMISSION
    pointwise: ClassVar[bool] = False
    needs_model: ClassVar[bool] = True

    def pattern(self, robot: Robot) -> NDArray[np.intp]:
        return every_joint_pattern(robot.n, len(self.active(robot)))

    def values(self, robot: Robot, signals: Signals) -> Array:
        links, state, active = signals.from_model("links"), (signals.q, signals.v, signals.a), tuple(self.active(robot))
        load = inverse_dynamics(robot, links, *state)[:, active]
        flanks = 0.5 * np.tanh(load / np.maximum(TURNS * np.sqrt((load**2).mean(axis=0)), 1e-12))
        passband = PASSBAND * signals.cutoff
        moved = [[derivative(side, order, signals.rate, passband) for order in (0, 1, 2)] for side in flanks.T]
        return -torque_changes(robot, links, state, active, np.array(moved)).reshape(-1, len(signals.time))
