"""ROS 2 bags, .db3 or .mcap, with or without metadata: a topic of sensor_msgs/JointState, whose joints have names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError, did_you_mean, warn
from physident.recordings.channels import BadRow, printable
from physident.recordings.columns.joint_names import joint_order, listed
from physident.recordings.formats.table import MAX_CELLS, Table

Array = NDArray[np.float64]
STATE = "sensor_msgs/msg/JointState"
CHANNELS = ("position", "velocity", "effort")
MANY = 10  # messages of the same names: beside them, a single one of other names is no second arm and no gripper
Messages = list[tuple[int, int, Any]]  # number in the topic from 1, time of arrival [ns], the message


def read_rosbag(path: Path, topic: str | None = None, wanted_joints: Sequence[str] | None = None) -> Table:
    """The table of a topic of joint states: ``time, q_1.., dq_1.., effort_1..`` and the names of its joints.

    The clock is that of the messages' headers or, where these have none, of their arrival. Rows are numbered as the topic's
    messages. With ``wanted_joints``, messages that lack one of them, as those of a gripper, are left out; without, all messages
    must name the same ones. Raises InputError for what is no complete bag, for a topic that is missing or not the only one,
    and for messages without effort.
    """
    broken: list[BadRow] = []
    messages = _without_strays(list(_messages(path, topic, broken)), broken)
    names = _joints_of(messages, wanted_joints, str(path))
    orders = _orders(messages, names)
    kept = [one for one in messages if tuple(one[2].name) in orders]
    n = len(names)
    values = np.full((len(kept), 1 + 3 * n), np.nan)
    values[:, 0] = _clock(kept)
    rejected = broken
    good = np.ones(len(kept), dtype=bool)
    for k, (number, _, message) in enumerate(kept):
        sizes = [len(getattr(message, channel)) for channel in CHANNELS]
        if any(size not in (0, len(message.name)) for size in sizes):
            rejected.append(BadRow(number, f"{len(message.name)} names, but {sizes} positions, velocities and efforts"))
            good[k] = False
            continue
        for start, channel, size in zip(range(1, 3 * n, n), CHANNELS, sizes, strict=True):
            if size:
                values[k, start : start + n] = getattr(message, channel)[orders[tuple(message.name)]]
    channels = {"q": 1, "dq": 1 + n, "effort": 1 + 2 * n}
    without = [name for name, start in channels.items() if np.isnan(values[:, start : start + n]).all()]
    if "effort" in without or "q" in without:
        missing = "effort" if "effort" in without else "position"
        raise InputError(f"{path}: its joint states have no {missing}; expected position and effort of every joint")
    present = {name: start for name, start in channels.items() if name not in without}
    columns = [0, *(start + j for start in present.values() for j in range(n))]
    return Table(
        values[good][:, columns],
        np.array([number for number, _, _ in kept])[good],
        ("time", *(f"{name}_{j}" for name in present for j in range(1, n + 1))),
        tuple(sorted(rejected, key=lambda row: row.row)),
        joints=tuple(map(printable, names)),
    )


def _messages(path: Path, topic: str | None, broken: list[BadRow]) -> Iterator[tuple[int, int, Any]]:
    """The messages of the topic in order of their arrival; those whose bytes are no message are added to ``broken``."""
    try:
        from rosbags.rosbag2 import Reader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise InputError(
            f"{path}: reading ROS bags needs the package rosbags; install it: pip install 'physident[ros]'"
        ) from None
    if signs := sorted(set("?%#") & set(str(path))):  # the reader puts the path into an address
        raise InputError(f"{path}: its path contains {' '.join(signs)}, which SQLite does not take as it is; rename it")
    # the definition of JointState has not changed since ROS 2 began, so a bag without definitions is read as well
    store = get_typestore(Stores.LATEST)
    number, numbers, announced = 0, 0, 0
    try:
        for part in _parts(path):
            with Reader(part) as reader:
                chosen = _topic_of(reader.connections, topic, path)
                wanted = [c for c in reader.connections if c.topic == chosen]
                announced += sum(c.msgcount for c in wanted)
                for _, arrival, raw in reader.messages(wanted):
                    number += 1
                    try:
                        message: Any = store.deserialize_cdr(raw, STATE)
                    except Exception as error:  # of as many kinds as there are ways to damage bytes
                        broken.append(BadRow(number, f"no message of joint states ({_reason(error)})"))
                        continue
                    numbers += 3 * len(message.name) + 1
                    if numbers > MAX_CELLS:
                        raise InputError(
                            f"{path}: more than {MAX_CELLS} numbers, expected a recording: cut it into parts"
                        )
                    yield number, arrival, message
    except InputError:
        raise
    except Exception as error:  # SQLite, MCAP, metadata and messages fail in a dozen kinds for one cause: broken bytes
        raise InputError(
            f"{path}: not a complete ROS 2 bag ({_reason(error)}); expected .db3 or .mcap files that were closed: repair it by"
            " ros2 bag reindex or mcap recover"
        ) from None
    if number == len(broken):
        readable = f"{number} messages, none of which can be read ({broken[0].reason})" if broken else "no messages"
        raise InputError(f"{path}: topic {topic or 'of joint states'} has {readable}; expected a recording")
    if announced > number:
        warn(f"{path}: {announced - number} of {announced} messages are missing from the bag: its bytes are damaged")


def _reason(error: Exception) -> str:
    return printable((str(error).splitlines() or [""])[0][:120]) or type(error).__name__


def _without_strays(messages: Messages, broken: list[BadRow]) -> Messages:
    """The messages without those whose list of names no other one has, beside many that agree: their names are damaged."""
    counts = Counter(tuple(message.name) for _, _, message in messages)
    most = max(counts.values())
    strays = {names for names, count in counts.items() if count == 1 and most >= MANY}
    usual = {name for names in counts if names not in strays for name in names}
    for number, _, message in messages:
        if tuple(message.name) in strays:
            others = [name for name in message.name if name not in usual]
            broken.append(
                BadRow(number, f"names joints as no other message does ({listed(others) or 'another order'})")
            )
    return [one for one in messages if tuple(one[2].name) not in strays]


def _parts(path: Path) -> list[Path]:
    """The bag itself or, in a folder without metadata, its files in order of their names."""
    if path.is_file() or (path / "metadata.yaml").exists():
        return [path]
    files = [sorted(path.glob(ending), key=lambda file: (len(file.name), file.name)) for ending in ("*.db3", "*.mcap")]
    return next(found for found in files if found)


def _topic_of(connections: Sequence[Any], topic: str | None, path: Path) -> str:
    states = sorted({c.topic for c in connections if c.msgtype == STATE})
    others = sorted({c.topic for c in connections} - set(states))
    if topic in states or (topic is None and len(states) == 1):
        return topic or states[0]
    shown = listed(states) or f"none of {STATE}, but {listed(others) or 'no topics at all'}"
    if topic is not None:
        what = f"topic {topic} is not of type {STATE}" if topic in others else f"has no topic {topic}"
        raise InputError(f"{path}: {what}; its topics of joint states: {shown}{did_you_mean(topic, states)}")
    if not states:
        raise InputError(f"{path}: has no topic of type {STATE}, expected one; its topics: {listed(others)}")
    raise InputError(
        f"{path}: has {len(states)} topics of joint states ({shown}); expected the choice of one (--topic)"
    )


def _joints_of(messages: Messages, joints: Sequence[str] | None, source: str) -> tuple[str, ...]:
    """The names of one arm: those that stand for ``joints``, or those of all messages where these name the same ones."""
    groups = dict.fromkeys(tuple(message.name) for _, _, message in messages)
    for names in groups:
        if len(set(names)) < len(names) or not names:
            raise InputError(f"{source}: a message names no joint, or one twice ({listed(names)}); expected each once")
    first, *others = groups
    every = sorted({name for names in groups for name in names})
    if joints is None:
        if any(set(names) != set(first) for names in others):
            raise InputError(
                f"{source}: its messages name different joints in turn ({listed(every)}); expected those of one arm:"
                " choose the robot (--robot, or joints=robot.joint_names)"
            )
        return first
    arms = {
        tuple(names[j] for j in order) for names in groups if (order := _fitting(names, joints, source)) is not None
    }
    if len(arms) == 1:
        return arms.pop()
    joint_order(every, joints, source)  # raises where joints are missing or two arms have them
    raise InputError(f"{source}: no message names all of {listed(joints)}; expected them in one message")


def _fitting(names: Sequence[str], joints: Sequence[str], source: str) -> list[int] | None:
    try:
        return joint_order(names, joints, source)
    except InputError:
        return None


def _orders(messages: Messages, joints: Sequence[str]) -> dict[tuple[str, ...], list[int]]:
    """For each list of names that has all ``joints``, the index of each joint in it."""
    groups = dict.fromkeys(tuple(message.name) for _, _, message in messages)
    return {names: [names.index(joint) for joint in joints] for names in groups if set(joints) <= set(names)}


def _clock(messages: Messages) -> Array:
    """Time (N,) [s] of the messages, by the stamps of their headers unless these stand still."""
    stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for _, _, m in messages]
    arrivals = [arrival for _, arrival, _ in messages]
    return np.array(arrivals if len(set(stamps)) == 1 else stamps) / 1e9
