"""A MuJoCo file is a robot and its simulation: torques agree with MuJoCo's own, and a changed number is found."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.cli import run
from physident.files import naming
from physident.recordings.signals import Signals
from tests.bad_input.nested import leaves, replaced
from tests.mujoco_recording import record, written
from tests.vendor_robots import MJCF_OF_ALL_KINDS, mjcf

Array = np.ndarray


def saved(folder: Path, text: str, name: str = "arm.xml") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def states(path: Path, robot: pid.Robot, count: int, slow: float = 1.0) -> tuple[Array, Array, Array, Array]:
    """Random positions, velocities, accelerations (count, n), and MuJoCo's inverse dynamics with all its forces."""
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT) | int(mujoco.mjtDisableBit.mjDSBL_LIMIT)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EQUALITY)
    data = mujoco.MjData(model)
    dofs = [model.joint(name).dofadr[0] for name in robot.joint_names]
    places = [model.joint(name).qposadr[0] for name in robot.joint_names]
    q, v, a = np.random.default_rng(0).uniform(-1.5, 1.5, (3, count, robot.n))
    v, a = slow * v, slow * a
    torque = np.zeros((count, robot.n))
    for k in range(count):
        mujoco.mj_resetData(model, data)
        data.qpos[places], data.qvel[dofs], data.qacc[dofs] = q[k], v[k], a[k]
        mujoco.mj_inverse(model, data)
        torque[k] = data.qfrc_inverse[dofs]
    return q, v, a, torque


@pytest.mark.parametrize("text", [MJCF_OF_ALL_KINDS, mjcf()], ids=["all kinds", "plain"])
@pytest.mark.filterwarnings("ignore::physident.PhysidentWarning")
def test_inverse_dynamics_are_mujoco_s(tmp_path: Path, text: str) -> None:
    """Armature, damping, springs and dry friction included, where each joint moves fast enough for its friction."""
    path = saved(tmp_path, text)
    robot = pid.load_robot(path)
    q, v, a, torque = states(path, robot, 200)
    model = pid.Model.described(robot)
    predicted = model.torque(Signals.of_states(q, v, a))
    slip = np.abs(v + robot.friction_lead * a) > 25 * np.maximum(robot.friction_width, 1e-9)  # tanh of that is 1
    assert slip.mean() > 0.5
    assert np.abs(torque).max() > 10
    assert np.abs(predicted - torque)[slip].max() < 1e-8


@pytest.mark.filterwarnings("ignore::physident.PhysidentWarning")
def test_dry_friction_softens_at_the_speed_of_mujoco_s(tmp_path: Path) -> None:
    """Near zero speed MuJoCo's friction is a ramp; the smooth sign of the same slope stays near it."""
    path = saved(tmp_path, mjcf())
    robot = pid.load_robot(path)
    q, v, a, torque = states(path, robot, 400, slow=0.01)
    model = pid.Model.described(robot)
    rest = pid.Model.nominal(robot, ["rigid_body", "rotor_inertia", "viscous_friction"])
    signals = Signals.of_states(q, v, a)
    friction = (torque - rest.torque(signals)) / robot.dry_friction
    ramp = np.clip((v + robot.friction_lead * a) / robot.friction_width, -1, 1)
    np.testing.assert_allclose(friction, ramp, atol=1e-8)
    assert np.abs((model.torque(signals) - torque) / robot.dry_friction).max() < 0.24  # 1 - tanh(1)


@pytest.mark.filterwarnings("ignore::physident.PhysidentWarning")
def test_what_a_mujoco_file_states_is_in_the_robot(tmp_path: Path) -> None:
    path = saved(tmp_path, MJCF_OF_ALL_KINDS)
    robot = pid.load_robot(path)
    assert robot.joint_names == ("j1", "s1", "j2", "j3")
    assert [joint.kind for joint in robot.joints] == ["revolute", "prismatic", "revolute", "revolute"]
    assert robot.gravity == (0.3, -0.5, -9.7)
    np.testing.assert_allclose(robot.rotor_inertia, [0.2, 0.5, 0.1, 100 * 0.001])
    np.testing.assert_array_equal(robot.damping, [1.5, 2, 0, 0.3])
    np.testing.assert_array_equal(robot.dry_friction, [0.7, 2, 1, 0])
    np.testing.assert_allclose(robot.friction_lead[:3], [0.0095, 0.0095, 1 / 60])
    np.testing.assert_array_equal(robot.spring_stiffness, [3, 0, 0, 0])
    np.testing.assert_allclose(robot.spring_offset, [-3 * 0.4, 0, 0, 0])
    np.testing.assert_array_equal(robot.lower, [-2, -1, -np.inf, -np.inf])
    assert robot.torque_limit[0] == 50 * 2
    assert robot.joint_dynamics is not None
    assert [one.gear for one in robot.joint_dynamics] == [50, 1, 1, 10]
    assert robot.origin is not None
    assert (robot.origin.format, robot.origin.path) == ("mjcf", str(path))
    assert robot.origin.bodies == ("a", "a", "a", "b")
    assert {joint.name for joint in robot.locked} == {"f1", "f2", "cube_joint"}
    again = pid.Robot.from_dict(json.loads(json.dumps(robot.as_dict(), allow_nan=False)))
    assert again.as_dict() == robot.as_dict()
    assert again.joint_dynamics == robot.joint_dynamics
    assert again.origin == robot.origin


@pytest.mark.filterwarnings("ignore::physident.PhysidentWarning")
def test_a_saved_robot_with_any_entry_replaced_loads_or_says_why(tmp_path: Path) -> None:
    robot = pid.load_robot(saved(tmp_path, MJCF_OF_ALL_KINDS), joints="j1,s1,j2,j3", tool="tool")
    entries = json.loads(json.dumps(robot.as_dict()))
    del entries["urdf"]
    refused = []
    for path in leaves(entries):
        for value in (None, [], {}, "x", "a\nb", -1, 1e308, 10**400, [[1]], True, float("nan")):
            try:
                with naming("robot.json", "robot", "save it again"):
                    pid.Robot.from_dict(replaced(entries, path, value) | {"urdf": robot.urdf})
            except pid.InputError as error:
                refused.append(str(error))
    assert len(refused) > 100
    assert all(len(line.splitlines()) == 1 for line in refused)


def test_fingers_of_a_mujoco_file_are_locked_where_they_are_put(tmp_path: Path) -> None:
    path = saved(tmp_path, MJCF_OF_ALL_KINDS)
    robot = pid.load_robot(path, joints="j1,s1,j2,j3", lock={"f2": 0.03})
    assert {joint.name: joint.position for joint in robot.locked if joint.kind == "prismatic"} == {
        "f1": 0.03,
        "f2": 0.03,
    }
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    data.qpos[[model.joint(name).qposadr[0] for name in ("f1", "f2")]] = 0.03
    mujoco.mj_forward(model, data)
    arm = robot.pinocchio
    pin_data = arm.createData()
    gravity = pin.computeGeneralizedGravity(
        arm, pin_data, np.array([model.joint(n).qpos0[0] for n in robot.joint_names])
    )
    dofs = [model.joint(name).dofadr[0] for name in robot.joint_names]
    np.testing.assert_allclose(gravity, data.qfrc_bias[dofs], atol=1e-9)


def test_identify_keeps_plain_friction(tmp_path: Path) -> None:
    """The lead of a simulator's friction belongs to the simulation, not to an arm that is identified."""
    robot = pid.load_robot(saved(tmp_path, mjcf()))
    assert all(getattr(effect, "lead", 0.0) == 0.0 for effect in pid.Model.nominal(robot).effects)


def test_the_model_of_a_description_is_what_the_description_states(tmp_path: Path, ur5: pid.Robot) -> None:
    robot = pid.load_robot(saved(tmp_path, mjcf()))
    names = {effect.name for effect in pid.Model.described(robot).effects}
    assert names == {"rigid_body", "rotor_inertia", "viscous_friction", "coulomb_friction"}
    assert [effect.name for effect in pid.Model.described(ur5).effects] == ["rigid_body"]  # a table is no simulation


def test_the_exported_function_has_the_same_friction(tmp_path: Path) -> None:
    model = pid.Model.described(pid.load_robot(saved(tmp_path, mjcf())))
    pid.export_python(model, tmp_path / "torque.py")
    exported: dict[str, Any] = {}
    exec((tmp_path / "torque.py").read_text(encoding="utf-8"), exported)
    q, v, a = np.random.default_rng(2).normal(size=(3, 50, 4)) * 0.02
    np.testing.assert_allclose(exported["torque"](q, v, a), model.torque(Signals.of_states(q, v, a)), atol=1e-9)


# --------------------------------------------------------------------------------------------- what a simulation gets wrong
@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder = tmp_path_factory.mktemp("runs")
    return [written(folder, f"run_{seed}.csv", record(mjcf(), seed)) for seed in (1, 2)]


@pytest.mark.parametrize(
    ("changed", "effect", "value"),
    [
        ({"damping": 12.0}, "viscous_friction", 8.0),
        ({"friction": 6.0}, "coulomb_friction", 4.0),
        ({"armature": 0.5}, "rotor_inertia", 0.3),
        ({"mass": 5.0}, "link_inertia", None),
        ({"option": '<option gravity="0 0 -9.3"/>'}, "gravity_magnitude", 0.51),
    ],
    ids=["damping", "frictionloss", "armature", "mass", "gravity"],
)
def test_a_changed_number_is_named_first(
    changed: dict[str, Any], effect: str, value: float | None, runs: list[str], tmp_path: Path
) -> None:
    """The arm has the number of the recording, its file another; the finding's value is the recorded arm's."""
    path = saved(tmp_path, mjcf(**changed))
    assert run(["diagnose", "--robot", str(path), *runs, "--json", str(tmp_path / "found.json")]) == 0
    found = json.loads((tmp_path / "found.json").read_text(encoding="utf-8"))
    first = found["findings"][0]
    assert first["effect"] == effect
    parameters = {one["joint"]: one["value"] for one in first["parameters"]}
    if effect == "gravity_magnitude":
        assert first["joints"] == []
        assert re.fullmatch(
            r"Gravity is 5\.4\d % larger than described: 9\.8\d+ instead of 9\.3 m/s\^2\.", first["in_words"]
        )
        assert parameters[1] == pytest.approx(value, rel=0.02)
        return
    assert first["joints"] == [3]
    assert [one["effect"] for one in found["findings"] if one["grade"] == "cause"] == [effect]
    if value is not None:
        assert parameters[3] == pytest.approx(value, rel=0.02)


def test_gravity_of_another_size_is_no_suspect_of_a_real_arm(ur5: pid.Robot, tmp_path: Path) -> None:
    """A URDF states no gravity; a simulation does, and so does a description with another planet's."""
    suspect = pid.CATALOGUE["gravity_magnitude"].can_be_wrong
    assert not suspect(ur5)
    assert suspect(pid.load_robot("ur5", gravity=(0, 0, -1.62)))
    assert suspect(pid.load_robot(saved(tmp_path, mjcf())))


# --------------------------------------------------------------------------------------------- what cannot be read
REFUSED: dict[str, tuple[str, str]] = {
    "malformed": (mjcf()[:-20], "malformed XML|cannot compile"),
    "unknown element": (mjcf().replace("<worldbody>", "<worldbody><wheel/>"), "MuJoCo cannot compile.*wheel"),
    "missing mesh": (mjcf(option='<asset><mesh name="m" file="none.stl"/></asset>'), "none.stl"),
    "no joints": ("<mujoco><worldbody><body><geom size='1'/></body></worldbody></mujoco>", "no hinge or slide joint"),
    "only a cube": (
        "<mujoco><worldbody><body><freejoint/><geom size='1'/></body></worldbody></mujoco>",
        "no hinge or slide joint",
    ),
    "a body without mass": (mjcf().replace('mass="1.5"', 'mass="0"'), "mass"),
    "an include": (mjcf(option='<include file="none.xml"/>'), "none.xml"),
    "a million copies": (
        mjcf().replace(
            '<body name="base"',
            '<replicate count="1000"><replicate count="1000"><body><geom size="1"/></body></replicate></replicate><body name="base"',
        ),
        r"makes 10000\d\d bodies",
    ),
    "entities": ('<!DOCTYPE m [<!ENTITY a "b">]>' + mjcf(), "entities"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_file_that_mujoco_cannot_read_is_refused_in_one_line(case: str, tmp_path: Path) -> None:
    text, says = REFUSED[case]
    with pytest.raises(pid.InputError, match=says) as refused:
        pid.load_robot(saved(tmp_path, text))
    assert len(str(refused.value).splitlines()) == 1


def test_without_the_package_one_line_says_how_to_get_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = saved(tmp_path, mjcf())
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(pid.InputError, match=r"pip install 'physident\[mujoco\]'"):
        pid.load_robot(path)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('<body name="hand"', '<body name="hand" gravcomp="1"', "the gravity compensation of hand"),
        ("<worldbody>", '<option density="1.2" viscosity="0.1"/><worldbody>', "the drag of the medium"),
        (
            "<actuator>",
            '<tendon><fixed stiffness="5"><joint joint="wrist" coef="1"/></fixed></tendon><actuator>',
            "stiffness, damping, friction or armature of tendon 1",
        ),
        (
            "<actuator>",
            '<equality><joint joint1="wrist" joint2="elbow" polycoef="0 1 2 0 0"/></equality><actuator>',
            "the constraint equality 1",
        ),
    ],
    ids=["gravity compensation", "drag", "tendon", "constraint"],
)
def test_forces_that_the_model_leaves_out_are_named(old: str, new: str, says: str, tmp_path: Path) -> None:
    path = saved(tmp_path, mjcf().replace(old, new))
    with pytest.warns(pid.PhysidentWarning, match=f"not part of the model: .*{says}"):
        pid.load_robot(path)


def test_switched_off_parts_of_the_simulation_are_off(tmp_path: Path) -> None:
    off = '<option><flag gravity="disable" damper="disable" frictionloss="disable"/></option>'
    robot: Any = pid.load_robot(saved(tmp_path, mjcf(option=off)))
    assert robot.gravity == (0.0, 0.0, 0.0)
    assert not robot.damping.any()
    assert not robot.dry_friction.any()
    assert robot.rotor_inertia.any()
