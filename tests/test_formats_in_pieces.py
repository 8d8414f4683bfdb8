"""A file that is read in pieces is the same recording, and needs memory for a piece alone."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

import physident as pid
from physident import large_arrays
from physident.large_arrays import LARGE
from physident.recordings.columns.reading import Reading
from physident.recordings.formats.read import read_table
from tests.bags import states, write_states

JOINTS = ("shoulder", "elbow")
ROWS, PIECE = 40_000, 2048


def arrays(rows: int) -> dict[str, np.ndarray]:
    """A smooth motion at 500 Hz, whose times are whole nanoseconds."""
    time = np.arange(rows) / 500
    q = np.sin(time[:, None] * (0.7, 1.1))
    dq = np.cos(time[:, None] * (0.7, 1.1)) * (0.7, 1.1)
    return {"time": time, "q": q, "dq": dq, "tau": np.random.default_rng(4).normal(size=q.shape)}


def by_rows(folder: Path, given: dict[str, np.ndarray]) -> Path:
    np.savez(folder / "r.npz", **given)  # pyright: ignore[reportArgumentType]
    return folder / "r.npz"


def by_columns(folder: Path, given: dict[str, np.ndarray]) -> Path:
    turned = {name: np.asfortranarray(values) for name, values in given.items()}
    np.savez_compressed(folder / "r.npz", **turned)  # pyright: ignore[reportArgumentType]
    return folder / "r.npz"


def matlab(folder: Path, given: dict[str, np.ndarray]) -> Path:
    savemat(folder / "r.mat", given, do_compression=True)
    return folder / "r.mat"


def bag(folder: Path, given: dict[str, np.ndarray]) -> Path:
    run = pid.Recording.from_arrays(given["time"], given["q"], given["tau"], given["dq"])
    return write_states(folder / "bag", [("/joint_states", states(run, JOINTS))])


@pytest.fixture
def pieces(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """All arrays in files, blocks of a few rows."""
    monkeypatch.setattr(large_arrays, "BLOCK", PIECE)
    monkeypatch.setattr("physident.recordings.formats.joint_states.BATCH", 100)
    monkeypatch.setattr("physident.recordings.formats.mat.BLOCK", 10_000)
    token = LARGE.set(20_000)
    yield
    LARGE.reset(token)


@pytest.mark.parametrize("write", [by_rows, by_columns, matlab, bag])
def test_every_number_and_row_is_there(write: Callable[..., Path], tmp_path: Path, pieces: None) -> None:
    given = arrays(3 * PIECE + 17)
    table = read_table(write(tmp_path, given))
    names = ["time", *(f"{kind}_{j}" for kind in ("q", "dq", "effort" if write is bag else "tau") for j in (1, 2))]
    assert table.names is not None
    columns = [table.names.index(name) for name in names]
    np.testing.assert_array_equal(table.values[:, columns], np.column_stack(list(given.values())))
    np.testing.assert_array_equal(table.rows, np.arange(1, len(given["time"]) + 1))


@pytest.mark.parametrize(("write", "share"), [(by_rows, 0.35), (by_columns, 0.35), (matlab, 0.75)])
def test_memory_is_that_of_a_piece(write: Callable[..., Path], share: float, tmp_path: Path, pieces: None) -> None:
    given = arrays(ROWS)
    path = write(tmp_path, given)
    read_table(write(tmp_path, arrays(100)).rename(path.with_stem("small")))  # imports take memory, too
    path = write(tmp_path, given)
    size = sum(values.nbytes for values in given.values())
    tracemalloc.start()
    table = read_table(path)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert table.values.shape == (ROWS, 7)
    assert peak < share * size


def test_memory_of_a_bag_is_that_of_a_piece(tmp_path: Path, pieces: None) -> None:
    given = arrays(6000)
    path = bag(tmp_path, given)
    read_table(path)
    tracemalloc.start()
    read_table(path)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 6000 * 600  # a message in memory is over a kilobyte


def test_messages_of_an_arm_and_of_a_gripper_that_take_turns(tmp_path: Path, pieces: None) -> None:
    given = arrays(1200)
    run = pid.Recording.from_arrays(given["time"], given["q"], given["tau"], given["dq"])
    arm = states(run, JOINTS)
    swapped = states(run, JOINTS, order=(1, 0))
    messages = []
    for k in range(1200):
        messages.append(arm[k] if k % 3 else swapped[k])
        finger = {"stamp": arm[k]["stamp"] + 1000, "name": ["finger"], "position": np.zeros(1), "velocity": np.zeros(1)}
        messages.append({**finger, "effort": np.zeros(1)})
    path = write_states(tmp_path / "bag", [("/joint_states", messages)])
    recording = pid.load_recording(path, joints=JOINTS)
    np.testing.assert_array_equal(recording.q, given["q"])
    np.testing.assert_array_equal(recording.effort, given["tau"])
    np.testing.assert_array_equal(read_table(path, Reading(joints=JOINTS)).rows, np.arange(1, 2400, 2))
