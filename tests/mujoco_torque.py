"""MuJoCo's inverse dynamics of an exported file, and what a model says of the same torque."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

import physident as pid

Array = np.ndarray
OFF = mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS | mujoco.mjtDisableBit.mjDSBL_LIMIT | mujoco.mjtDisableBit.mjDSBL_CONTACT
DRY = ("coulomb_friction", "presliding_hysteresis")


def inverse_dynamics(compiled: Any, states: pid.Signals, names: tuple[str, ...]) -> Array:
    """MuJoCo's inverse dynamics (N, n) without friction loss, limits and contacts."""
    compiled.opt.disableflags |= OFF
    data = mujoco.MjData(compiled)
    q, v = (np.array([getattr(compiled.joint(name), a)[0] for name in names]) for a in ("qposadr", "dofadr"))
    torque = np.zeros(states.q.shape)
    for k in range(len(torque)):
        data.qpos[q], data.qvel[v], data.qacc[v] = states.q[k], states.v[k], states.a[k]
        mujoco.mj_inverse(compiled, data)
        torque[k] = data.qfrc_inverse[v]
    return torque


def without_dry(model: pid.Model, states: pid.Signals) -> Array:
    """The model's torque without dry friction and without effects of the torque measurement."""
    kept = [(e, t) for e, t in model.effect_parameters() if e.name not in DRY and e.acts_on == "plant"]
    return pid.Model(model.robot, tuple(e for e, _ in kept), np.concatenate([t for _, t in kept])).torque(states)
