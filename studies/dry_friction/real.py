"""The default model on real arms: a UR10e, a UR5, a Staubli TX40 and, where its recording was converted, a UR10."""

from __future__ import annotations

import sys
import tempfile
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import numpy as np
from kept import UR5_GAINS, UR10E_COLUMNS, UR10E_GAINS, need_data
from numpy.typing import NDArray

import physident as pid


def real_arms() -> dict[str, list[float]]:
    """Relative error (6,) [%] of all rows on recordings that were not fitted, for each arm."""
    return {**ur10e(), **ur5(), **tx40(), **ur10()}


def ur10e() -> dict[str, list[float]]:
    """Eight runs, each predicted from the seven others."""
    data = need_data("ur10e")
    robot = pid.load_robot(data / "ur10e.urdf")
    runs = pid.load_recordings(str(data / "ur-20_02_*.csv"), columns=UR10E_COLUMNS, drive_gains=UR10E_GAINS)
    each = []
    for left_out, run in enumerate(runs):
        estimate = pid.identify(robot, [one for i, one in enumerate(runs) if i != left_out])
        each.append(pid.validate(estimate, [run]).relative_all)
    return {"UR10e, eight runs": np.mean(each, axis=0).tolist()}


def ur5() -> dict[str, list[float]]:
    """Two unseen movements."""
    data, robot = need_data("ur5"), pid.load_robot("ur5")

    def load(*names: str) -> list[pid.Recording]:
        return pid.load_recordings([data / f"{name}.csv.gz" for name in names], drive_gains=UR5_GAINS)

    estimate = pid.identify(robot, load("move6", "move5", "move9"), filter=pid.Filter(8.0))
    return {f"UR5, {name}": pid.validate(estimate, load(name)).relative_all.tolist() for name in ("move8", "move7")}


def tx40() -> dict[str, list[float]]:
    """The second half of a recording from the first."""
    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "real_arms"))
    from tx40_coupling import recordings  # pyright: ignore[reportMissingImports]

    robot = pid.load_robot(need_data("tx40") / "tx40_mdh_modified.urdf")
    with tempfile.TemporaryDirectory() as folder:
        files = recordings(Path(folder))
        estimate = pid.identify(robot, [pid.load_recording(files["first"])])
        return {
            "TX40, second half": pid.validate(estimate, [pid.load_recording(files["second"])]).relative_all.tolist()
        }


def ur10() -> dict[str, list[float]]:
    """The last 30 % of a recording from the first 70 %; nothing where the package with the arm's description is missing."""
    try:
        files = distribution("example-robot-data").files or []
    except PackageNotFoundError:
        print("no package example-robot-data: the UR10 is left out")
        return {}
    (path,) = [file.locate() for file in files if str(file).endswith("ur_description/urdf/ur10_robot.urdf")]
    robot = pid.load_robot(str(path))
    whole = pid.load_recording(need_data("rosbag2") / "ur10_exciting_trajectory.db3", joints=robot.joint_names)
    cut = whole.time[0] + 0.7 * (whole.time[-1] - whole.time[0])
    first, last = (_rows(whole, rows) for rows in (whole.time <= cut, whole.time > cut))
    return {"UR10, last 30 %": pid.validate(pid.identify(robot, first), last).relative_all.tolist()}


def _rows(recording: pid.Recording, rows: NDArray[np.bool_]) -> pid.Recording:
    dq = None if recording.dq is None else recording.dq[rows]
    return pid.Recording.from_arrays(recording.time[rows], recording.q[rows], recording.effort[rows], dq)
