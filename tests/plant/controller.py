"""The arm's position control: proportional and derivative action about the plan, with a nominal model's torque ahead."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from tests.plant.arm import Arm
from tests.plant.drives import ROTOR_INERTIA

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Controller:
    """tau_m = proportional (q_plan - q) + derivative (v_plan - v) + rnea(q_plan, v_plan, a_plan) of the ordinary arm.

    q, v are the encoders'. Gains (6,) [N m/rad], [N m s/rad] place both poles of each joint's typical inertia at 60 rad/s;
    the model ahead knows the ordinary links, gravity and ``rotor_inertia`` (6,) [kg m^2], no friction. Continuous in time.
    """

    proportional: tuple[float, ...] = (16000.0, 16000.0, 7200.0, 1400.0, 1100.0, 900.0)
    derivative: tuple[float, ...] = (530.0, 530.0, 240.0, 46.0, 37.0, 30.0)
    rotor_inertia: tuple[float, ...] = ROTOR_INERTIA

    def ahead(self, q: Array, v: Array, a: Array) -> Array:
        """What does not depend on the arm's state (N, 6) [N m], for a plan (N, 6)."""
        model = Arm().bodies
        model.armature[:] = self.rotor_inertia
        data = model.createData()
        nominal = np.array([pin.rnea(model, data, *state) for state in zip(q, v, a, strict=True)])
        return nominal + q * np.array(self.proportional) + v * np.array(self.derivative)
