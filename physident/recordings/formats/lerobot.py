"""LeRobot data sets: a folder with meta/info.json and Parquet files; each episode is a recording."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from physident.errors import InputError
from physident.files import read_text
from physident.recordings.columns.joint_names import listed
from physident.recordings.formats.parquet import read_columns, table_of_columns
from physident.recordings.formats.table import Table

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


def read_lerobot(path: Path, part: int | None, columns: object = None) -> Table:
    """The table of one episode of a data set (version 2 or 3): positions, velocities and efforts of ``observation.state``.

    What a number of the state is, its name in info.json tells: "elbow.pos", "elbow.vel", "elbow.effort"; without such an
    ending it is a position. ``observation.effort`` and the like have one number for each joint. ``action`` and all other
    features keep their names, and all do where ``columns`` are declared. Raises InputError for what is no data set, or has
    no such episode.
    """
    import pyarrow as pa

    info, episode = _info(path), part or 0
    files = sorted(path.glob("data/**/*.parquet"))
    if not files:
        raise InputError(f"{path}: has no data/**/*.parquet; expected a complete LeRobot data set")
    found = [read_columns(file, [(EPISODE, "==", episode)]) for file in files]
    try:
        rows = pa.concat_tables([columns for columns, _ in found if columns.num_rows] or [found[0][0]])
    except pa.ArrowException:
        raise InputError(
            f"{path}: the files of episode {episode} have different columns; expected the same ones"
        ) from None
    if not rows.num_rows:
        raise InputError(f"{path}: has no episode {episode} in its files; expected one that it contains")
    table = table_of_columns(rows, path, found[0][1])
    return table if columns is not None else _named(info, table, path)


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


def _named(info: dict[str, Any], table: Table, path: Path) -> Table:
    """The table with the names of a recording's columns, and the names of its joints where the state has names."""
    assert table.names is not None
    names = list(table.names)
    state = [k for k, name in enumerate(names) if re.fullmatch(r"observation\.state(_[0-9]+)?", name)]
    labels = _labels(info["features"].get("observation.state"), len(state))
    joints: dict[str, list[str]] = {}
    for place, label in zip(state, labels or [""] * len(state), strict=True):
        joint, channel = _meaning(label)
        joints.setdefault(channel, []).append(joint)
        names[place] = f"{channel}_{len(joints[channel])}"
    for k, name in enumerate(table.names):
        stem, _, number = name.rpartition("_")
        if (channel := FEATURES.get(stem)) and channel not in joints:
            names[k] = f"{channel}_{number}"
    positions = joints.get("q", [])
    if wrong := next((channel for channel, named in joints.items() if named != positions), None):
        raise InputError(
            f"{path}: observation.state has {wrong} of {listed(joints[wrong])}, but positions of"
            f" {listed(positions) or 'none'}; expected the same joints in the same order, or declared columns"
        )
    return Table(table.values, table.rows, tuple(names), joints=tuple(positions) if labels and positions else None)


def _labels(feature: Any, width: int) -> list[str] | None:
    """The names of the numbers of a feature: a list, or a list in an object such as {"motors": [...]}; or None."""
    names = feature.get("names") if isinstance(feature, dict) else None
    if isinstance(names, dict):
        names = next(iter(names.values()), None)
    if isinstance(names, list) and len(names) == width and all(isinstance(name, str) for name in names):
        return names
    return None


def _meaning(label: str) -> tuple[str, str]:
    """Joint and channel of a name such as "elbow.pos"; without a known ending it is a position."""
    joint, _, ending = label.rpartition(".")
    channel = next((channel for channel, endings in ENDINGS.items() if ending in endings), None)
    return (joint, channel) if joint and channel else (label, "q")
