"""Where descriptions come from: built-in arms, xacro files, packages of descriptions, and the options of the command line."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.cli import run
from tests.robots import TREE
from tests.vendor_robots import MOBILE, mjcf


# --------------------------------------------------------------------------------------------- built in
def test_the_built_in_ur10e_moves_as_the_recorded_arm_s_description(data: Path) -> None:
    """Its zero positions are those of the recordings; ROS turns the base by half a turn and rounds lengths to millimetres."""
    built_in, described = pid.load_robot("ur10e"), pid.load_robot(data / "ur10e" / "ur10e.urdf")
    assert built_in.joint_names == described.joint_names
    half_turn = np.diag([-1.0, -1.0, 1.0])
    for q in np.random.default_rng(0).uniform(-3, 3, (20, 6)):
        places = []
        for robot in (built_in, described):
            frames = robot.pinocchio.createData()
            pin.framesForwardKinematics(robot.pinocchio, frames, q)
            places.append(frames.oMf[robot.pinocchio.getFrameId("tool0")].translation)
        assert np.linalg.norm(half_turn @ places[0] - places[1]) < 3e-3
    np.testing.assert_allclose(built_in.torque_limit, described.torque_limit, rtol=0.05)
    ratio = built_in.nominal[::10] / described.nominal[::10]
    assert (np.abs(ratio[:5] - 1) < 0.1).all()  # the wrist's last link differs


@pytest.mark.filterwarnings("error")
def test_the_built_in_ur10e_is_a_physical_arm() -> None:
    robot = pid.load_robot("ur10e")
    assert robot.n == 6
    assert robot.nominal[::10].sum() == pytest.approx(29.104)
    assert robot.origin == pid.Robot.from_dict(robot.as_dict()).origin


# --------------------------------------------------------------------------------------------- xacro
XACRO = (
    TREE.replace('<robot name="tree">', '<robot name="tree" xmlns:xacro="http://www.ros.org/wiki/xacro">')
    .replace('<link name="base"/>', '<xacro:property name="m" value="1.5"/><link name="base"/>', 1)
    .replace('<mass value="3.0"/>', '<mass value="${2 * m}"/>')
)


def test_a_xacro_file_is_expanded(tmp_path: Path) -> None:
    pytest.importorskip("xacro", reason="the package xacro is not installed")
    path = tmp_path / "tree.urdf.xacro"
    path.write_text(XACRO)
    np.testing.assert_array_equal(pid.load_robot(path).nominal, pid.Robot("tree", TREE).nominal)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("${2 * m}", "${2 * missing}"),
        ("${2 * m}", "${"),
        ("</robot>", '<xacro:include filename="none.xacro"/></robot>'),
        ("</robot>", '<xacro:include filename="$(find no_package)/none.xacro"/></robot>'),
        ("</robot>", "<xacro:wheel/></robot>"),
        ("</robot>", ""),
        ("${2 * m}", "${1 / 0}"),
    ],
)
def test_a_xacro_file_that_cannot_be_expanded_is_refused(
    old: str, new: str, tmp_path: Path, capfd: pytest.CaptureFixture
) -> None:
    pytest.importorskip("xacro", reason="the package xacro is not installed")
    path = tmp_path / "tree.xacro"
    path.write_text(XACRO.replace(old, new))
    with pytest.raises(pid.InputError, match="xacro cannot expand this file") as refused:
        pid.load_robot(path)
    assert len(str(refused.value).splitlines()) == 1
    assert capfd.readouterr() == ("", "")


def test_without_xacro_one_line_says_how_to_get_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "tree.xacro"
    path.write_text(XACRO)
    monkeypatch.setitem(sys.modules, "xacro", None)
    with pytest.raises(pid.InputError, match=r"pip install 'physident\[xacro\]', or the URDF that xacro writes"):
        pid.load_robot(path)


# --------------------------------------------------------------------------------------------- packages
@pytest.fixture
def descriptions(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package like robot_descriptions: a module for each robot, with the path of its file; one fails to download."""
    package = tmp_path / "packages" / "robot_descriptions"
    package.mkdir(parents=True)
    (tmp_path / "tree.urdf").write_text(TREE)
    (tmp_path / "arm.xml").write_text(mjcf())
    (package / "__init__.py").write_text("")
    (package / "twig_description.py").write_text(f"print('Cloning')\nURDF_PATH = {str(tmp_path / 'tree.urdf')!r}\n")
    (package / "armed_mj_description.py").write_text(f"MJCF_PATH = {str(tmp_path / 'arm.xml')!r}\n")
    (package / "far_description.py").write_text("raise OSError('no route\\nto host')\n")
    for name in [name for name in sys.modules if name.partition(".")[0] == "robot_descriptions"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.syspath_prepend(str(tmp_path / "packages"))
    return package


def test_a_name_is_looked_up_in_robot_descriptions(descriptions: Path, capfd: pytest.CaptureFixture) -> None:
    np.testing.assert_array_equal(pid.load_robot("twig").nominal, pid.Robot("tree", TREE).nominal)
    armed = pid.load_robot("armed")
    assert armed.joint_names == ("pan", "lift", "elbow", "wrist")
    assert armed.damping.any()
    with pytest.raises(
        pid.InputError, match=r"'far': robot_descriptions cannot provide it \(OSError: no route to host\)"
    ):
        pid.load_robot("far")
    with pytest.raises(pid.InputError, match="'near' not found"):
        pid.load_robot("near")
    assert capfd.readouterr() == ("", "")


def test_an_unknown_name_says_what_there_is(monkeypatch: pytest.MonkeyPatch) -> None:
    import physident.robots.sources as sources

    monkeypatch.setattr(sources, "PACKAGE", "no-such-package")
    monkeypatch.setattr(sources.importlib.util, "find_spec", lambda _: None)
    with pytest.raises(pid.InputError, match=r"\(ur5, ur10e\).*panda.*pip install 'physident\[robots\]'"):
        pid.load_robot("panda")


# --------------------------------------------------------------------------------------------- command line
@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("mobile.urdf").write_text(MOBILE)
    return tmp_path


def test_the_options_choose_the_arm_and_are_kept_in_the_model(folder: Path, capsys: pytest.CaptureFixture) -> None:
    chosen = ["--robot", "mobile.urdf", "--joints", "right_1,right_2,right_3", "--tool", "right_hand"]
    locked = ["--lock", "lift=0.25", "--lock", "right_finger_1=0.1"]
    design = ["design", *chosen, *locked, "--limits", "joint", "--harmonics", "2", "--out", "plan.json"]
    assert run(design) == 0
    assert "locked: drive where it is described" in capsys.readouterr().err
    assert run(["simulate", *chosen, *locked, "--trajectory", "plan.json", "--out", "run.csv"]) == 0
    assert run(["inspect", "run.csv", *chosen, *locked]) == 0
    assert run(["base-parameters", *chosen, *locked]) == 0
    assert run(["identify", "run.csv", *chosen, *locked, "--effects", "rigid_body", "--out", "model.json"]) == 0
    assert "lift at 0.25 m (as given)" in capsys.readouterr().err
    robot = pid.load_estimate("model.json").model.robot
    assert robot.joint_names == ("right_1", "right_2", "right_3")
    assert {joint.name: joint.position for joint in robot.locked}["lift"] == 0.25
    assert robot.tool_frame == "right_hand"
    saved = json.loads(Path("model.json").read_text(encoding="utf-8"))["robot"]
    assert saved["origin"] == {"format": "urdf", "path": "mobile.urdf", "bodies": []}


COMMANDS = {
    "inspect": ["inspect", "good.csv"],
    "design": ["design", "--out", "plan.json"],
    "simulate": ["simulate", "--trajectory", "plan.json", "--out", "out.csv"],
    "identify": ["identify", "good.csv", "--out", "m.json"],
    "drive-gains": ["drive-gains", "--unloaded", "a.csv", "--loaded", "b.csv", "--load-mass", "1"],
    "base-parameters": ["base-parameters"],
    "diagnose": ["diagnose", "good.csv", "--model", "m.json"],
    "view": ["view", "good.csv", "--out", "s.rrd"],
}


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("option", [["--joints", "a"], ["--lock", "a=1"], ["--tool", "a"]], ids=lambda x: x[0])
def test_options_of_a_robot_without_one_are_refused(
    command: str, option: list[str], folder: Path, capsys: pytest.CaptureFixture
) -> None:
    for name in ("good.csv", "a.csv", "b.csv"):
        rows = [f"{t / 100},{np.sin(t / 20)},{np.cos(t / 20)}" for t in range(300)]
        Path(name).write_text("\n".join(["time,q_1,tau_1", *rows]) + "\n")
    Path("plan.json").write_text("{}") if command == "simulate" else None
    assert run([*COMMANDS[command], *option]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert f"{option[0]} was given without --robot" in err or "plan.json" in err
