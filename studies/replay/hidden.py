"""Arms in MuJoCo with one hidden effect: recorded, diagnosed against their MJCF, corrected there, and replayed."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

import physident as pid
from physident.estimation.estimate import as_estimate
from physident.replay.replay import replay
from physident.robots.inertia import link_parameters

NAMES = ("rigid_body", "rotor_inertia", "viscous_friction", "coulomb_friction")
STEP, RATE = 5e-4, 125.0  # s, Hz
NOISE = (2e-5, 1e-3, 0.2)  # rad, rad/s, N m
HIDDEN = ("payload", "damping", "frictionloss", "armature", "gravity")


def described() -> pid.Model:
    """The arm as its MJCF states it."""
    robot = pid.load_robot("ur5")
    rotors, viscous = [2.0, 2.0, 1.0, 0.4, 0.4, 0.4], [12.0, 12.0, 8.0, 2.0, 2.0, 2.0]
    dry = [6.0, 6.0, 4.0, 1.0, 1.0, 1.0]
    return pid.Model(robot, pid.make_effects(NAMES), np.concatenate([robot.nominal, rotors, viscous, dry]))


def true_arm(hidden: str) -> pid.Model:
    model = described()
    theta, effects = model.theta.copy(), model.effects
    if hidden == "payload":
        body = np.zeros((4, 4))
        body[:3, :3], body[:3, 3], body[3, 3] = np.diag([0.02, 0.02, 0.04]), [0.0, 0.06, 0.04], 1.8
        effects, theta = (*effects, *pid.make_effects([hidden])), np.append(theta, link_parameters(body))
    elif hidden == "gravity":
        effects, theta = (*effects, *pid.make_effects(["gravity_tilt"])), np.append(theta, [0.5, -0.4])
    else:
        at = {"armature": 61, "damping": 68, "frictionloss": 73}[hidden]
        theta[at] *= 1.8
    return pid.Model(model.robot, effects, theta)


def record(model: pid.Model, path: Path, seed: int) -> pid.Recording:
    """A recording of the arm of an MJCF file, held on a random motion by a PD controller with the arm's own torque ahead."""
    arm = mujoco.MjModel.from_xml_path(str(path))
    arm.opt.timestep = STEP
    data = mujoco.MjData(arm)
    motion = pid.random_trajectory(model.robot, seed=seed, duration=30.0)
    time, q, v, a = motion.sample(1 / STEP)
    ahead = described().torque(pid.Signals.of_states(q, v, a))
    stiffness = 400.0 * np.array([8.0, 8.0, 4.0, 1.0, 1.0, 1.0])
    every, rows = round(1 / (RATE * STEP)), []
    data.qpos[:] = q[0]
    for k in range(len(time)):
        torque = ahead[k] + stiffness * (q[k] - data.qpos) + 0.05 * stiffness * (v[k] - data.qvel)
        if k % every == 0:
            rows.append([data.qpos.copy(), data.qvel.copy(), torque])
        data.qfrc_applied[:] = torque
        mujoco.mj_step(arm, data)
    table = np.array(rows) + np.array(NOISE)[None, :, None] * np.random.default_rng(seed).normal(size=(len(rows), 3, 6))
    return pid.Recording(
        np.arange(len(rows)) / RATE, table[:, 0], table[:, 2], "torque", dq=table[:, 1], source=f"run {seed}"
    )


def study() -> tuple[dict, list[str]]:
    results: dict = {}
    rows = ["tool's error 0.5 s ahead in MuJoCo [mm], on a run that was not diagnosed", ""]
    rows.append(f"{'hidden':<14}{'before':>8}{'patched':>9}{'the truth':>11}   found")
    for hidden in HIDDEN:
        start, truth = described(), true_arm(hidden)
        with tempfile.TemporaryDirectory() as folder:
            theirs, mine = Path(folder, "truth.xml"), Path(folder, "mine.xml")
            pid.export_mjcf(truth, theirs)
            pid.export_mjcf(start, mine)
            runs = [record(truth, theirs, seed) for seed in (1, 2, 3)]
            found = pid.diagnose_motion(start, runs[:2])
            after = found.estimate
            if after is not None:
                pid.patch_mjcf(after.model, mine)
        held = [runs[2]]
        before, exact = (as_estimate(model, found.filter) for model in (start, truth))
        first = replay(before, exact, held).replay
        patched = (
            first.before.tool
            if after is None
            else replay(replace(after, filter=found.filter), None, held).replay.before.tool
        )
        assert first.after is not None
        names = ", ".join(f"{f.effect} {list(f.joints)}" for f in found.findings) or "nothing"
        results[hidden] = {"before": first.before.tool, "patched": patched, "truth": first.after.tool, "found": names}
        rows.append(
            f"{hidden:<14}{1e3 * first.before.tool:8.2f}{1e3 * patched:9.2f}{1e3 * first.after.tool:11.2f}   {names}"
        )
    return results, rows
