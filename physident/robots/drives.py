"""What a description says of a joint beside its links: motor and gear, or the passive torques that a simulator adds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from physident.errors import InputError
from physident.robots.dh_table import DRIVE, LARGEST


@dataclass(frozen=True)
class Drive:
    """One joint's motor and gear: ratio G [-], torque constant [N m/A], rotor inertia [kg m^2] and the motor's Coulomb
    friction in either direction [N m], on the motor's side (thesis Table 2.5)."""

    gear_ratio: float
    torque_constant: float
    motor_inertia: float
    motor_friction: tuple[float, float]

    def __post_init__(self) -> None:
        for name, size in DRIVE.items():
            values = np.asarray(getattr(self, name))
            if values.dtype.kind not in "if" or values.size != max(size, 1) or not (np.abs(values) <= LARGEST).all():
                raise InputError(f"drive: {name} is {getattr(self, name)!r}, expected {max(size, 1)} finite numbers")


@dataclass(frozen=True, kw_only=True)
class JointDynamics:
    """What a simulator adds to the rigid links at one joint, on the joint's side.

    ``armature`` [kg m^2|kg], ``damping`` [N m s/rad|N s/m], dry ``friction`` [N m|N], ``stiffness`` [N m/rad|N/m] of a
    spring that is slack at ``spring_position`` [rad|m], and the actuator's ``gear`` [-]: joint torque per actuator force.
    The friction acts against the velocity that the joint would have after ``friction_lead`` [s] at its acceleration, and
    has its full size where that is above ``friction_width`` [rad/s|m/s]. The damping acts against the velocity after
    ``damping_lead`` [s]: where it is that of a step's end, half a step.
    """

    armature: float = 0.0
    damping: float = 0.0
    damping_lead: float = 0.0
    friction: float = 0.0
    friction_lead: float = 0.0
    friction_width: float = 0.0
    stiffness: float = 0.0
    spring_position: float = 0.0
    gear: float = 1.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if type(value) not in (int, float) or not abs(value) <= LARGEST:
                raise InputError(f"joint dynamics: {name} is {value!r}, expected a finite number")
