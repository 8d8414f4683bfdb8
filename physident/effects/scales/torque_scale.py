"""One scale of all torques: drive gains or a unit of another size."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from physident.effects.classification import Family
from physident.effects.effect import Array, array_source
from physident.effects.scales.shared_scale import SharedScale, sized
from physident.recordings.signals import Signals
from physident.robots.robot import Robot


@dataclass(frozen=True)
class TorqueScale(SharedScale):
    """tau_j = (1 + s + d_j / 100) tau_m_j: the measured torques of all joints are scaled by a share s, without a unit, and that of a
    joint by d_j per cent more; none turns its sign.

    tau_m is the model's torque without measurement effects. It changes a model whose scale is known; in a fit of the masses, too,
    it is invisible.
    """

    name: ClassVar[str] = "torque_scale"
    family: ClassVar[Family] = Family.MEASUREMENT
    acts_on: ClassVar = "measurement"
    needs_model: ClassVar[bool] = True
    signature: ClassVar[str] = "the torques of all joints are scaled alike"
    mistaken_for: ClassVar[str] = (
        "friction_level where friction is most of the torque, gravity_magnitude on slow motions: record fast motions with an outstretched arm"
    )

    @classmethod
    def can_be_wrong(cls, robot: Robot) -> bool:
        return robot.n > 1  # of one joint, torque_constant says the same

    def values(self, robot: Robot, signals: Signals) -> Array:
        return self.of_part(robot, signals.from_model("motor").T)

    def measure(self, robot: Robot, theta: Array, signals: Signals) -> Signals:
        assert signals.torque is not None
        return replace(signals, torque=signals.torque * (1 + self.shares(robot, theta)))

    def in_words(self, robot: Robot, theta: Array) -> str:
        size, way = sized(self.shares(robot, theta))
        size = f"{size} {way}" if way else size
        return f"The torques of all joints are {size} than the model's, as with drive gains or a unit of another size."

    def numpy_source(self, robot: Robot, theta: Array) -> str:
        return f"{array_source(self.shares(robot, theta))} * motor"
