"""The arm's position control: proportional and derivative action about the plan, with a nominal model's torque ahead."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from tests.plant.arm import Arm
from tests.plant.drives import ROTOR_INERTIA

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Controller:
    """tau_m = proportional (q_plan - q) + derivative (v_plan - v) + rnea(q_plan, v_plan, a_plan) of the ordinary arm.

    q, v are the encoders'. Gains (n,) [N m/rad], [N m s/rad] place both poles of each joint's typical inertia at 60 rad/s;
    the model ahead knows the ordinary ``bodies``, gravity and ``rotor_inertia`` (n,) [kg m^2], no friction. Continuous in
    time.
    """

    proportional: tuple[float, ...] = (16000.0, 16000.0, 7200.0, 1400.0, 1100.0, 900.0)
    derivative: tuple[float, ...] = (530.0, 530.0, 240.0, 46.0, 37.0, 30.0)
    rotor_inertia: tuple[float, ...] = ROTOR_INERTIA
    bodies: Any = field(default_factory=lambda: Arm().bodies)

    def ahead(self, q: Array, v: Array, a: Array) -> Array:
        """What does not depend on the arm's state (N, n) [N m], for a plan (N, n)."""
        model = self.bodies.copy()
        model.armature[:] = self.rotor_inertia
        data = model.createData()
        nominal = np.array([pin.rnea(model, data, *state) for state in zip(q, v, a, strict=True)])
        return nominal + q * np.array(self.proportional) + v * np.array(self.derivative)
