"""The same task by figaroh, as its documentation has it: `figaroh_arm.py TASK fit|wls|physical_fit CUTOFF OUT`.

Its class for identification is subclassed once for a robot. Here the subclass reads the CSV files of a task, and filters
each recording by itself before they are joined, because figaroh's filter would run across their ends.
"""

from __future__ import annotations

import contextlib
import logging
import sys
import tempfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import yaml
from figaroh.identification.base_identification import BaseIdentification  # pyright: ignore[reportMissingImports]
from figaroh.tools.regressor import build_regressor_basic, build_regressor_reduced  # pyright: ignore[reportMissingImports]
from figaroh.tools.robot import load_robot  # pyright: ignore[reportMissingImports]
from program import Call, Stages, columns

Array = np.ndarray
SMOOTH = 2.0  # motion is filtered at this many times the cutoff
MOVING, BEFORE = 0.02, 0.2  # rad/s; s, kept before and after the motion
LARGEST_DECIMATION = 10  # figaroh's own factor
NAMES = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
DERIVED = {
    "velocities": None,
    "accelerations": None,
}  # figaroh derives them from positions, as in its example of a UR10
Run = dict[str, Any]  # of arrays; None where nothing was measured


def read(path: Path, moving: bool) -> Run:
    """A recording as figaroh wants it, on a uniform clock."""
    table = pd.read_csv(path)
    t = table["time"].to_numpy()
    time = np.arange(t[0], t[-1], np.median(np.diff(t)))
    run: Run = {"timestamps": time}
    for name, column in (("positions", "q"), ("velocities", "dq"), ("torques", "tau")):
        x = columns(table, column)
        run[name] = np.column_stack([np.interp(time, t, x[:, j]) for j in range(x.shape[1])]) if x.size else None
    if moving:
        fast = np.flatnonzero(np.abs(run["velocities"]).max(axis=1) > MOVING)
        margin = round(BEFORE / (time[1] - time[0]))
        rows = slice(max(fast[0] - margin, 0), fast[-1] + margin + 1)
        run = {name: x[rows] for name, x in run.items()}
    return run


def bare(urdf: Path, folder: str) -> str:
    """A copy of a description without shapes: figaroh refuses one whose meshes are not there."""
    tree = ElementTree.parse(urdf)
    for link in tree.getroot().iter("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(shape)
    path = Path(folder, "robot.urdf")
    tree.write(path)
    return str(path)


def configuration(joints: list[str], rate: float, call: Call, n: int) -> dict:
    """figaroh's own kind of file: all four effects of its joints, and the stage that is asked for.

    Its physical fit takes the weights of its weighted fit; without them its solver fails on most of these tasks.
    """
    parts = {"friction": True, "joint_offset": True, "actuator_inertia": True}
    zero = [0.0] * n
    mechanics = {
        "friction_coefficients": {"viscous": zero, "static": zero},
        "actuator_inertias": zero,
        "joint_offsets": zero,
        "reduction_ratios": [1.0] * n,
    }
    task = {
        "enabled": True,
        "problem": {"use_joint_torques": True, "model_components": parts, "wls": call.method != "fit"},
        "signal_processing": {"sampling_frequency": rate, "cutoff_frequency": SMOOTH * call.cutoff, "filter_order": 4},
        "reconstruction": {"enabled": True},
        "select_stage": "physical_fit" if call.method == "physical_fit" else "fit",
    }
    properties = {"joints": {"active_joints": joints}, "mechanics": mechanics, "coupling": {"has_coupled_wrist": False}}
    return {"robot": {"name": "arm", "properties": properties}, "tasks": {"identification": task}}


class Arm(BaseIdentification):
    """One arm, from recordings that were read beforehand."""

    def __init__(self, robot, file: str, runs: list[Run]) -> None:
        self.runs = runs
        super().__init__(robot, file)
        joints = [self.model.joints[k] for k in range(1, self.model.njoints)]
        self.identif_config |= {"act_idxq": [j.idx_q for j in joints], "act_idxv": [j.idx_v for j in joints]}

    def load_trajectory_data(self, data_source: str | None = None) -> Any:
        joined = {name: np.concatenate([run[name] for run in self.runs]) for name in self.runs[0]}
        return joined | DERIVED

    def process_kinematics_data(self, filter_config: dict | None = None) -> None:
        joined, parts = self.raw_data, []
        for run in self.runs:
            self.raw_data = run | DERIVED
            self.filter_kinematics_data(filter_config)
            parts.append(self.processed_data)
        self.raw_data = joined
        self.processed_data = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def predicted(arm: Any, run: Run) -> Array:
    """Torque (N, n) of the selected estimate along a recording."""
    arm.runs, arm.raw_data = [run], run
    arm.process_kinematics_data(arm.filter_config)
    q, v, a = (arm.processed_data[name] for name in ("positions", "velocities", "accelerations"))
    W = build_regressor_basic(arm.robot, q, v, a, arm.identif_config)
    if arm.selected is not None:
        assert arm.selected.accepted, f"figaroh rejected its estimate: {arm.selected.reason}"
        rows = arm.selected.predict(W)
    else:  # the columns that its own check on other recordings takes
        rows = build_regressor_reduced(W, arm._idx_eliminated)[:, arm._base_indices] @ arm.phi_base
    return rows.reshape(-1, len(q)).T


def parameters(arm: Any) -> dict[str, Array]:
    """Links and friction of the selected estimate, or of figaroh's reconstruction from its base parameters."""
    if arm.selected is not None:
        values = dict(zip(arm.selected.names, arm.selected.values, strict=True))
    else:
        values = arm.standard_parameter | arm.result["reconstruction"]["theta_r_dict"]
    joints = list(arm.model.names)[1:]
    return {
        "links": np.array([values[f"{name}_{joint}"] for joint in joints for name in NAMES], dtype=float),
        "viscous": np.array([values[f"fv_{joint}"] for joint in joints], dtype=float),
        "dry": np.array([values[f"fs_{joint}"] for joint in joints], dtype=float),
    }


def main() -> None:
    logging.disable(logging.WARNING)
    call, stages = Call.read(), Stages()
    stages.end("imports")
    with contextlib.redirect_stdout(sys.stderr), tempfile.TemporaryDirectory() as folder:
        robot = load_robot(bare(call.task / "robot.urdf", folder), package_dirs=folder)
        runs = [read(path, True) for path in sorted(call.task.glob("train_*.csv"))]
        rate = float(1 / np.median(np.diff(runs[0]["timestamps"])))
        file, joints = Path(folder, "arm.yaml"), list(robot.model.names)[1:]
        file.write_text(yaml.safe_dump(configuration(joints, rate, call, len(joints))), encoding="utf-8")
        arm = Arm(robot, str(file), runs)
        stages.end("read")
        arm.initialize()
        stages.end("regressor")
        factor = min(LARGEST_DECIMATION, round(0.4 * rate / call.cutoff))  # its filter ends at 0.4 of the new rate
        arm.solve(decimation_factor=factor, plotting=False, wls=call.method != "fit")
        stages.end("fit")
        found = parameters(arm)
        test = read(call.task / "test.csv", False)
        torque = predicted(arm, test)
        stages.end("predict")
    call.answer(stages, test["timestamps"], torque, **found)


if __name__ == "__main__":
    main()
