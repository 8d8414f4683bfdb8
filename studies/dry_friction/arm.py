"""Recordings of a UR5 whose joints stick, bristle or slide smoothly, by instruments of several kinds."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import physident as pid
from studies.open_world.motions import fourier
from studies.open_world.sensors import Sensors
from studies.open_world.taken import Taken, take
from tests.plant_mujoco import MujocoPlant
from tests.serial_arms import Kind
from tests.truth import ArmTruth, FrictionTruth

Array = NDArray[np.float64]
CACHE = Path(os.environ.get("PHYSIDENT_CACHE", Path.home() / ".cache" / "physident")) / "dry_friction"
DURATION, RATE = 40.0, 125.0
COULOMB = np.array([12.0, 14.0, 9.0, 2.5, 2.2, 1.8])  # N m: a third of each joint's torque or so
INSTRUMENTS = {  # encoder step [rad], velocity noise [rad/s]; None: no velocity
    "clean": (1e-7, 0.0),
    "1e-3": (5e-5, 1e-3),
    "5e-3": (5e-5, 5e-3),
    "absent": (5e-5, None),
}


def arm(kind: Kind) -> ArmTruth:
    """A UR5 with the links of its description, and friction of one kind; nothing else is wrong."""
    robot = pid.load_robot("ur5")
    n = robot.n
    friction = FrictionTruth(
        kind=kind,
        coulomb=COULOMB,
        viscous=np.array([10.0, 12.0, 8.0, 1.5, 1.4, 1.2]),
        breakaway=COULOMB * (1.2 if kind == "bristle" else 1.0),
        stribeck_speed=np.full(n, 0.02),
        bristle_stiffness=COULOMB / 0.0008,
        bristle_damping=np.array([3.0, 3.0, 2.0, 0.4, 0.4, 0.3]),
        width=np.full(n, 0.01),
        per_degree=np.zeros(n),
    )
    rigid = pid.Model.nominal(robot, ("rigid_body",)).theta
    return ArmTruth(
        name="ur5", urdf=robot.urdf, tool="tool0", links=rigid.reshape(n, 10),
        rotor_inertia=np.array([3.0, 3.5, 1.5, 0.4, 0.35, 0.3]), torque_offset=np.array([0.5, -0.8, 0.3, 0.1, -0.1, 0.05]),
        friction=friction, lower=np.full(n, -2.2), upper=np.full(n, 2.2), top_speed=np.full(n, 1.5),
        top_acceleration=np.full(n, 3.0), bandwidth=40.0,
    )  # fmt: skip


def runs(kind: Kind, instrument: str) -> list[Taken]:
    """Four recordings of different motions; the last is for judging."""
    step, noise = INSTRUMENTS[instrument]
    sensors = Sensors(
        rate=RATE, encoder_step=step, velocity="absent" if noise is None else "measured", velocity_noise=noise or 0.0,
        torque_noise=tuple(0.004 * COULOMB * 3),
    )  # fmt: skip
    truth = arm(kind)
    taken = []
    for k in range(4):
        motion = fourier(truth, np.random.default_rng([71, k]), DURATION, 0.8)
        path = CACHE / kind / instrument / f"run{k}"
        taken.append(take(path, MujocoPlant(), truth, motion, sensors, 40 + k, 0.0, known=False))
    return taken
