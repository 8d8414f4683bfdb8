"""A model in MuJoCo has the torque that it has here, in a new file and in a user's own, of which nothing else changes."""

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
from physident.export.mjcf.patch import patch_mjcf
from physident.export.urdf_edit import MARK
from physident.identifiability.base_parameters import random_motion
from physident.robots.inertia import link_parameters
from tests.conftest import UR10E_COLUMNS, UR10E_GAINS
from tests.robots import TREE
from tests.test_export import LUMPED, lumped, physical_model

Array = np.ndarray
OFF = mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS | mujoco.mjtDisableBit.mjDSBL_LIMIT | mujoco.mjtDisableBit.mjDSBL_CONTACT
DRY = ("coulomb_friction", "presliding_hysteresis")
NASTY = 'a"); import os; os.system("x"); (" */ <b> &amp; \' ${x} `y`'
USER = """<!-- my arm: größer -->
<mujoco model="mine">
  <compiler angle="degree"/>
  <option timestep="0.002" gravity="0 0 -9.81"/>  <!-- keep -->
  <default><joint damping="1" armature='0.1'/><default class="big"><joint damping="3"/></default></default>
  <worldbody>
    <light pos="0 0 3"/>
    <body name="pedestal" pos="1 2 0.5" euler="0 0 30">
      <geom type="box" size=".1 .1 .1"/>
      <frame euler="0 0 10"><!-- frame -->
      <body name="upper" pos="0 0 0.4" euler="5.729577951308232 0 0">
        <joint  name="shoulder"   class="big"
                axis="0 1 0" range="-170 170"/>   <!-- turns > -->
        <geom type="capsule" fromto="0 0 0 0 0 .3" size=".04" density="700"/>
        <body name="cover" pos="0 0.1 0" euler="0 0 28.64788975654116">
          <geom type="box" size=".1 .1 .1" mass="2"/>
          <body name="forearm" pos="0 0 0.3" euler="0 90 0">
            <inertial pos="0 0 .1" mass="1" diaginertia="1 1 1"/>
            <joint name='elbow' axis='0 0 1' frictionloss='7' damping="2"/>
            <geom type="sphere" size=".05"/><site name="tip" pos="0.3 0 0"/>
          </body>
        </body>
      </body>
      </frame>
    </body>
  </worldbody>
  <actuator><position joint="elbow" kp="100" kv="2"/></actuator>
  <sensor><jointpos joint="elbow"/></sensor>
</mujoco>
"""


def inverse_dynamics(compiled: Any, states: pid.Signals, names: tuple[str, ...]) -> Array:
    """MuJoCo's inverse dynamics (N, n) without friction loss, limits and contacts."""
    compiled.opt.disableflags |= OFF
    data = mujoco.MjData(compiled)
    q, v = (np.array([getattr(compiled.joint(name), a)[0] for name in names]) for a in ("qposadr", "dofadr"))
    torque = np.zeros(states.q.shape)
    for k in range(len(torque)):
        data.qpos[q], data.qvel[v], data.qacc[v] = states.q[k], states.v[k], states.a[k]
        mujoco.mj_inverse(compiled, data)
        torque[k] = data.qfrc_inverse[v]
    return torque


def without_dry(model: pid.Model, states: pid.Signals) -> Array:
    """The model's torque without dry friction and without effects of the torque measurement."""
    kept = [(e, t) for e, t in model.effect_parameters() if e.name not in DRY and e.acts_on == "plant"]
    return pid.Model(model.robot, tuple(e for e, _ in kept), np.concatenate([t for _, t in kept])).torque(states)


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
        "hysteresis on joints 3",
    ):
        assert part in listed
    compiled = mujoco.MjModel.from_xml_string(exported.text)
    assert compiled.joint(robot.joint_names[2]).frictionloss[0] == pytest.approx(0.01 * theta[-1], rel=1e-12)
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


def written_out(text: str) -> list[str]:
    """Words of a text outside of the values that a patch may replace."""
    import re

    text = re.sub(r'\s(damping|frictionloss|armature)=("[^"]*"|\'[^\']*\')', "", text)
    return [line for line in re.sub(r"<inertial[^>]*/>", "", text).splitlines() if line.strip()]


@pytest.fixture
def user(tmp_path: Path) -> Path:
    path = tmp_path / "user.xml"
    path.write_text(USER, encoding="utf-8")
    return path


def test_a_patch_changes_values_only_and_fits_any_frames(user: Path) -> None:
    model = physical_model(lumped(), seed=3)
    result = patch_mjcf(model, user, user.with_name("patched.xml"))
    assert user.read_text(encoding="utf-8") == USER
    text = user.with_name("patched.xml").read_text(encoding="utf-8").replace(f"\n{MARK}", "")
    assert MARK in user.with_name("patched.xml").read_text(encoding="utf-8")
    assert written_out(text) == written_out(USER)
    assert "now without mass: cover" in repr(result)
    states = random_motion(model.robot, seed=4, count=40)
    expected = without_dry(model, states)
    found = inverse_dynamics(mujoco.MjModel.from_xml_string(text), states, model.robot.joint_names)
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()
    patch_mjcf(model, user)
    assert user.read_text(encoding="utf-8") == text
    patch_mjcf(model, user)
    again = inverse_dynamics(mujoco.MjModel.from_xml_path(str(user)), states, model.robot.joint_names)
    np.testing.assert_allclose(again, found, atol=1e-9 * np.abs(found).max())


def test_a_patch_writes_gravity_and_shared_motors(user: Path) -> None:
    robot = lumped()
    model = physical_model(robot, seed=5)
    effects = (*model.effects, *pid.make_effects(["gravity_tilt", "coupled_friction"]))
    model = pid.Model(robot, effects, np.concatenate([model.theta, [0.4, -0.3, 0.0, 1.7]]))
    patch_mjcf(model, user)
    states = random_motion(robot, seed=6, count=40)
    expected = without_dry(model, states)
    found = inverse_dynamics(mujoco.MjModel.from_xml_path(str(user)), states, robot.joint_names)
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()
    once = user.read_text(encoding="utf-8")
    patch_mjcf(model, user)
    assert user.read_text(encoding="utf-8").count("<fixed") == once.count("<fixed") == 1


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("name='elbow'", "name='elbow2'", "expected the model's joint names|unknown transmission target 'elbow'"),
        ("axis='0 0 1'", "axis='0 1 0'", "joint 2 (elbow) moves otherwise than in the model"),
        ('pos="0 0 0.3" euler', 'pos="0 0 0.31" euler', "joint 2 (elbow) moves otherwise than in the model, by up to"),
        ("axis='0 0 1'", "axis='0 0 1' type='slide'", "joint 2 (elbow) is not revolute"),
        ("<joint name='elbow'", "<joint axis='1 0 0'/><joint name='elbow'", "several joints"),
        ('gravity="0 0 -9.81"', 'gravity="0 9.81 0"', "expected the arm mounted as in the model's description"),
        ('angle="degree"', 'angle="degree" inertiafromgeom="true"', "would not have the model's torque"),
        ("</mujoco>", "", "not an MJCF file that MuJoCo reads"),
        ("<!-- my arm", '<!DOCTYPE a [<!ENTITY b "c">]><!-- my arm', "expected an MJCF file|declares XML entities"),
    ],
)
def test_a_file_that_does_not_fit_is_refused_and_kept(user: Path, old: str, new: str, message: str) -> None:
    import re

    text = USER.replace(old, new, 1)
    user.write_text(text, encoding="utf-8")
    pattern = message if "|" in message else re.escape(message)
    with pytest.raises(pid.InputError, match=pattern) as error:
        patch_mjcf(physical_model(lumped(), seed=7), user)
    assert "\n" not in str(error.value)
    assert user.read_text(encoding="utf-8") == text
    assert [path.name for path in user.parent.iterdir()] == ["user.xml"]


def test_a_link_that_cannot_be_is_refused_by_name() -> None:
    model = physical_model(lumped(), seed=7)
    theta = np.array(model.theta)
    theta[10] = -1.0
    with pytest.raises(pid.InputError, match=r"link 2 .tool, moved by elbow.: mass.*--method physical"):
        mjcf_of(replace(model, theta=theta))


def test_names_cannot_leave_their_place(tmp_path: Path) -> None:
    """A joint whose name is code: it stays a name in XML and in Python, and the exported files do nothing else."""
    escaped = NASTY.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    robot = pid.Robot(NASTY, LUMPED.replace('"elbow"', f'"{escaped}"').replace('name="lumped"', f'name="{escaped}"'))
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
