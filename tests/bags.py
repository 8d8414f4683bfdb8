"""ROS 2 bags and other files for tests, written by the libraries of their formats."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

import physident as pid

STATE = "sensor_msgs/msg/JointState"
UR_JOINTS = tuple(
    f"{name}_joint" for name in ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
)


def write_bag(
    path: Path,
    recording: pid.Recording,
    names: Sequence[str] = UR_JOINTS,
    topic: str = "/joint_states",
    storage: str = "mcap",
    order: Sequence[int] | None = None,
) -> Path:
    """A bag of one topic, with the joints in some ``order``; the recording's times are whole nanoseconds."""
    return write_states(path, [(topic, states(recording, names, order))], storage)


def states(recording: pid.Recording, names: Sequence[str], order: Sequence[int] | None = None) -> list[dict[str, Any]]:
    """One message for each row of a recording."""
    chosen = list(range(recording.n)) if order is None else list(order)
    velocity = np.zeros((len(recording.time), 0)) if recording.dq is None else recording.dq[:, chosen]
    return [
        {
            "stamp": round(t * 1e9),
            "name": [names[j] for j in chosen],
            "position": recording.q[k, chosen],
            "velocity": velocity[k],
            "effort": recording.effort[k, chosen],
        }
        for k, t in enumerate(recording.time)
    ]


def write_states(
    path: Path, topics: Sequence[tuple[str, list[dict[str, Any]]]], storage: str = "mcap", stamped: bool = True
) -> Path:
    """A bag with topics of joint states; not ``stamped``, the headers' clocks are zero."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    types: Any = store.types
    plugin = StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3
    with Writer(path, version=9, storage_plugin=plugin) as bag:
        for topic, messages in topics:
            connection = bag.add_connection(topic, STATE, typestore=store)
            for message in messages:
                stamp = message["stamp"] if stamped else 0
                time = types["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9)
                header = types["std_msgs/msg/Header"](time, "")
                arrays = [np.ascontiguousarray(message[key], dtype=float) for key in ("position", "velocity", "effort")]
                state = types[STATE](header, message["name"], *arrays)
                bag.write(connection, message["stamp"], bytes(store.serialize_cdr(state, STATE)))
    return path


def write_lerobot(folder: Path, episodes: Sequence[pid.Recording], version: str = "v3.0", named: bool = True) -> Path:
    """A LeRobot data set of version 3, with all episodes in one file, or of version 2.1, with one file each.

    Not ``named``, the state has positions alone, and ``action`` is the torque.
    """
    joints = list(UR_JOINTS)
    names = [f"{joint}.{kind}" for kind in ("pos", "vel", "effort") for joint in joints]
    tables = []
    start = 0
    for index, one in enumerate(episodes):
        assert one.dq is not None
        count = len(one.time)
        state = np.column_stack([one.q, one.dq, one.effort]) if named else one.q
        action = one.q if named else one.effort
        tables.append(
            pa.table(
                {
                    "observation.state": pa.FixedSizeListArray.from_arrays(state.ravel(), state.shape[1]),
                    "action": pa.FixedSizeListArray.from_arrays(action.ravel(), one.n),
                    "timestamp": one.time - one.time[0],
                    "frame_index": np.arange(count),
                    "episode_index": np.full(count, index),
                    "index": np.arange(start, start + count),
                    "task_index": np.zeros(count, dtype=int),
                }
            )
        )
        start += count
    chunk = folder / "data" / "chunk-000"
    chunk.mkdir(parents=True)
    if version.startswith("v3"):
        pq.write_table(pa.concat_tables(tables), chunk / "file-000.parquet")
        data_path = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
    else:
        for index, table in enumerate(tables):
            pq.write_table(table, chunk / f"episode_{index:06d}.parquet")
        data_path = "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet"
    info = {
        "codebase_version": version,
        "robot_type": "ur5",
        "total_episodes": len(episodes),
        "total_frames": start,
        "fps": 125,
        "data_path": data_path,
        "features": {
            "observation.state": {
                "dtype": "float64",
                "shape": [(3 if named else 1) * episodes[0].n],
                "names": names if named else None,
            },
            "action": {"dtype": "float64", "shape": [episodes[0].n], "names": joints},
        },
    }
    (folder / "meta").mkdir()
    (folder / "meta" / "info.json").write_text(json.dumps(info))
    return folder
