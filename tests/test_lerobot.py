"""LeRobot data sets: every episode is a recording, its numbers go by their names, or by a declared layout."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import physident as pid
from tests.bad_input.good import table
from tests.bags import UR_JOINTS, write_lerobot


@pytest.fixture
def episodes() -> list[pid.Recording]:
    """Two recordings of different lengths."""
    values = table()
    return [
        pid.Recording.from_arrays(v[:, 0], v[:, 1:7], v[:, 13:], v[:, 7:13])
        for v in (values, np.column_stack([values[:, 0], 0.9 * values[:, 1:]])[:300])
    ]


@pytest.mark.parametrize("version", ["v3.0", "v2.1"])
def test_every_episode_is_a_recording(tmp_path: Path, episodes: list[pid.Recording], version: str) -> None:
    folder = write_lerobot(tmp_path / "set", episodes, version)
    found = pid.load_recordings(folder)
    assert [one.source for one in found] == [f"{folder}#0", f"{folder}#1"]
    for one, expected in zip(found, episodes, strict=True):
        assert one.joint_names == UR_JOINTS
        assert one.dq is not None
        for name in ("time", "q", "dq", "effort"):
            np.testing.assert_array_equal(getattr(one, name), getattr(expected, name))
        assert "action_1" in one.ignored
    np.testing.assert_array_equal(pid.load_recording(f"{folder}#1").q, episodes[1].q)


def test_torques_may_be_the_action(tmp_path: Path, episodes: list[pid.Recording]) -> None:
    folder = write_lerobot(tmp_path / "set", episodes, named=False)
    with pytest.raises(pid.InputError, match="neither tau nor current"):
        pid.load_recordings(folder)
    columns = "time=timestamp,q=observation.state,tau=action"
    for one, expected in zip(pid.load_recordings(folder, columns), episodes, strict=True):
        np.testing.assert_array_equal(one.q, expected.q)
        np.testing.assert_array_equal(one.effort, expected.effort)
    estimate = pid.identify("ur5", f"{folder}#0", columns=columns, method="ols")
    pid.validate(estimate, f"{folder}#1")
