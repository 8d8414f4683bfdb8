"""Bags of joint states: joints go by their names, whatever else is on the topic; two real bags end in a model."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import physident as pid
from physident.cli import run
from physident.recordings.columns.joint_names import joint_order
from tests.bags import UR_JOINTS, states, write_bag, write_states

N = 300


@pytest.fixture(scope="module")
def recording() -> pid.Recording:
    """Three seconds at 100 Hz in which every number differs from all others."""
    time = np.arange(N) * 1e7 / 1e9
    angle = np.outer(time, 1 + 0.3 * np.arange(6)) + np.arange(6)
    return pid.Recording.from_arrays(time, np.sin(angle), 10 * np.cos(2 * angle), np.cos(angle))


def same(found: pid.Recording, expected: pid.Recording) -> bool:
    return all(np.array_equal(getattr(found, name), getattr(expected, name)) for name in ("time", "q", "dq", "effort"))


@given(st.permutations(UR_JOINTS), st.sampled_from(["", "left_", "ur10/", "my.robot-1/"]))
@settings(max_examples=50, deadline=None)
def test_joints_are_found_in_any_order_and_with_any_prefix(shuffled: list[str], prefix: str) -> None:
    names = [f"{prefix}{name}" for name in shuffled] + [f"{prefix}finger_joint"]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        order = joint_order(names, UR_JOINTS, "test")
    assert [names[j] for j in order] == [prefix + name for name in UR_JOINTS]
    assert bool(caught) == bool(prefix)  # an exact name needs no word


def test_another_prefix_of_the_description_is_replaced() -> None:
    with pytest.warns(pid.PhysidentWarning, match="'fer_' in the recording stands for 'panda_'"):
        assert joint_order(["fer_joint2", "fer_joint1"], ["panda_joint1", "panda_joint2"], "test") == [1, 0]
    with pytest.raises(pid.InputError, match="2 arms"):
        joint_order([f"{arm}_joint{j}" for arm in ("left", "right") for j in (1, 2)], ["a_joint1", "a_joint2"], "test")
    with pytest.raises(pid.InputError, match="has no joint a_joint2"):
        joint_order(["a_joint1", "a_joint3"], ["a_joint1", "a_joint2"], "test")
    with pytest.raises(pid.InputError, match="no joint"):  # a part of a word is no prefix
        joint_order(["xjoint1", "xjoint2"], ["joint1", "joint2"], "test")


def test_a_gripper_in_the_messages_or_between_them_is_left_out(tmp_path: Path, recording: pid.Recording) -> None:
    together, between = states(recording, UR_JOINTS), states(recording, UR_JOINTS)
    for message in together:
        message["name"] = ["finger", *message["name"]]
        for channel in ("position", "velocity", "effort"):
            message[channel] = np.concatenate([[0.04], message[channel]])
    gripper = [
        {"stamp": m["stamp"] + 1000, "name": ["finger"], "position": [0.04], "velocity": [0.0], "effort": [1.0]}
        for m in between
    ]
    mixed = [message for pair in zip(between, gripper, strict=True) for message in pair]
    for name, messages in (("together", together), ("between", mixed)):
        bag = write_states(tmp_path / name, [("/joint_states", messages)])
        assert same(pid.load_recording(bag, joints=UR_JOINTS), recording)
    assert pid.load_recording(tmp_path / "together").joint_names == ("finger", *UR_JOINTS)
    with pytest.raises(pid.InputError, match="different joints in turn"):
        pid.load_recording(tmp_path / "between")


def test_a_topic_is_chosen(tmp_path: Path, recording: pid.Recording) -> None:
    other = states(recording, UR_JOINTS)
    for message in other:
        message["effort"] = message["effort"] + 1
    bag = write_states(
        tmp_path / "bag", [("/a/joint_states", states(recording, UR_JOINTS)), ("/b/joint_states", other)]
    )
    assert same(pid.load_recording(bag, topic="/a/joint_states"), recording)
    assert same(pid.load_recording(bag, "topic=/a/joint_states"), recording)
    np.testing.assert_allclose(pid.load_recording(bag, topic="/b/joint_states").effort, recording.effort + 1)
    with pytest.raises(pid.InputError, match=r"2 topics of joint states \(/a/joint_states, /b/joint_states\)"):
        pid.load_recording(bag)


def test_the_clock_is_that_of_the_headers_or_else_of_the_arrival(tmp_path: Path, recording: pid.Recording) -> None:
    messages = states(recording, UR_JOINTS)
    bag = write_states(tmp_path / "bag", [("/joint_states", messages)], stamped=False)
    np.testing.assert_array_equal(pid.load_recording(bag).time, recording.time)


def test_rows_that_cannot_be_read_are_named(tmp_path: Path, recording: pid.Recording) -> None:
    messages = states(recording, UR_JOINTS)
    messages[9]["effort"] = messages[9]["effort"][:3]
    messages[19]["effort"] = []
    messages[29]["position"] = np.full(6, np.nan)
    loaded = pid.load_recording(write_states(tmp_path / "bag", [("/joint_states", messages)]))
    assert [bad.row for bad in loaded.rejected] == [10, 20, 30]
    assert "6 names" in loaded.rejected[0].reason


def test_velocity_may_be_missing(tmp_path: Path, recording: pid.Recording) -> None:
    for name, empty in (("none", np.zeros(0)), ("nan", np.full(6, np.nan))):
        messages = states(recording, UR_JOINTS)
        for message in messages:
            message["velocity"] = empty
        assert pid.load_recording(write_states(tmp_path / name, [("/joint_states", messages)])).dq is None


def test_effort_is_a_current_where_drive_gains_are_given(tmp_path: Path, recording: pid.Recording) -> None:
    bag = write_bag(tmp_path / "bag", recording)
    loaded = pid.load_recording(bag)
    np.testing.assert_array_equal(loaded.torque, recording.effort)
    gains = np.array([14.0, 13.0, 11.0, 10.0, 11.0, 12.0])
    current = pid.load_recording(bag, drive_gains=gains.tolist())
    assert current.effort_kind == "current"
    np.testing.assert_array_equal(current.torque, recording.effort * gains)
    with pytest.warns(pid.PhysidentWarning, match="taken as motor currents"):
        assert loaded.with_default_drive_gains(gains.tolist()).effort_kind == "current"
    with pytest.raises(pid.InputError, match="contains torques"):
        pid.Recording.from_frame(recording.to_pandas(), drive_gains=gains.tolist())


def test_joints_are_declared_where_their_names_are_others(tmp_path: Path, recording: pid.Recording) -> None:
    names = [f"axis-{letter}" for letter in "fedcba"]
    bag = write_bag(tmp_path / "bag", recording, names=names, order=(3, 1, 0, 2, 5, 4))
    with pytest.raises(pid.InputError, match="has no joint shoulder_pan_joint"):
        pid.load_recording(bag, joints=UR_JOINTS)
    assert same(pid.load_recording(bag, f"joints={' '.join(names)}", joints=UR_JOINTS), recording)


@pytest.mark.parametrize(("bag", "n"), [("ur10_exciting_trajectory", 6), ("panda_exciting_trajectory", 7)])
def test_real_bags_are_read(data: Path, bag: str, n: int) -> None:
    recording = pid.load_recording(data / "rosbag2" / f"{bag}.db3")
    assert recording.n == n
    assert not recording.rejected
    assert recording.joint_names is not None
    assert len(recording.time) == {6: 3441, 7: 727}[n]


def description(path: str) -> str:
    """The text of a description in the package example-robot-data, which is installed beside pinocchio."""
    file = Path(pin.__file__).parents[4] / "share" / "example-robot-data" / "robots" / path
    if not file.is_file():
        pytest.skip("the descriptions of these arms are in the package example-robot-data")
    return file.read_text(encoding="utf-8")


def one_command(bag: Path, urdf: str, folder: Path) -> pid.Estimate:
    (folder / "arm.urdf").write_text(urdf)
    assert run(["identify", str(bag), "--robot", str(folder / "arm.urdf"), "--out", str(folder / "model.json")]) == 0
    return pid.load_estimate(folder / "model.json")


def test_the_ur10s_bag_ends_in_a_model_from_one_command(data: Path, tmp_path: Path) -> None:
    """Each joint but the last, which creeps, is explained better than by the model that the owners published."""
    bag = data / "rosbag2" / "ur10_exciting_trajectory.db3"
    estimate = one_command(bag, description("ur_description/urdf/ur10_robot.urdf"), tmp_path)
    assert (estimate.relative[:5] < [19.5, 6.9, 5.3, 12.4, 18.5]).all()


def test_the_pandas_bag_ends_in_a_model_from_one_command(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The bag names the joints fer_joint1 to fer_joint7; the fingers of the description are fixed for this test."""
    urdf = re.sub("<mimic[^>]*>", "", description("panda_description/urdf/panda.urdf")).replace("prismatic", "fixed")
    estimate = one_command(data / "rosbag2" / "panda_exciting_trajectory.db3", urdf, tmp_path)
    assert capsys.readouterr().err.count("'fer_' in the recording stands for 'panda_'") == 1
    assert (estimate.relative[1:4] < 5).all()  # the joints with gravity; the others carry little but noise
