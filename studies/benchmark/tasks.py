"""The held-out tasks: which recordings of which arm may be fitted, and which are predicted. Splits and filter are fixed."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from kept import UR5_GAINS, UR10E_COLUMNS, UR10E_GAINS, need_data

import physident as pid

SHARE = 0.7  # of a single recording is fitted, the rest is predicted


@dataclass(frozen=True, kw_only=True)
class Task:
    """Recordings to fit (``train``) and one to predict (``test``) of a robot, judged after a low-pass at ``cutoff`` [Hz]."""

    name: str
    robot: pid.Robot
    train: Sequence[pid.Recording]
    test: pid.Recording
    cutoff: float


def tasks() -> Iterator[Task]:
    """Every task, in the order of the table; ends with one line where the recordings are absent."""
    yield from _ur10e()
    yield from _ur5()
    yield from _bag("ur10", "ur10_exciting_trajectory.db3", 3.0)
    yield from _bag("panda", "panda_exciting_trajectory.db3", 3.0)


def _ur10e() -> Iterator[Task]:
    """Each of the eight runs of February is predicted from the seven others."""
    data = need_data("ur10e")
    robot = pid.load_robot(data / "ur10e.urdf")
    paths = sorted(data.glob("ur-20_02_*.csv"))
    runs = [pid.load_recording(path, columns=UR10E_COLUMNS, drive_gains=UR10E_GAINS) for path in paths]
    for k, (path, run) in enumerate(zip(paths, runs, strict=True)):
        others = [other for i, other in enumerate(runs) if i != k]
        yield Task(name=f"ur10e_{path.stem.removeprefix('ur-20_')}", robot=robot, train=others, test=run, cutoff=5.0)


def _ur5() -> Iterator[Task]:
    """Two movements, predicted from three others."""
    data = need_data("ur5")
    runs = {
        name: pid.load_recording(data / f"{name}.csv.gz", drive_gains=UR5_GAINS)
        for name in ("move5", "move6", "move7", "move8", "move9")
    }
    train = [runs[name] for name in ("move6", "move5", "move9")]
    for name in ("move8", "move7"):
        yield Task(name=f"ur5_{name}", robot=pid.load_robot("ur5"), train=train, test=runs[name], cutoff=8.0)


def _bag(arm: str, file: str, cutoff: float) -> Iterator[Task]:
    """The end of a single recording, predicted from its beginning."""
    robot = pid.load_robot(arm)
    rows = pid.load_recording(need_data("rosbag2") / file, joints=robot.joint_names).to_pandas()
    border = rows["time"].iloc[0] + SHARE * (rows["time"].iloc[-1] - rows["time"].iloc[0])
    first = pid.Recording.from_frame(rows[rows["time"] < border], source=f"{arm}, first part")
    rest = pid.Recording.from_frame(rows[rows["time"] >= border], source=f"{arm}, rest")
    yield Task(name=arm, robot=robot, train=[first], test=rest, cutoff=cutoff)
