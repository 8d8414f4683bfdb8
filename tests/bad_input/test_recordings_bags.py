"""Bags, tables and data sets that are damaged, incomplete or of another arm: one line each."""

from __future__ import annotations

import json
import sqlite3
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from scipy.io import savemat

import physident as pid
from tests.bad_input.good import table
from tests.bad_input.one_line_error import fails, refused_recording
from tests.bags import UR_JOINTS, states, write_bag, write_lerobot, write_states


def good() -> pid.Recording:
    values = table()
    return pid.Recording.from_arrays(np.round(values[:, 0], 9), values[:, 1:7], values[:, 13:], values[:, 7:13])


def changed(change: Callable[[dict[str, Any]], Any]) -> list[dict[str, Any]]:
    """The messages of the good recording, each after a change in place."""
    messages = states(good(), UR_JOINTS)
    for message in messages:
        change(message)
    return messages


def bag(messages: list[dict[str, Any]]) -> Callable[[Path], Any]:
    return lambda path: write_states(path, [("/joint_states", messages)])


def one_file(storage: str, change: Callable[[bytes], bytes]) -> Callable[[Path], Any]:
    """The one file of a good bag, its bytes changed."""

    def write(path: Path) -> None:
        folder = write_bag(path.with_name("whole"), good(), storage=storage)
        path.write_bytes(change(next(file for file in folder.iterdir() if file.suffix == path.suffix).read_bytes()))

    return write


def no_such_folder(path: Path) -> None:
    path.mkdir()
    (path / "metadata.yaml").write_text("rosbag2_bagfile_information: {version: 5}")


def without_topics(path: Path) -> None:
    sqlite3.connect(path).execute("CREATE TABLE others (id INTEGER)").connection.close()


def prefixed(prefix: str) -> list[str]:
    return [prefix + name for name in UR_JOINTS]


def both_arms(message: dict[str, Any]) -> None:
    message["name"] = prefixed("left_") + prefixed("right_")
    for channel in ("position", "velocity", "effort"):
        message[channel] = np.concatenate([message[channel]] * 2)


def in_turns() -> list[dict[str, Any]]:
    messages = states(good(), UR_JOINTS)
    for k, message in enumerate(messages):
        message["name"] = prefixed(("left_", "right_")[k % 2])
    return messages


def fewer(message: dict[str, Any]) -> None:
    for key in ("name", "position", "velocity", "effort"):
        message[key] = message[key][:5]


BAGS: dict[str, tuple[str, Callable[[Path], Any], str]] = {
    # name of the case: file, what writes it, what the line must say
    "truncated mcap": ("r.mcap", one_file("mcap", lambda b: b[: len(b) // 2]), "not a complete ROS 2 bag"),
    "truncated db3": ("r.db3", one_file("sqlite3", lambda b: b[: len(b) // 2]), "not a complete ROS 2 bag"),
    "db3 cut in its header": ("r.db3", one_file("sqlite3", lambda b: b[:900]), "not a complete ROS 2 bag"),
    "mcap of zeros": ("r.mcap", one_file("mcap", lambda b: bytes(len(b))), "not a complete ROS 2 bag"),
    "a name that is an address": ("100%.db3", one_file("sqlite3", lambda b: b), "rename it"),
    "empty db3": ("r.db3", lambda path: path.write_bytes(b""), "not a complete ROS 2 bag"),
    "db3 of other tables": ("r.db3", without_topics, "not a complete ROS 2 bag"),
    "folder with broken metadata": ("bag", no_such_folder, "not a complete ROS 2 bag"),
    "folder without a bag": ("bag", lambda path: path.mkdir(), "folder without a recording"),
    "no messages": ("bag", bag([]), "no messages"),
    "no effort": ("bag", bag(changed(lambda m: m.update(effort=[]))), "no effort"),
    "no names": ("bag", bag(changed(lambda m: m.update(name=[]))), "names no joint"),
    "a name twice": ("bag", bag(changed(lambda m: m.update(name=["a"] * 6))), "one twice"),
}


@pytest.mark.parametrize("case", BAGS)
def test_bags(case: str, folder: Path, tmp_path_factory: pytest.TempPathFactory, capfd: pytest.CaptureFixture) -> None:
    name, write, says = BAGS[case]
    write(folder / name)
    refused_recording(capfd, folder, name, says)


@pytest.mark.parametrize(
    ("messages", "says"),
    [
        (changed(fewer), "has no joint wrist_3_joint"),
        (changed(both_arms), "2 arms.*'left_' and 'right_'"),
        (in_turns(), "2 arms.*'left_' and 'right_'"),
        (changed(lambda m: m.update(name=list("abcdef"))), "has no joint shoulder_pan_joint.*its joints are a, b, c"),
    ],
    ids=["fewer joints", "two arms in each message", "two arms in turn", "another arm"],
)
def test_bags_of_another_arm(
    messages: list[dict[str, Any]], says: str, folder: Path, capfd: pytest.CaptureFixture
) -> None:
    write_states(folder / "bag", [("/joint_states", messages)])
    fails(capfd, folder, ["identify", "bag", "--robot", "ur5", "--out", "out.json"], says)
    fails(capfd, folder, ["validate", "bag", "--model", "model.json"], says)


def test_topics(folder: Path, capfd: pytest.CaptureFixture) -> None:
    messages = states(good(), UR_JOINTS)
    write_states(folder / "two", [("/a", messages), ("/b", messages)])
    write_states(folder / "one", [("/a", messages)])
    fails(capfd, folder, ["inspect", "two"], "2 topics of joint states .*--topic")
    fails(capfd, folder, ["inspect", "two", "--topic", "/c"], "has no topic /c; its topics of joint states: /a, /b")
    fails(capfd, folder, ["inspect", "one", "--topic", "a topic"], "expected the name of a topic")
    fails(capfd, folder, ["inspect", "good.csv", "--topic", "/a"], "has no topics")


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--rate", "0"], "rate is 0.0"),
        (["--rate", "-125"], "rate is -125"),
        (["--rate", "nan"], "rate is nan"),
        (["--rate", "1e9"], "rate is"),
        (["--columns", "q=nothing,tau=1:7"], "no column 'nothing'.*time, q, dq, tau"),
        (["--columns", "time=time,q=q[0:9],tau=tau"], r"6 columns 'q', not 'q\[0:9\]'"),
        (["--columns", "time=q,q=q,tau=tau"], "no time column"),
        (["--columns", "rate=,q=1:7"], "empty or given twice"),
        (["--columns", "rate=fast,q=1:7,tau=7:13"], "rate is 'fast'"),
        (["--columns", "joints=a b c d e f"], "joints have no names"),
    ],
)
def test_options(options: list[str], says: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    fails(capfd, folder, ["inspect", "good.csv", *options], says)


def write_parquet(columns: dict[str, Any]) -> Callable[[Path], Any]:
    return lambda path: pq.write_table(pa.table(columns), path)


def write_mat(**variables: Any) -> Callable[[Path], Any]:
    values = table()
    arrays = {"time": values[:, 0], "q": values[:, 1:7], "tau": values[:, 13:]} | variables
    return lambda path: savemat(path, {name: array for name, array in arrays.items() if array is not None})


def half(write: Callable[[Path], Any]) -> Callable[[Path], Any]:
    def cut(path: Path) -> None:
        write(path)
        content = path.read_bytes()
        path.write_bytes(content[: len(content) // 2])

    return cut


COLUMNS: dict[str, Any] = {"time": table()[:, 0], "q": table()[:, 1:7].tolist(), "tau": table()[:, 13:].tolist()}
FILES: dict[str, tuple[str, Callable[[Path], Any], str]] = {
    "parquet that is text": ("r.parquet", lambda path: path.write_text("time,q"), "not readable as Parquet"),
    "parquet cut in half": ("r.parquet", half(write_parquet(COLUMNS)), "not readable as Parquet"),
    "parquet of words": ("r.parquet", write_parquet({"time": ["a", "b"]}), "no columns of numbers"),
    "parquet without rows": ("r.parquet", write_parquet({"time": pa.array([], pa.float64())}), "no rows"),
    "parquet of ragged lists": (
        "r.parquet",
        write_parquet(COLUMNS | {"q": [[0.0] * (6 if k else 5) for k in range(400)]}),
        "column 'q' has lists of different lengths",
    ),
    "parquet without effort": ("r.parquet", write_parquet({"time": COLUMNS["time"], "q": COLUMNS["q"]}), "neither tau"),
    "mat that is text": ("r.mat", lambda path: path.write_text("time,q\n" * 99), "not readable as a MATLAB file"),
    "mat cut in half": ("r.mat", half(write_mat()), "not readable as a MATLAB file"),
    "mat of version 7.3": (
        "r.mat",
        lambda path: path.write_bytes(bytes(512) + b"\x89HDF\r\n\x1a\n" * 9),
        "version 7.3",
    ),
    "mat without time": ("r.mat", write_mat(time=None), "no time column"),
    "mat with positions across": ("r.mat", write_mat(q=table()[:, 1:7].T), r"'q' is \(6, 400\).*transpose"),
    "mat of words": ("r.mat", lambda path: savemat(path, {"name": "arm"}), "no arrays of numbers"),
    "session that is text": (
        "r.rrd",
        lambda path: path.write_text("time,q"),
        "not readable as a session|no recordings",
    ),
    "empty session": ("r.rrd", lambda path: path.write_bytes(b""), "not readable as a session|no recordings"),
}


@pytest.mark.parametrize("case", FILES)
def test_files(case: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    name, write, says = FILES[case]
    write(folder / name)
    refused_recording(capfd, folder, name, says)


def test_sessions_without_a_complete_recording(folder: Path, capfd: pytest.CaptureFixture) -> None:
    import rerun as rr

    contents: dict[str, Any] = {
        "clock": {"q": np.zeros(6)},
        "rows": {"clock": np.arange(4.0), "q": np.zeros(6)},
        "none": {},
    }
    contents |= {"words": {"clock": np.arange(4.0), "q": ["a"] * 4}}
    says_of = dict.fromkeys(contents, "recording 0 is not complete")
    says_of |= {"none": "contains no recordings", "words": "no joint positions|not readable"}
    for name, content in contents.items():
        stream = rr.RecordingStream("physident", send_properties=False)
        stream.save(folder / f"{name}.rrd")
        stream.log("recordings/0" if content else "other", rr.AnyValues(**content, note="x"), static=True)
        stream.flush()
        stream.disconnect()
        says = says_of[name]
        refused_recording(capfd, folder, f"{name}.rrd", says)
    write(folder / "good.rrd")
    fails(capfd, folder, ["inspect", "good.rrd#3"], "has no recording 3; expected 0 to 0")


def write(path: Path) -> None:
    pid.view(recordings=good(), robot=pid.load_robot("ur5"), to=path)


def lerobot(change: Callable[[Path, dict[str, Any]], Any]) -> Callable[[Path], Any]:
    """A data set with a changed description."""

    def write(path: Path) -> None:
        write_lerobot(path, [good()])
        info = json.loads((path / "meta" / "info.json").read_text())
        change(path, info)
        (path / "meta" / "info.json").write_text(json.dumps(info))

    return write


def positions_alone(_: Path, info: dict[str, Any]) -> None:
    names = info["features"]["observation.state"]["names"]
    info["features"]["observation.state"]["names"] = [f"{name}.goal" for name in names]


SETS: dict[str, tuple[Callable[[Path, dict[str, Any]], Any], str]] = {
    "no features": (lambda _, info: info.pop("features"), "no features"),
    "no episodes": (lambda _, info: info.update(total_episodes=0), "0 episodes"),
    "too many episodes": (lambda _, info: info.update(total_episodes=10**6), "choose some by set#0"),
    "episodes in words": (lambda _, info: info.update(total_episodes="many"), "many episodes"),
    "no data": (lambda path, _: (path / "data" / "chunk-000" / "file-000.parquet").unlink(), "no data/"),
    "an episode too many": (lambda _, info: info.update(total_episodes=2), "has no episode 1"),
    "no effort": (positions_alone, "neither tau nor current"),
}


@pytest.mark.parametrize("case", SETS)
def test_data_sets(case: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    change, says = SETS[case]
    lerobot(change)(folder / "set")
    refused_recording(capfd, folder, "set", says)


def test_a_missing_package_is_named(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture
) -> None:
    write_bag(folder / "bag", good())
    for name in ("rosbags.rosbag2", "pandas"):
        monkeypatch.setitem(sys.modules, name, None)
    fails(capfd, folder, ["inspect", "bag"], r"needs the package rosbags.*pip install 'physident\[ros\]'")
    with pytest.raises(pid.InputError, match="pip install pandas"):
        good().to_pandas()
