"""A model in MuJoCo has the torque that it has here."""

from __future__ import annotations

import subprocess
import sys
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

import physident as pid
from physident.cli import run
from physident.effects.friction import NonlinearViscousFriction, StribeckFriction
from physident.effects.hysteresis import PreslidingHysteresis
from physident.export.mjcf.callback import callback_of
from physident.export.mjcf.mjcf import mjcf_of
from physident.identifiability.base_parameters import random_motion
from physident.robots.inertia import link_parameters
from tests.conftest import UR10E_COLUMNS, UR10E_GAINS
from tests.exported_arms import NASTY, lumped, named_after_code, physical_model
from tests.mujoco_torque import inverse_dynamics, without_dry
from tests.robots import TREE


@pytest.mark.parametrize("maker", [lambda: pid.load_robot("ur5"), lumped, lambda: pid.Robot("tree", TREE)])
def test_inverse_dynamics_are_those_of_the_model(maker: Any) -> None:
    model = physical_model(replace(maker(), gravity=(1.0, -3.0, 8.0)), seed=21)
    states = random_motion(model.robot, seed=22, count=40)
    compiled = mujoco.MjModel.from_xml_string(mjcf_of(model).text)
    expected = without_dry(model, states)
    found = inverse_dynamics(compiled, states, model.robot.joint_names)
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()
    for j, name in enumerate(model.robot.joint_names):
        joint = compiled.joint(name)
        assert joint.frictionloss[0] == model.parameters("coulomb_friction")[j]
        assert compiled.actuator(name).trnid[0] == joint.id
    links = {element.get("name") for element in ET.fromstring(model.robot.urdf).findall("link")} - {"world"}
    assert links == {compiled.body(k).name for k in range(1, compiled.nbody)}


def test_every_effect_that_mjcf_has_a_place_for_is_exact() -> None:
    robot = pid.load_robot("ur5")
    names = "rigid_body rotor_inertia viscous_friction coulomb_friction joint_spring gravity_tilt gravity_magnitude payload coupled_friction"
    effects = pid.make_effects(names.split())
    theta = np.random.default_rng(23).uniform(0.1, 1.0, size=len(pid.Model.nominal(robot, effects).theta))
    model = pid.Model(robot, effects, theta)
    nominal = pid.Model.nominal(robot, effects).theta
    load = link_parameters(np.diag([0.1, 0.2, 0.3, 2.0]))
    theta = np.where([c.effect == "rigid_body" for c in model.columns], nominal, theta)
    theta[[c.effect == "payload" for c in model.columns]] = load
    theta[[c.name.startswith("coupled_friction_coulomb") for c in model.columns]] = 0.0
    model = replace(model, theta=theta)
    exported = mjcf_of(model)
    assert exported.stated == ()
    compiled = mujoco.MjModel.from_xml_string(exported.text)
    assert compiled.body("payload").mass[0] == 2.0
    states = random_motion(robot, seed=24, count=40)
    expected = without_dry(model, states)
    found = inverse_dynamics(compiled, states, robot.joint_names)
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.slow
def test_along_a_real_recording(data: Path) -> None:
    paths = [data / "ur10e" / f"ur-20_02_{name}.csv" for name in ("06-20sec_10harm", "10-30sec_12harm")]
    recordings = pid.load_recordings(paths, UR10E_COLUMNS, UR10E_GAINS)
    model = pid.identify(pid.load_robot(data / "ur10e" / "ur10e.urdf"), recordings, method="physical").model
    s = pid.prepare(recordings[1], pid.Filter())
    compiled = mujoco.MjModel.from_xml_string(mjcf_of(model).text)
    expected = without_dry(model, s)
    assert (
        np.abs(inverse_dynamics(compiled, s, model.robot.joint_names) - expected).max() < 1e-6 * np.abs(expected).max()
    )


def test_the_callback_adds_what_mjcf_lacks(tmp_path: Path) -> None:
    robot = pid.load_robot("ur5")
    laws = StribeckFriction((2,), (0.1,)), NonlinearViscousFriction(None, (0.5,)), PreslidingHysteresis((3,), (0.01,))
    effects = pid.make_effects(
        [*["rigid_body", "rotor_inertia", "load_dependent_friction", "torque_ripple"][:3], *laws]
    )
    nominal = pid.Model.nominal(robot, effects).theta
    theta = np.where(np.arange(len(nominal)) < 60, nominal, np.random.default_rng(25).uniform(0.1, 1.0, len(nominal)))
    model = pid.Model(robot, effects, theta)
    exported = mjcf_of(model)
    listed = " | ".join(exported.stated)
    for part in (
        "stribeck_friction",
        "nonlinear_viscous_friction",
        "load_dependent_friction",
        "hysteresis on joint 3",
    ):
        assert part in listed
    compiled = mujoco.MjModel.from_xml_string(exported.text)
    assert (
        compiled.joint(robot.joint_names[2]).frictionloss[0] > 0.01 * theta[-1]
    )  # the hysteresis, and of the rest a line
    source = callback_of(model, exported.held)
    assert source is not None
    space: dict = {}
    exec(source, space)
    states = random_motion(robot, seed=26, count=30)
    try:
        space["install"](compiled)
        found = inverse_dynamics(compiled, states, robot.joint_names)
    finally:
        mujoco.set_mjcb_passive(None)
    expected = without_dry(model, states)
    lines = compiled.dof_frictionloss.copy()  # of the other laws, whose rest is in the callback
    lines[2] -= 0.01 * theta[-1]
    found += lines * np.tanh(states.v / 1e-3)
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()
    assert np.abs(without_dry(pid.Model(robot, effects[:2], theta[:66]), states) - expected).max() > 0.1


def test_the_arm_holds_under_gravity(tmp_path: Path) -> None:
    """Dry friction above the gravity torque: in MuJoCo no joint moves by more than a tenth of a milliradian in five seconds."""
    robot = pid.load_robot("ur5")
    model = pid.Model.nominal(robot, ["rigid_body", "rotor_inertia", PreslidingHysteresis(None, (1e-4,))])
    theta = model.theta.copy()
    theta[-6:] = 80.0 / 1e-4
    pid.export_mjcf(replace(model, theta=theta), tmp_path / "arm.xml")
    compiled = mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml"))
    data = mujoco.MjData(compiled)
    data.qpos[:] = start = np.array([0.0, -0.6, 0.8, 0.3, 0.2, 0.0])
    for _ in range(5000):
        mujoco.mj_step(compiled, data)
    assert np.abs(data.qpos - start).max() < 1e-4
    compiled.dof_frictionloss[:] = 0.0
    mujoco.mj_resetData(compiled, data)
    data.qpos[:] = start
    for _ in range(500):
        mujoco.mj_step(compiled, data)
    assert np.abs(data.qpos - start).max() > 0.1


def test_a_link_that_cannot_be_is_refused_by_name() -> None:
    model = physical_model(lumped(), seed=7)
    theta = np.array(model.theta)
    theta[10] = -1.0
    with pytest.raises(pid.InputError, match=r"link 2 .tool, moved by elbow.: mass.*--method physical"):
        mjcf_of(replace(model, theta=theta))


def test_names_cannot_leave_their_place(tmp_path: Path) -> None:
    """A joint whose name is code: it stays a name in XML and in Python, and the exported files do nothing else."""
    robot = named_after_code()
    assert robot.joint_names[1] == NASTY
    model = physical_model(robot, seed=8)
    model = pid.Model(robot, (*model.effects, StribeckFriction((2,), (0.1,))), np.append(model.theta, 0.5))
    exported = pid.export_mjcf(model, tmp_path / "arm.xml")
    compiled = mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml"))
    assert compiled.joint(NASTY).id == 1
    source = callback_of(model, exported.held)
    assert source is not None
    (tmp_path / "callback.py").write_text(source, encoding="utf-8")
    pid.export_python(model, tmp_path / "arm.py")
    code = "import os; os.system = None; import arm, callback; print(callback.NAMES[1])"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == NASTY
    assert sorted(path.name for path in tmp_path.glob("*.*")) == ["arm.py", "arm.xml", "callback.py"]


def test_command_line(healthy_estimate: pid.Estimate, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = physical_model(pid.load_robot("ur5"), seed=9)
    replace(healthy_estimate, model=model).save(path := tmp_path / "m.json")
    xml = tmp_path / "a.xml"
    for _ in range(2):  # the second replaces what the first wrote, without --force
        assert run(["export", "--model", str(path), "--mjcf", str(xml)]) == 0
    assert "of the torque measurement, not of the arm: torque_offset" in capsys.readouterr().out
    before = xml.read_text()
    assert run(["export", "--model", str(path), "--patch", str(xml), "--mjcf", str(tmp_path / "b.xml")]) == 0
    assert xml.read_text() == before
    for options in (
        ["--callback", str(tmp_path / "c.py")],
        ["--mjcf", str(xml), "--callback", str(tmp_path / "c.py")],
        ["--mjcf", str(xml), "--patch", str(xml)],
        ["--patch", str(tmp_path / "none.xml")],
        ["--patch", str(xml), "--mjcf", str(tmp_path.parent / "out.xml")],
        ["--mjcf", str(xml), "--meshes", str(tmp_path / "none")],
        ["--mjcf", str(tmp_path / "no" / "out.xml")],
    ):
        capsys.readouterr()
        assert run(["export", "--model", str(path), *options]) == 2, options
        assert len(capsys.readouterr().err.strip().splitlines()) == 1
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.xml", "b.xml", "m.json"]
