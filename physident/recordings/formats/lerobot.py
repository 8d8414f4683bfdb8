"""LeRobot data sets: a folder with meta/info.json and Parquet files; each episode is a recording."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.files import read_text
from physident.recordings.formats.parquet import table_of_columns
from physident.recordings.formats.table import Table, check_size

MAX_BYTES = 10_000_000  # of info.json
MAX_EPISODES = 1000
EPISODE = "episode_index"
ENDINGS = {  # of a state's names, as in "elbow.pos"
    "q": ("pos", "position", "q"),
    "dq": ("vel", "velocity", "dq"),
    "tau": ("torque", "tau"),
    "current": ("current",),
    "effort": ("effort",),
}
FEATURES = {  # that hold one number for each joint
    "observation.velocity": "dq",
    "observation.effort": "effort",
    "observation.torque": "tau",
    "observation.current": "current",
    "observation.temperature": "temperature",
}


def parts_of_lerobot(path: Path) -> list[str]:
    """The addresses of a data set's episodes, PATH#0 and so on; raises InputError for more than can be listed."""
    episodes = _info(path).get("total_episodes")
    if not isinstance(episodes, int) or not 0 < episodes <= MAX_EPISODES:
        raise InputError(
            f"{path}: {episodes} episodes, expected 1 to {MAX_EPISODES}: choose some by {path}#0, {path}#1"
        )
    return [f"{path}#{k}" for k in range(episodes)]


def read_lerobot(path: Path, part: int | None) -> Table:
    """The table of one episode of a data set (version 2 or 3): positions, velocities and efforts of ``observation.state``.

    What a number of the state is, its name in info.json tells: "elbow.pos", "elbow.vel", "elbow.effort"; without such an
    ending it is a position. ``observation.effort`` and the like have one number for each joint. ``action`` and all other
    features keep their names for a declared layout. Raises InputError for what is no data set, or has no such episode.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    info = _info(path)
    episode = part or 0
    files = sorted(path.glob("data/**/*.parquet"))
    if not files:
        raise InputError(f"{path}: has no data/**/*.parquet; expected a complete LeRobot data set")
    try:
        found = [pq.read_table(file, filters=[(EPISODE, "==", episode)], use_threads=False) for file in files]
        table = pa.concat_tables([one for one in found if one.num_rows])
    except (pa.ArrowException, OSError, ValueError, KeyError) as error:
        reason = (str(error).splitlines() or [""])[0][:120]
        raise InputError(
            f"{path}: episode {episode} cannot be read ({reason}); expected one that it contains"
        ) from None
    check_size(path, table.num_rows, table.num_columns)
    joints, columns = _columns(info, table_of_columns(table, path))
    return Table(columns.values, columns.rows, columns.names, joints=joints)


def _info(path: Path) -> dict[str, Any]:
    import json

    file = path / "meta" / "info.json"
    expected = "a LeRobot data set with meta/info.json"
    try:
        info = json.loads(read_text(file, MAX_BYTES, expected))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{file}: not valid JSON ({error}); expected {expected}") from None
    if not isinstance(info, dict) or not isinstance(info.get("features"), dict):
        raise InputError(f"{file}: has no features; expected {expected}")
    return info


def _columns(info: dict[str, Any], table: Table) -> tuple[tuple[str, ...] | None, Table]:
    """The names of the joints, and the table with the names of a recording's columns."""
    assert table.names is not None
    state = [k for k, name in enumerate(table.names) if re.fullmatch(r"observation\.state(_[0-9]+)?", name)]
    labels = _labels(info["features"].get("observation.state"), len(state))
    new_names = list(table.names)
    joints: dict[str, list[str]] = {}
    for place, label in zip(state, labels, strict=True):
        joint, channel = _meaning(label)
        joints.setdefault(channel, []).append(joint)
        new_names[place] = f"{channel}_{len(joints[channel])}"
    for k, name in enumerate(table.names):
        stem, _, number = name.rpartition("_")
        if (channel := FEATURES.get(stem)) and channel not in joints:
            new_names[k] = f"{channel}_{number}"
    names = joints.get("q")
    # channels of the state belong together by the names of the joints, not by their place
    for channel, named in joints.items():
        if names is None or (channel != "q" and named != names):
            raise InputError(
                f"observation.state: {channel} is of {', '.join(named[:7])}, positions of {', '.join((names or [])[:7]) or 'none'};"
                " expected the same joints in the same order"
            )
    values, clock = table.values, table.names.index("timestamp") if "timestamp" in table.names else None
    if clock is None and isinstance(rate := info.get("fps"), int | float) and rate > 0:
        time: NDArray[np.float64] = np.arange(len(values)) / rate
        values, new_names = np.column_stack([values, time]), [*new_names[: values.shape[1]], "time"]
    known = labels if names and all(re.fullmatch(r"state_[0-9]+", label) is None for label in labels) else None
    return tuple(names) if known and names else None, Table(values, table.rows, tuple(new_names))


def _labels(feature: Any, width: int) -> list[str]:
    """The names of the numbers of a feature: a list, or a list in an object such as {"motors": [...]}."""
    names = feature.get("names") if isinstance(feature, dict) else None
    if isinstance(names, dict):
        names = next(iter(names.values()), None)
    if isinstance(names, list) and len(names) == width and all(isinstance(name, str) for name in names):
        return names
    return [f"state_{k}" for k in range(1, width + 1)]


def _meaning(label: str) -> tuple[str, str]:
    """Joint and channel of a name such as "elbow.pos"; without a known ending it is a position."""
    joint, _, ending = label.rpartition(".")
    channel = next((channel for channel, endings in ENDINGS.items() if ending in endings), None)
    return (joint, channel) if joint and channel else (label, "q")
