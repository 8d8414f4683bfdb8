"""The torque of each exported file of the UR10e's models beside the model's own, and MuJoCo's dynamics of the MJCF."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
from hidden import described
from ur10e import models

import physident as pid
from physident.estimation.estimate import as_estimate
from physident.export.mjcf.callback import with_callback
from physident.export.mjcf.mjcf import mjcf_of
from physident.export.urdf import urdf_of
from physident.replay.replay import replay

OFF = mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS | mujoco.mjtDisableBit.mjDSBL_LIMIT | mujoco.mjtDisableBit.mjDSBL_CONTACT
DRY = ("coulomb_friction", "presliding_hysteresis")


def study() -> tuple[dict, list[str]]:
    before, after, fitted, held_out = models()
    results: dict = {}
    rows = ["100 |measured - predicted| / |measured| [%]       joint 1      2      3      4      5      6"]
    for name, estimate in (("before", before), ("after", after)):
        mjcf = mjcf_of(estimate.model).held
        parts = {"the model": estimate.model, "URDF": urdf_of(estimate.model).held.model, "MJCF": mjcf.model}
        if mjcf.left_out:
            parts["MJCF with its callback"] = with_callback(mjcf).model
        for form, model in parts.items():
            score = pid.validate(replace(estimate, model=model), fitted, include_fitted=True)
            results[f"{name}: {form}"] = score.relative.tolist()
            rows.append(f"{name + ': ' + form:<50}" + "".join(f"{x:7.2f}" for x in score.relative))
    results["inverse_dynamics"] = inverse = inverse_error(before.model, pid.prepare(held_out[0], before.filter))
    results["forward_percent_of_range"] = forward = forward_error()
    rows += [
        "",
        f"MuJoCo's inverse dynamics of the MJCF along the held-out run, without dry friction: {inverse:.1e} of the largest torque",
        f"a UR5 with friction one second ahead in MuJoCo, under the torque of simulate: within {forward:.2f} % of each joint's range",
    ]
    return results, rows


def inverse_error(model: pid.Model, states: pid.Signals) -> float:
    """Largest difference of MuJoCo's inverse dynamics from the model's torque, of the largest torque."""
    compiled = mujoco.MjModel.from_xml_string(mjcf_of(model).text)
    compiled.opt.disableflags |= OFF
    data = mujoco.MjData(compiled)
    found = np.zeros_like(states.q)
    for k, state in enumerate(zip(states.q, states.v, states.a, strict=True)):
        data.qpos[:], data.qvel[:], data.qacc[:] = state
        mujoco.mj_inverse(compiled, data)
        found[k] = data.qfrc_inverse
    kept = [(e, t) for e, t in model.effect_parameters() if e.name not in DRY and e.acts_on == "plant"]
    plant = pid.Model(model.robot, tuple(e for e, _ in kept), np.concatenate([t for _, t in kept]))
    expected = plant.torque(states)
    return float(np.abs(found - expected).max() / np.abs(expected).max())


def forward_error() -> float:
    """The largest error (RMS over starts) of a joint after a second in MuJoCo, in % of its range."""
    model = described(True)
    run = pid.simulate(model, pid.random_trajectory(model.robot, seed=1, duration=20.0))
    score = replay(as_estimate(model, pid.Filter()), None, [run], "mujoco", 1.0).replay.before
    return float((100 * score.position / np.ptp(run.q, axis=0)).max())
