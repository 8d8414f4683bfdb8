"""The same arm in the independent plant: under control, with encoders, recorded - for the diagnosis to look at.

The plant of ``tests/plant`` integrates the arm's forward dynamics; its links are the published ones, its friction
and motor inertia are those of Table 2.5 at the joint, and nothing else. Friction turns near zero speed as the estimator has it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

import physident as pid
from studies.designed_plant import Plan
from studies.thesis.currents import measured_torque
from studies.thesis.published import COULOMB, OFFSET, ROTOR_INERTIA
from tests.exact_friction import exact_arm
from tests.plant import Arm, Controller, Drives, Friction, Sensors, record

Array = NDArray[np.float64]
SENSORS = Sensors(torque_noise=(0.0,) * 6)


def arm(friction: bool) -> Arm:
    """The published arm, with the friction of Table 2.5 or none; what differs by direction is an offset in motion."""
    coulomb, offset = (COULOMB, OFFSET) if friction else np.zeros((2, 6))
    drives = Drives(rotor_inertia=ROTOR_INERTIA, torque_offset=offset)
    return exact_arm(Arm(friction=Friction(np.zeros(6), coulomb), drives=drives))


def recorded(arm: Arm, motion: pid.Trajectory, seed: int, noise: bool, name: str) -> pid.Recording:
    """A recording of the arm; with ``noise`` the torque went through noisy currents (eq. 4.7-4.9)."""
    controller = replace(Controller(), rotor_inertia=tuple(ROTOR_INERTIA))
    made = record(arm, Plan(motion), SENSORS, seed, arm, controller)
    torque = measured_torque(made.effort, np.random.default_rng(seed)) if noise else made.effort
    return pid.Recording(made.time, made.q, torque, "torque", made.dq, source=name)
