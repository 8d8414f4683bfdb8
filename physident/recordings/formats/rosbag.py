"""ROS 2 bags, .db3 or .mcap, with or without metadata: a topic of sensor_msgs/JointState, whose joints have names."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from physident.errors import InputError, did_you_mean, warn
from physident.recordings.channels import BadRow, printable
from physident.recordings.columns.joint_names import listed
from physident.recordings.formats.joint_states import JointStates
from physident.recordings.formats.table import MOST_CELLS, Table

STATE = "sensor_msgs/msg/JointState"


def read_rosbag(path: Path, topic: str | None = None, wanted_joints: Sequence[str] | None = None) -> Table:
    """The table of a topic of joint states: ``time, q_1.., dq_1.., effort_1..`` and the names of its joints.

    The clock is that of the messages' headers or, where these have none, of their arrival. Rows are numbered as the topic's
    messages, which are read one after another. With ``wanted_joints``, messages that lack one of them, as those of a gripper, are
    left out; without, all messages must name the same ones. Raises InputError for what is no complete bag, for a topic that is
    missing or not the only one, and for messages without effort.
    """
    broken: list[BadRow] = []
    states = JointStates(str(path))
    for number, arrival, message in _messages(path, topic, broken):
        states.add(number, arrival, message)
    return states.table(wanted_joints, broken)


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
                    if numbers > MOST_CELLS:
                        raise InputError(
                            f"{path}: more than {MOST_CELLS} numbers, expected a recording: cut it into parts"
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
