"""Position control: a damped spring about the plan, with the torque that the plan needs by the ordinary arm's model."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco as mj
import numpy as np
from numpy.typing import NDArray

from tests.plant_mujoco.bodies import compiled
from tests.plant_mujoco.machine import ordinary
from tests.truth import ArmTruth

Array = NDArray[np.float64]
DAMPING = 0.85  # of critical
POSES = 24


@dataclass(frozen=True, eq=False)
class Control:
    """Asked torque = ``command`` - ``stiffness`` q - ``damping`` v, with rows (n,) and commands (N, n) [N m]."""

    stiffness: Array
    damping: Array
    command: Array


def control(arm: ArmTruth, plan: tuple[Array, Array, Array]) -> Control:
    """Control for a plan (N, n) of position, velocity and acceleration; it knows neither friction nor hidden effects.

    The gains give each joint the arm's bandwidth with its mean inertia over poses within its limits.
    """
    made = ordinary(arm)
    bodies = compiled(made, made.links)
    model, data = bodies.model, bodies.data
    inertia, full = np.zeros(arm.joints), np.zeros((arm.joints, arm.joints))
    for share in np.random.default_rng(5).random((POSES, arm.joints)):
        data.qpos[:] = arm.lower + share * (arm.upper - arm.lower)
        mj.mj_fwdPosition(model, data)
        mj.mj_fullM(model, data, full)
        inertia += (np.diag(full) + made.rotor) / POSES
    stiffness, damping = arm.bandwidth**2 * inertia, 2 * DAMPING * arm.bandwidth * inertia
    q, v, a = plan
    needed = rigid_torque(bodies.model, bodies.data, q, v, a) + made.rotor * a
    return Control(stiffness, damping, needed + stiffness * q + damping * v)


def rigid_torque(model: mj.MjModel, data: mj.MjData, q: Array, v: Array, a: Array) -> Array:
    """Torque (N, nv) [N m] of inertia and gravity at positions (N, nq), velocities and accelerations (N, nv)."""
    torque = np.empty(v.shape)
    position, velocity, acceleration = data.qpos, data.qvel, data.qacc
    for k in range(len(q)):
        position[:], velocity[:], acceleration[:] = q[k], v[k], a[k]
        mj.mj_kinematics(model, data)
        mj.mj_comPos(model, data)
        mj.mj_comVel(model, data)
        mj.mj_rne(model, data, 1, torque[k])
    return torque
