"""A model written into a user's own MJCF has its torque there, and nothing but values of the file changes."""

from __future__ import annotations

import re
from pathlib import Path

import mujoco
import numpy as np
import pytest

import physident as pid
from physident.export.mjcf.patch import patch_mjcf
from physident.export.urdf_edit import MARK
from physident.identifiability.base_parameters import random_motion
from tests.exported_arms import lumped, physical_model
from tests.mujoco_torque import inverse_dynamics, without_dry

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


def written_out(text: str) -> list[str]:
    """Words of a text outside of the values that a patch may replace."""
    text = re.sub(r'\s(damping|frictionloss|armature|sol(imp|ref)friction)=("[^"]*"|\'[^\']*\')', "", text)
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


def test_dry_friction_of_a_patched_file_is_the_models_and_not_that_of_a_soft_constraint(user: Path) -> None:
    """A joint that moves slowly is held back by all of it, unless the file states how soft that joint's friction is: these are MuJoCo's defaults."""
    model = physical_model(lumped(), seed=3)
    held = {}
    for name, own in (("stiff", ""), ("soft", " solreffriction='0.02 1' solimpfriction='0.9 0.95 0.001 0.5 2'")):
        path = user.with_name(f"{name}.xml")
        path.write_text(USER.replace("frictionloss='7'", f"frictionloss='7'{own}"), encoding="utf-8")
        patch_mjcf(model, path)
        compiled = mujoco.MjModel.from_xml_path(str(path))
        data = mujoco.MjData(compiled)
        data.qvel[:] = 0.001
        mujoco.mj_inverse(compiled, data)
        held[name] = -data.qfrc_constraint / compiled.dof_frictionloss
    np.testing.assert_allclose(held["stiff"], 1.0, rtol=1e-3)
    assert held["soft"][1] < 0.9


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
    text = USER.replace(old, new, 1)
    user.write_text(text, encoding="utf-8")
    pattern = message if "|" in message else re.escape(message)
    with pytest.raises(pid.InputError, match=pattern) as error:
        patch_mjcf(physical_model(lumped(), seed=7), user)
    assert "\n" not in str(error.value)
    assert user.read_text(encoding="utf-8") == text
    assert [path.name for path in user.parent.iterdir()] == ["user.xml"]
