"""Which joints of a vendor's description move: locking, coupled fingers, the order of joints, the tool, strict numbers."""

from __future__ import annotations

import json
import time
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.robots.joint_selection import select_joints
from physident.robots.load import parse_locks
from tests.robots import TREE
from tests.vendor_robots import MOBILE, packaged

ARMS = [f"{side}_{i}" for side in ("left", "right") for i in (1, 2, 3)]


@pytest.fixture
def mobile(tmp_path: Path) -> Path:
    path = tmp_path / "mobile.urdf"
    path.write_text(MOBILE)
    return path


def configuration(model: Any, positions: Mapping[str, float]) -> np.ndarray:
    """Pinocchio's configuration of positions by joint name, continuous joints as cosine and sine, others neutral."""
    q = pin.neutral(model)
    for i in range(1, model.njoints):
        joint, value = model.joints[i], positions.get(model.names[i])
        if value is not None and joint.nv == 1:
            q[joint.idx_q : joint.idx_q + joint.nq] = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
    return q


def expected_torques(whole: Any, robot: pid.Robot, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Inverse dynamics of Pinocchio's own reading of the whole file, its locked joints held where ``robot`` says."""
    places = {joint.name: joint.position for joint in robot.locked} | dict(zip(robot.joint_names, q, strict=True))
    full_v, full_a = np.zeros(whole.nv), np.zeros(whole.nv)
    rows = [whole.joints[whole.getJointId(name)].idx_v for name in robot.joint_names]
    full_v[rows], full_a[rows] = v, a
    whole.armature[:] = 0
    return pin.rnea(whole, whole.createData(), configuration(whole, places), full_v, full_a)[rows]


def assert_same_torques(whole: Any, robot: pid.Robot, seed: int = 0) -> None:
    for q, v, a in np.random.default_rng(seed).uniform(-1, 1, (4, 3, robot.n)):
        torque = pin.rnea(robot.pinocchio, robot.pinocchio.createData(), q, v, a)
        expected = expected_torques(whole, robot, q, v, a)
        np.testing.assert_allclose(torque, expected, atol=1e-10 * max(1.0, float(np.abs(expected).max())))


@pytest.mark.parametrize(
    ("joints", "lock"),
    [
        (None, None),
        (None, {"wheel_1": 0.7, "lift": -0.3}),
        (["left_1", "left_2", "left_3"], {"lift": 0.4, "right_1": 1.2, "left_finger_1": 0.25}),
        (["right_1", "right_2", "right_3", *ARMS[:3]], {"right_finger_2": 0.5}),
    ],
)
def test_locked_joints_are_held_where_the_robot_says(
    mobile: Path, joints: list[str] | None, lock: dict[str, float] | None
) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pid.PhysidentWarning)
        robot = pid.load_robot(mobile, joints=joints, lock=lock)
    if joints is not None:
        assert robot.joint_names == tuple(joints)
    assert {joint.name for joint in robot.locked} >= {"drive", *(lock or {})}
    for joint in robot.locked:
        assert lock is None or joint.position == lock.get(joint.name, joint.position)
    assert_same_torques(pin.buildModelFromXML(MOBILE), robot)


def test_coupled_fingers_follow_the_finger_that_they_mimic(mobile: Path) -> None:
    robot = pid.load_robot(mobile, joints="left_1, left_2, left_3", lock={"left_finger_1": 0.3})
    places = {joint.name: joint.position for joint in robot.locked}
    assert places["left_finger_2"] == pytest.approx(-2 * 0.3 + 0.1)
    assert places["right_finger_2"] == pytest.approx(0.1)
    said = robot.locked_text()
    assert "left_finger_1 at 0.3 m (as given)" in said
    assert "left_finger_2 at -0.5 m (mimics left_finger_1)" in said
    assert "drive where it is described (a floating base)" in said
    assert said in repr(robot)


def test_what_is_locked_without_being_asked_is_said(mobile: Path) -> None:
    with pytest.warns(pid.PhysidentWarning, match="mobile.urdf: locked: drive where it is described"):
        robot = pid.load_robot(mobile)
    assert robot.joint_names == ("lift", *ARMS, "wheel_1")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pid.load_robot(mobile, joints="left_?")


def test_the_order_of_the_joints_is_that_of_the_names(mobile: Path) -> None:
    left, right = ["left_1", "left_2", "left_3"], ["right_1", "right_2", "right_3"]
    one, other = (pid.load_robot(mobile, joints=names) for names in (left + right, right + left))
    swapped = np.r_[3:6, 0:3]
    for q, v, a in np.random.default_rng(1).uniform(-1, 1, (3, 3, 6)):
        torques = [
            pin.rnea(r.pinocchio, r.pinocchio.createData(), *(x[rows] for x in (q, v, a)))
            for r, rows in ((one, np.arange(6)), (other, swapped))
        ]
        np.testing.assert_allclose(torques[0][swapped], torques[1], atol=1e-12)
    again = pid.Robot.from_dict(json.loads(json.dumps(other.as_dict(), allow_nan=False)))
    assert again.joint_names == other.joint_names
    assert again.as_dict() == other.as_dict()
    assert again.locked == other.locked


def test_a_set_of_names_has_the_order_of_the_description(mobile: Path) -> None:
    """As names of a recording are, whose columns are put in the robot's order."""
    robot = pid.load_robot(mobile, joints={"left_3", "left_1", "left_2"})
    assert robot.joint_names == ("left_1", "left_2", "left_3")
    assert robot.joint_order is None


def test_an_older_robot_file_is_read(ur5: pid.Robot) -> None:
    new = {"joint_order", "tool_frame", "locked", "joint_dynamics", "origin"}
    old = {key: value for key, value in ur5.as_dict().items() if key not in new}
    np.testing.assert_array_equal(pid.Robot.from_dict(old).nominal, ur5.nominal)


def test_the_tool_is_the_named_link_or_the_last_one_before_the_fingers(mobile: Path) -> None:
    by_default = pid.load_robot(mobile, joints="left_?")
    np.testing.assert_allclose(by_default.tool, [0.05, 0.1, 0.3])
    np.testing.assert_array_equal(pid.load_robot(mobile, joints="left_?", tool="left_tcp").tool, by_default.tool)
    np.testing.assert_array_equal(pid.load_robot(mobile, joints="left_?", tool="left_hand").tool, np.zeros(3))
    # on the last joint of the order, here the left arm's
    assert pid.load_robot(mobile, joints="right_?,left_?", tool="left_tcp").tool_frame == "left_tcp"


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "unknown joint": ({"joints": ["left_1", "lef_2"]}, "no moving joint 'lef_2'; did you mean 'left_2'"),
    "unknown pattern": ({"joints": "arm_*"}, r"no moving joint 'arm_\*'"),
    "a fixed joint": ({"joints": ["left_flange"]}, "no moving joint 'left_flange'"),
    "a floating joint": ({"joints": ["drive"]}, "'drive' is floating"),
    "no joint": ({"joints": []}, "no joints were chosen"),
    "no name": ({"joints": " , "}, "no joints were chosen, expected some of"),
    "a joint twice": ({"joints": ["left_1", "left_*"]}, "'left_1' is chosen twice"),
    "tip before base": ({"joints": ["left_2", "left_1"]}, "'left_2' comes before 'left_1'.*base to tip"),
    "chosen and locked": ({"joints": ["left_1"], "lock": {"left_1": 0.1}}, "chosen to move and locked"),
    "a finger that mimics": ({"joints": ["left_1", "left_finger_2"]}, "'left_finger_2' mimics 'left_finger_1'"),
    "unknown lock": ({"lock": {"left_9": 0.1}}, "lock: no moving joint 'left_9'"),
    "beyond its limits": ({"lock": {"left_1": 2.5}}, "left_1 = 2.5, expected a number within its limits, -2 to 2"),
    "no number": ({"lock": {"left_1": float("nan")}}, "left_1 = nan"),
    "a text": ({"lock": {"left_1": "0.1"}}, "lock is a dict, expected a mapping from text to a number"),
    "a floating lock": ({"lock": {"drive": 0.0}}, "stays where it is described"),
    "unknown tool": (
        {"joints": "left_?", "tool": "tcp"},
        "tool 'tcp' is not a link; expected one of left_hand, left_tcp",
    ),
    "tool of the other arm": ({"joints": "left_?", "tool": "right_tcp"}, "does not move with the last joint, 'left_3'"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_choice_that_cannot_be_made_is_refused(mobile: Path, case: str) -> None:
    options, says = REFUSED[case]
    with pytest.raises(pid.InputError, match=says) as refused:
        pid.load_robot(mobile, **options)
    assert len(str(refused.value).splitlines()) == 1


@pytest.mark.parametrize(
    "entry", ["finger", "finger=", "=0.1", "finger=open", "finger=inf", "finger=٢", "a=1,a=2", "", ","]
)
def test_a_lock_that_is_no_name_and_number_is_refused(entry: str) -> None:
    with pytest.raises(pid.InputError, match="lock:"):
        parse_locks([entry])


def test_locks_are_names_and_numbers() -> None:
    assert parse_locks(["a=0.1,b=-2", "c = 3e-2"]) == {"a": 0.1, "b": -2.0, "c": 0.03}


def test_a_description_without_anything_to_lock_keeps_every_byte() -> None:
    assert select_joints(TREE, "tree.urdf").urdf == TREE


# --------------------------------------------------------------------------------------------- numbers, read once
def test_white_space_around_a_number_changes_nothing(tmp_path: Path) -> None:
    """Other readers of URDF take a mass of "8.393 " for zero."""
    path = tmp_path / "spaced.urdf"
    path.write_text(
        TREE.replace('"3.0"', '" 3.0 "').replace('ixx="0.05"', 'ixx="0.05\t"').replace('"1 2 0.5"', '" 1  2 0.5 "')
    )
    np.testing.assert_array_equal(pid.load_robot(path).nominal, pid.Robot("tree", TREE).nominal)


@pytest.mark.parametrize("mass", ["٣", "3_0", "0x3", "3,0", "3 0", "three", "３", "1e", "--3", "+", "."])
def test_a_number_in_other_digits_is_refused(tmp_path: Path, mass: str) -> None:
    path = tmp_path / "odd.urdf"
    path.write_text(TREE.replace('"3.0"', f'"{mass}"'))
    with pytest.raises(pid.InputError, match=r"link 'cart': mass is .*plain digits"):
        pid.load_robot(path)


# --------------------------------------------------------------------------------------------- size
def chain(links: int, kind: str) -> str:
    parts = ['<robot name="long"><link name="l0"/>']
    for i in range(1, links):
        parts.append(
            f'<link name="l{i}"/><joint name="j{i}" type="{kind}"><parent link="l{i - 1}"/><child link="l{i}"/>'
            '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        )
    return "".join([*parts, "</robot>"])


@pytest.mark.parametrize(
    ("links", "kind", "says"),
    [(4_000, "fixed", "4000 links"), (60_000, "fixed", "60000 links"), (51, "revolute", "50 moving joints")],
)
def test_a_robot_that_is_too_large_is_refused_at_once(tmp_path: Path, links: int, kind: str, says: str) -> None:
    path = tmp_path / "long.urdf"
    path.write_text(chain(links, kind))
    start = time.perf_counter()
    with pytest.raises(pid.InputError, match=says):
        pid.load_robot(path)
    assert time.perf_counter() - start < 10


def test_the_longest_chain_that_is_read_is_right(tmp_path: Path) -> None:
    path = tmp_path / "long.urdf"
    path.write_text(chain(999, "fixed").replace('name="j1" type="fixed"', 'name="j1" type="revolute"'))
    with pytest.warns(pid.PhysidentWarning, match="no inertial element with a mass on the links moved by j1"):
        assert pid.load_robot(path).n == 1


# --------------------------------------------------------------------------------------------- stock descriptions
STOCK = {
    "panda": ("panda_description/urdf/panda.urdf", [f"panda_joint{i}" for i in range(1, 8)]),
    "ur10": ("ur_description/urdf/ur10_robot.urdf", None),
    "tiago": ("tiago_description/robots/tiago.urdf", [f"arm_{i}_joint" for i in range(1, 8)]),
    "kinova": ("kinova_description/robots/kinova.urdf", None),
    "xarm7": ("xarm_description/urdf/xarm7.urdf", None),
    "two arms": (
        "baxter_description/urdf/baxter.urdf",
        [f"{side}_{joint}" for side in ("right", "left") for joint in ("s0", "s1", "e0", "e1", "w0", "w1", "w2")],
    ),
    "mobile base": (
        "pr2_description/urdf/pr2.urdf",
        [f"r_{j}_joint" for j in ("shoulder_pan", "shoulder_lift", "upper_arm_roll", "elbow_flex", "forearm_roll")],
    ),
}


@pytest.mark.filterwarnings("ignore::physident.PhysidentWarning")
@pytest.mark.parametrize("name", STOCK)
def test_stock_descriptions_have_the_torques_of_pinocchio_s_own_parser(name: str) -> None:
    file, joints = STOCK[name]
    path = packaged(file)
    if path is None:
        pytest.skip("the package example-robot-data is not installed")
    robot = pid.load_robot(path, joints=joints)
    if joints is not None:
        assert robot.joint_names == tuple(joints)
    assert_same_torques(pin.buildModelFromUrdf(str(path)), robot)


@pytest.mark.filterwarnings("ignore::physident.PhysidentWarning")
def test_a_stock_panda_is_seven_joints_without_an_edit() -> None:
    path = packaged("panda_description/urdf/panda.urdf")
    if path is None:
        pytest.skip("the package example-robot-data is not installed")
    robots = [pid.load_robot(path), pid.load_robot("panda"), pid.load_robot(path, joints="panda_joint?")]
    for robot in robots:
        assert robot.joint_names == tuple(f"panda_joint{i}" for i in range(1, 8))
        np.testing.assert_array_equal(robot.nominal, robots[0].nominal)
        np.testing.assert_allclose(robot.tool, [0, 0, 0.107 + 0.1034], atol=1e-4)  # flange and fingertips
