"""The diagnosis on recordings of the independent plant: Coulomb friction in models B and D, a joint's shifted zero."""

from __future__ import annotations

import time
import warnings
from collections.abc import Mapping
from typing import Any

import physident as pid
from studies.thesis.plant import arm, recorded
from studies.thesis.published import COULOMB
from studies.thesis.reference import run
from tests.plant import hide

ZERO_JOINT, ZERO_OFFSET = 2, 0.02  # rad


def of_model(model: str, robot: pid.Robot, motions: Mapping[str, pid.Trajectory]) -> dict[str, Any]:
    """What the nominal arm without friction lacks, by a recording of the designed trajectory in model B or D."""
    noise = model == "d"
    train = recorded(arm(True), motions["designed"], 3, noise, "designed trajectory")
    holdout = recorded(arm(True), motions["validation"], 4, noise, "second trajectory")
    nominal = pid.Model.nominal(robot, ["rigid_body", "rotor_inertia"])
    data = _diagnosed(nominal, train, holdout)
    named = {v["joint"]: v for f in data["findings"] if f["effect"] == "coulomb_friction" for v in f["parameters"]}
    data["coulomb_joints"] = sorted(named)
    data["coulomb_off_percent"] = {j: 100 * (v["value"] / COULOMB[j - 1] - 1) for j, v in named.items()}
    data["table_2_5_times_gear_ratio"] = COULOMB.tolist()
    return data


def of_reference(model: str, robot: pid.Robot, motions: Mapping[str, pid.Trajectory]) -> dict[str, Any]:
    """The same of the reference itself: an ideal sign, exact velocities, no control and no encoders."""
    train, holdout = (run(model, motions[name], robot).recording(name) for name in ("designed", "validation"))
    return _diagnosed(pid.Model.nominal(robot, ["rigid_body"]), train, holdout)


def of_zero_offset(robot: pid.Robot, motions: Mapping[str, pid.Trajectory]) -> dict[str, Any]:
    """What is different when one joint's encoder zero has moved since the arm was identified."""
    before = [recorded(arm(True), motions[name], 5 + i, True, name) for i, name in enumerate(("designed", "thesis"))]
    healthy = pid.identify(robot, before)
    shifted = hide(arm(True), "joint_zero_offset", ZERO_JOINT, ZERO_OFFSET)
    now = recorded(shifted, motions["designed"], 7, True, "designed trajectory, later")
    later = recorded(shifted, motions["validation"], 8, True, "second trajectory, later")
    return {"joint": ZERO_JOINT, "hidden_rad": ZERO_OFFSET} | _diagnosed(healthy, now, later)


def _diagnosed(model: pid.Model | pid.Estimate, train: pid.Recording, holdout: pid.Recording) -> dict[str, Any]:
    started = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pid.PhysidentWarning)
        found = pid.diagnose_motion(model, [train], holdout=[holdout])
    data = found.as_dict()
    return {
        "question": data["question"],
        "verdict": data["verdict"],
        "findings": [{key: f[key] for key in ("effect", "joints", "parameters", "rivals")} for f in data["findings"]],
        "relative_before": data["score"]["before"]["relative_percent_all"],
        "relative_after": data["score"]["after"]["relative_percent_all"],
        "processor_s": time.process_time() - started,
    }
