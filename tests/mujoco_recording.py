"""Recordings of a MuJoCo arm, made in MuJoCo."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

Array = np.ndarray


def record(text: str, seed: int, duration: float = 15.0, noise: float = 1.0) -> Array:
    """Rows time, q, dq, tau of a MuJoCo arm that follows a multisine, of its actuators' torques; ``noise`` 1 is 0.05 N m."""
    model = mujoco.MjModel.from_xml_string(text)
    data, wanted, n = mujoco.MjData(model), mujoco.MjData(model), model.nv
    rng = np.random.default_rng(seed)
    rates = 2 * np.pi * 0.1 * np.arange(1, 6)
    sines, cosines = 0.5 * rng.normal(size=(2, n, 5)) / np.arange(1, 6)

    def reference(t: float) -> Array:
        rise = np.clip([(t - 0.5) / 2, (duration - 0.5 - t) / 2], 0, 1)
        envelope = np.prod(rise**3 * (10 - 15 * rise + 6 * rise**2))
        return envelope * (sines @ np.sin(rates * t) + cosines @ np.cos(rates * t))

    rows, h = [], 1e-4
    for k in range(int(duration / model.opt.timestep)):
        t = k * model.opt.timestep
        before, now, after = reference(t - h), reference(t), reference(t + h)
        wanted.qpos[:], wanted.qvel[:] = now, (after - before) / (2 * h)
        wanted.qacc[:] = (after - 2 * now + before) / h**2
        mujoco.mj_inverse(model, wanted)
        torque = wanted.qfrc_inverse + 400 * (now - data.qpos) + 40 * (wanted.qvel - data.qvel)
        data.ctrl[:] = torque / model.actuator_gear[:, 0]
        measured = np.concatenate([[t], data.qpos, data.qvel, torque])
        mujoco.mj_step(model, data)
        if k % 5 == 0:
            rows.append(measured)
    table = np.array(rows)
    table[:, 1:] += rng.normal(size=(len(table), 3 * n)) * np.repeat([1e-5 * noise, 1e-3 * noise, 0.05 * noise], n)
    return table


def written(folder: Path, name: str, table: Array) -> str:
    n = table.shape[1] // 3
    head = ",".join(["time", *(f"{kind}_{j}" for kind in ("q", "dq", "tau") for j in range(1, n + 1))])
    np.savetxt(folder / name, table, delimiter=",", header=head, comments="", fmt="%.12g")
    return str(folder / name)
