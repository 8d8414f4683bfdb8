"""Checks that a compiled MuJoCo model has the dynamics of the model that was written into it."""

from __future__ import annotations

from typing import Any

import numpy as np

from physident.dynamics.inverse_dynamics import gravity_torque, inverse_dynamics
from physident.dynamics.model import Model
from physident.errors import InputError
from physident.export.mjcf.match import Match
from physident.export.mjcf.values import MjcfValues
from physident.export.mujoco import mujoco_module

SAME = 1e-6  # relative difference of inverse dynamics: MuJoCo rotates every inertia to principal axes


def check_dynamics(compiled: Any, model: Model, values: MjcfValues, found: Match, source: str) -> None:
    """Raises InputError unless the patched file's inverse dynamics are those of the model's bodies and rotors."""
    mujoco = mujoco_module()

    robot, data = model.robot, mujoco.MjData(compiled)
    if compiled.nv != robot.n:
        return  # joints of a gripper, say, whose bodies the model has as part of its last link
    armature = compiled.dof_armature[found.velocities]
    q, v, a = np.random.default_rng(0).uniform(-1.0, 1.0, size=(3, 10, robot.n))
    expected = inverse_dynamics(robot, values.links.ravel(), q, v, a) + armature * a
    added = np.array(model.added_inertia().gravity)
    if added.any():
        expected = expected + gravity_torque(robot, values.links.ravel(), q, added)
    torques = np.zeros_like(expected)
    for k in range(len(q)):
        data.qpos[found.positions], data.qvel[found.velocities] = q[k], v[k]
        mujoco.mj_forward(compiled, data)
        product, whole = np.zeros(compiled.nv), np.zeros(compiled.nv)
        whole[found.velocities] = a[k]
        mujoco.mj_mulM(compiled, data, product, whole)
        torques[k] = (product + data.qfrc_bias)[found.velocities]
    error = np.abs(torques - expected).max(axis=0) / np.abs(expected).max()
    if error.max() > SAME:
        joint = int(np.argmax(error))
        raise InputError(
            f"{source}: after the patch, joint {joint + 1} ({robot.joint_names[joint]}) would not have the model's torque, by {100 * error[joint]:.2g} %; is gravity another one, or does <compiler> override <inertial> (inertiafromgeom, balanceinertia, settotalmass)?"
        )
