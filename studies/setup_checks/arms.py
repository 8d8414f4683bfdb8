"""Arms with their descriptions and healthy recordings: five real ones, and simulated ones of the open world."""

from __future__ import annotations

import re
import sqlite3
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.recordings.channels import Channels
from physident.recordings.recording import recording_from_rows
from studies.kept import DATA, UR5_GAINS, UR10E_COLUMNS, UR10E_GAINS
from studies.open_world.bench import plants
from studies.open_world.world import FirstWorld
from tests.truth import ArmTruth, Motion

Array = NDArray[np.float64]
DURATION = 20.0  # s of each simulated recording
DAYS = 2  # recordings of each simulated arm, of different kinds of motion


@dataclass(frozen=True, eq=False)
class Arm:
    """A name, the description and healthy recordings that belong together; of simulated arms also their truth and plans."""

    name: str
    robot: pid.Robot
    recordings: tuple[pid.Recording, ...]
    truth: ArmTruth | None = None
    plans: tuple[Motion, ...] = ()


def real_arms() -> Iterator[Arm]:
    """UR10e, UR5, TX40, UR10 and Panda; the last two where the package example-robot-data describes them."""
    robot = pid.load_robot(DATA / "ur10e" / "ur10e.urdf")
    for path in sorted((DATA / "ur10e").glob("ur-20_0[12]_*.csv")):
        if re.search(r"-p\d$", path.stem):
            continue  # a static pose
        yield Arm(f"ur10e {path.stem[3:]}", robot, (pid.load_recording(path, UR10E_COLUMNS, UR10E_GAINS),))
    robot = pid.load_robot("ur5")
    for path in sorted((DATA / "ur5").glob("*.csv.gz")):
        yield Arm(f"ur5 {path.name[:-7]}", robot, (pid.load_recording(path, None, UR5_GAINS),))
    yield Arm("tx40", pid.load_robot(DATA / "tx40" / "tx40_mdh_modified.urdf"), (_tx40(),))
    described = descriptions()
    if described is not None:
        for name, urdf in (
            ("ur10", "ur_description/urdf/ur10_robot.urdf"),
            ("panda", "panda_description/urdf/panda.urdf"),
        ):
            text = re.sub(r"<mimic[^>]*/>", "", (described / urdf).read_text(encoding="utf-8"))
            text = re.sub(r'(<joint name="panda_finger_joint\d" type=)"prismatic"', r'\1"fixed"', text)
            one = robot_of(text)
            yield Arm(name, one, (_bag(DATA / "rosbag2" / f"{name}_exciting_trajectory.db3", one),))


def descriptions() -> Path | None:
    """The folder of the robots in the package example-robot-data, None where it is not installed."""
    for entry in sys.path:
        for path in (Path(entry), Path(entry) / "cmeel.prefix" / "share"):
            for found in (
                path / "example-robot-data" / "robots",
                path / "cmeel.prefix" / "share" / "example-robot-data" / "robots",
            ):
                if found.is_dir():
                    return found
    return None


def robot_of(urdf: str) -> pid.Robot:
    """The robot of a description's text."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "robot.urdf"
        path.write_text(urdf, encoding="utf-8")
        return pid.load_robot(path)


def recorded(
    time: Array, q: Array, effort: Array, dq: Array | None = None, kind: Any = "torque", source: str = "arm"
) -> pid.Recording:
    """A recording of arrays, through the checks that a file's rows pass."""
    return recording_from_rows(Channels(time=time, q=q, effort=effort, effort_kind=kind, dq=dq), source)


def _tx40() -> pid.Recording:
    """On the joints' side of its gears, as ``studies/real_arms`` reads it."""
    motor, torque = (
        np.genfromtxt(DATA / "tx40" / f"{n}_data.csv.gz", delimiter=",", skip_header=1) for n in ("pos_read", "curr")
    )
    gears = np.diag((32.0, 32.0, 45.0, -48.0, 45.0, 32.0))
    gears[5, 4] = 32.0
    q = np.linalg.solve(gears, motor.T).T + np.array([0, -np.pi / 2, np.pi / 2, 0, 0, 0])
    return recorded(np.arange(len(q)) / 5000.0, q, torque @ gears, source="tx40")


def _bag(path: Path, robot: pid.Robot) -> pid.Recording:
    """The joint states of a bag, by the joints' last numbers or names."""
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    with sqlite3.connect(path) as bag:
        rows = bag.execute(
            "select data from messages join topics on topics.id = topic_id where topics.name = '/joint_states' order by messages.timestamp"
        ).fetchall()
    states: list[Any] = [store.deserialize_cdr(row[0], "sensor_msgs/msg/JointState") for row in rows]
    names = [name.replace("fer_", "panda_") for name in states[0].name]
    order = [names.index(name) for name in robot.joint_names]
    time = np.array([s.header.stamp.sec + 1e-9 * s.header.stamp.nanosec for s in states])
    q, dq, effort = (
        np.array([getattr(s, key) for s in states])[:, order] for key in ("position", "velocity", "effort")
    )
    return recorded(time - time[0], q, effort, dq, source=path.stem)


def simulated_arm(seed: int, cache: Path) -> Arm:
    """The arm of a seed in the open world's first plant or second in turn, with recordings of different days."""
    world = FirstWorld()
    truth, sensors = world.arm(seed), world.sensors(seed)
    recordings, plans = [], []
    for day in range(DAYS):
        motion_seed = 10 * (1000 * seed + day)
        plan = world.motion(truth, motion_seed, DURATION)
        path = cache / f"{seed}_{day}.csv"
        if not path.exists():
            sensors.write(plants()[seed % 2].simulate(truth, plan), motion_seed, path)
        recordings.append(pid.load_recording(path))
        plans.append(plan)
    return Arm(f"{truth.name} {seed}", robot_of(truth.urdf), tuple(recordings), truth, tuple(plans))
