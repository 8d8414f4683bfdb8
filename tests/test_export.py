"""A model written for others gives the same torques there, and nothing else of the file is touched."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.cli import run
from physident.effects.friction import NonlinearViscousFriction, StribeckFriction
from physident.effects.hysteresis import PreslidingHysteresis
from physident.effects.thermal import WarmUp
from physident.effects.transmission import CoupledFriction, TorqueRipple
from physident.estimation.uncertainty import t_quantile
from physident.export.parameters import parameters_of
from physident.export.python import python_of
from physident.export.urdf import urdf_of
from physident.export.urdf_edit import parse_elements
from physident.identifiability.base_parameters import random_motion
from physident.robots import urdf as reader
from physident.robots.inertia import link_parameters
from tests.robots import TREE

LUMPED = """<?xml version="1.0" encoding="utf-8"?>
<!-- before the root: größer -->
<robot name="lumped" xmlns:xacro="http://ros.org/wiki/xacro">
  <material name="grey"><color rgba="0.7 0.7 0.7 1.0"/></material>
  <link name="world"/>
  <link name="base"><inertial><mass value="4.0"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <joint name="mount" type="fixed"><parent link="world"/><child link="base"/></joint>
  <link name="arm"/>
  <joint name="shoulder" type="revolute"> <!-- turns -->
    <parent link="base"/><child link="arm"/><origin xyz="0 0 0.4" rpy="0.1 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" velocity="3" effort="100"/>
  </joint>
  <link name="cover"><!-- bolted on -->
    <inertial>
      <origin xyz="0.1 0 0.2" rpy="0.4 -0.3 0.2"/>
      <mass value="2.0"/>
      <inertia ixx="0.02" ixy="0.001" ixz="0" iyy="0.03" iyz="0.002" izz="0.025"/>
    </inertial>
    <visual><geometry><mesh filename="package://x/&lt;cover&gt;.dae"/></geometry></visual>
  </link>
  <joint name="bolts" type="fixed"><parent link="arm"/><child link="cover"/><origin xyz="0 0.1 0" rpy="0 0 0.5"/></joint>
  <link name="tool"><inertial><origin xyz="0 0 0.1"/><mass value="1.0"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.005"/></inertial></link>
  <joint name="elbow" type="revolute"><parent link="cover"/><child link="tool"/><origin xyz="0 0 0.3"/><axis xyz="1 0 0"/>
    <limit lower="-3" upper="3" velocity="3" effort="50"/><dynamics friction="7" damping="3" springref="1"/></joint>
  <link name="flange"/>
  <joint name="screw" type="fixed"><parent link="tool"/><child link="flange"/></joint>
  <transmission name="t"><joint name="elbow"><hardwareInterface>E</hardwareInterface></joint></transmission>
  <gazebo reference="arm"><selfCollide>true</selfCollide></gazebo>
</robot>
<!-- after the root -->
"""


def lumped() -> pid.Robot:
    return pid.Robot("lumped", LUMPED)


def physical_model(robot: pid.Robot, seed: int) -> pid.Model:
    """A model with random solid links and random friction, so that no nominal value can pass for an identified one."""
    rng = np.random.default_rng(seed)
    model = pid.Model.nominal(robot)
    links = []
    for _ in range(robot.n):
        root = rng.normal(size=(4, 4)) * np.array([0.2, 0.2, 0.2, 1.0])[:, None]
        links.append(link_parameters(root @ root.T + 1e-3 * np.eye(4)))
    rest = rng.uniform(0.1, 2.0, size=len(model.theta) - 10 * robot.n)
    return replace(model, theta=np.concatenate([*links, rest]))


def random_states(robot: pid.Robot, seed: int, count: int) -> pid.Signals:
    return pid.Signals.of_states(*np.random.default_rng(seed).uniform(-2, 2, size=(3, count, robot.n)))


def pinocchio_torque(text: str, states: pid.Signals) -> np.ndarray:
    model = pin.buildModelFromXML(text)
    data = model.createData()
    return np.array([pin.rnea(model, data, *s).copy() for s in zip(states.q, states.v, states.a, strict=True)])


@pytest.fixture(params=["ur5", "lumped", "tree"])
def robot(request: pytest.FixtureRequest) -> pid.Robot:
    makers = {"ur5": lambda: pid.load_robot("ur5"), "lumped": lumped, "tree": lambda: pid.Robot("tree", TREE)}
    return makers[request.param]()


def test_urdf_gives_the_same_rigid_body_torque(robot: pid.Robot) -> None:
    model = physical_model(robot, seed=1)
    states = random_motion(robot, seed=2, count=50)
    rigid = pid.Model(robot, pid.make_effects(["rigid_body"]), model.parameters("rigid_body"))
    text = urdf_of(model).text
    again = pid.Robot("again", text)
    order = [again.joint_names.index(name) for name in robot.joint_names]
    assert order == list(range(robot.n))
    back = pid.Model.nominal(again, ["rigid_body"]).torque(states)
    np.testing.assert_allclose(back, rigid.torque(states), rtol=1e-9, atol=1e-9)
    if all('type="continuous"' not in line for line in text.splitlines()):  # which pinocchio gives two coordinates
        np.testing.assert_allclose(pinocchio_torque(text, states), rigid.torque(states), rtol=1e-9, atol=1e-9)


def test_urdf_keeps_every_other_byte() -> None:
    exported = urdf_of(physical_model(lumped(), seed=3))
    before, after = parse_elements(LUMPED), parse_elements(exported.text)

    def rest(root: object, text: str) -> list[str]:
        data, spans = text.encode(), []
        for kind, tag in (("link", "inertial"), ("joint", "dynamics")):
            for parent in root.find_all(kind):  # pyright: ignore[reportAttributeAccessIssue]
                spans += [(child.start, child.stop) for child in parent.find_all(tag)]
        for start, stop in sorted(spans, reverse=True):
            data = data[:start] + data[stop:]
        lines = (
            data.decode().replace('<link name="arm">', '<link name="arm"/>').replace("  </link>\n  <joint", "  <joint")
        )
        return [line for line in lines.splitlines() if line.strip()]

    old, new = rest(before, LUMPED), rest(after, exported.text)
    assert [line for line in old if line not in new] == []
    assert "<!-- before the root: größer -->" in new
    assert "<!-- after the root -->" in new
    assert '<gazebo reference="arm">' in exported.text


def test_bodies_of_one_joint_become_one_and_the_base_keeps_its_own() -> None:
    exported = urdf_of(physical_model(lumped(), seed=4))
    root = parse_elements(exported.text)
    inertials = {link.attributes["name"]: len(link.find_all("inertial")) for link in root.find_all("link")}
    assert inertials == {"world": 0, "base": 1, "arm": 1, "cover": 0, "tool": 1, "flange": 0}
    assert exported.links == ("arm", "tool")
    assert exported.merged == (("cover",), ())


def test_damping_and_friction_are_written_and_other_attributes_kept() -> None:
    model = physical_model(lumped(), seed=5)
    elbow = parse_elements(urdf_of(model).text).find_all("joint")[3].find_all("dynamics")
    assert len(elbow) == 1
    assert float(elbow[0].attributes["damping"]) == model.parameters("viscous_friction")[1]
    assert float(elbow[0].attributes["friction"]) == model.parameters("coulomb_friction")[1]
    assert elbow[0].attributes["springref"] == "1"


def test_a_model_without_friction_keeps_what_the_file_says_of_it() -> None:
    robot = lumped()
    text = urdf_of(pid.Model.nominal(robot, ["rigid_body"])).text
    assert 'friction="7" damping="3" springref="1"' in text


def test_a_model_without_bodies_is_refused() -> None:
    with pytest.raises(pid.InputError, match="no rigid_body"):
        urdf_of(pid.Model.nominal(lumped(), ["viscous_friction"]))


def test_a_real_file_keeps_all_but_inertia_and_dynamics(data: Path) -> None:
    """A file with plugins, transmissions and comments: only lines of inertia and dynamics differ, torque does not."""
    robot = pid.load_robot(data / "ur10e" / "ur10e.urdf")
    exported = urdf_of(pid.Model.nominal(robot)).text
    gone = set(robot.urdf.splitlines()) - set(exported.splitlines())
    assert all(any(word in line for word in ("<mass", "<inertia", "<origin", "<dynamics")) for line in gone)
    assert robot.urdf.count("<!--") + 1 == exported.count("<!--")  # and the one that says what wrote it
    states = random_states(robot, seed=17, count=20)
    before, after = (pinocchio_torque(text, states) for text in (robot.urdf, exported))
    np.testing.assert_allclose(after, before, rtol=1e-9, atol=1e-9)


def test_what_urdf_cannot_hold_is_listed() -> None:
    robot = replace(lumped(), gravity=(0.0, 9.81, 0.0))
    model = physical_model(robot, seed=6)
    theta = np.array(model.theta)
    theta[[c.name == "viscous_friction_2" for c in model.columns].index(True)] = -0.3
    exported = urdf_of(replace(model, theta=theta))
    listed = " | ".join(exported.inexpressible)
    for part in ("rotor_inertia", "torque_offset", "gravity", "damping -0.3 of joint 2 (elbow)"):
        assert part in listed
    assert "coulomb_friction" not in listed
    assert 'damping="0.0"' in exported.text
    assert all(text in repr(exported) for text in exported.inexpressible)


@pytest.mark.parametrize(
    ("change", "condition"),
    [((0, -1.0), "mass"), ((6, 50.0), "triangle"), ((4, -9.0), "is negative"), ((0, 0.0), "mass")],
)
def test_a_link_that_cannot_be_is_refused_by_name(change: tuple[int, float], condition: str, tmp_path: Path) -> None:
    model = physical_model(lumped(), seed=7)
    theta = np.array(model.theta)
    theta[10 + change[0]] = change[1]
    with pytest.raises(
        pid.InputError, match=f"link 2 .tool, moved by elbow.: .*{condition}.*--method physical"
    ) as error:
        pid.export_urdf(replace(model, theta=theta), tmp_path / "out.urdf")
    assert "link 1" not in str(error.value)
    assert not list(tmp_path.iterdir())


def test_a_link_without_any_mass_loses_its_inertial() -> None:
    model = physical_model(lumped(), seed=8)
    theta = np.array(model.theta)
    theta[10:20] = 0.0
    text = urdf_of(replace(model, theta=theta)).text
    assert parse_elements(text).find_all("link")[4].find_all("inertial") == []


def test_python_function_equals_the_model(robot: pid.Robot, tmp_path: Path) -> None:
    model = physical_model(replace(robot, gravity=(1.0, -3.0, 8.0)), seed=9)
    effects = (pid.make_effects(["rigid_body"])[0], pid.CATALOGUE["coulomb_friction"]((2,)), *model.effects[1:3])
    theta = np.concatenate([model.theta[: 10 * robot.n + 1], model.theta[10 * robot.n : 12 * robot.n]])
    for one in (model, pid.Model(model.robot, effects, theta)):
        space: dict = {}
        exec(python_of(one), space)
        states = random_motion(robot, seed=10, count=30)
        expected = one.torque(states)
        np.testing.assert_allclose(space["torque"](states.q, states.v, states.a), expected, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(
            space["torque"](states.q[3], states.v[3], states.a[3]), expected[3], rtol=1e-9, atol=1e-9
        )
        with pytest.raises(ValueError, match="shapes"):
            space["torque"](states.q[:, :1], states.v, states.a)


def test_python_function_holds_every_effect_it_can(tmp_path: Path) -> None:
    robot = lumped()
    named = "rigid_body rotor_inertia payload gravity_tilt gravity_magnitude viscous_friction coulomb_friction friction_asymmetry"
    more = "load_dependent_friction joint_spring torque_constant torque_offset"
    shaped = StribeckFriction((2,), (0.1,)), NonlinearViscousFriction(None, (0.5, 2.0)), TorqueRipple((2,), (3.0,))
    effects = pid.make_effects([*named.split(), *more.split(), *shaped, CoupledFriction((2, 1))])
    count = len(pid.Model.nominal(robot, effects).theta)
    model = pid.Model(robot, effects, np.random.default_rng(14).uniform(0.1, 1.0, size=count))
    space: dict = {}
    exec(python_of(model), space)
    s = random_states(robot, seed=15, count=40)
    np.testing.assert_allclose(space["torque"](s.q, s.v, s.a), model.torque(s), rtol=1e-9, atol=1e-9)


def test_a_payload_effect_is_part_of_the_last_link() -> None:
    robot = lumped()
    model = physical_model(robot, seed=16)
    load = link_parameters(np.diag([0.1, 0.2, 0.3, 2.0]))
    both = pid.Model(robot, (*model.effects, pid.CATALOGUE["payload"]()), np.concatenate([model.theta, load]))
    theta = np.array(model.theta)
    theta[10:20] += load
    exported = urdf_of(both)
    assert exported.text == urdf_of(replace(model, theta=theta)).text
    assert not [text for text in exported.inexpressible if "payload" in text]


def test_python_refuses_what_needs_other_instants() -> None:
    model = pid.Model.nominal(lumped(), ["rigid_body", "joint_elasticity", "time_delay"])
    with pytest.raises(pid.InputError, match=r"cannot express joint_elasticity, time_delay; expected .*hysteresis"):
        python_of(model)


def test_python_function_remembers_and_ages_as_the_model_does() -> None:
    robot = lumped()
    more = PreslidingHysteresis((2,), (0.02,)), PreslidingHysteresis((1,), (0.1,)), WarmUp((1,), (4.0,))
    effects = pid.make_effects(["rigid_body", "coulomb_friction", *more, "torque_constant"])
    count = len(pid.Model.nominal(robot, effects).theta)
    model = pid.Model(robot, effects, np.random.default_rng(19).uniform(0.1, 1.0, size=count))
    space: dict = {}
    exec(python_of(model), space)
    time, q, v, a = pid.random_trajectory(robot, seed=20, duration=10.0).sample(100.0)
    expected = model.torque(pid.Signals(time, q, v, a, rate=100.0))
    without = pid.Model(robot, effects[:2], model.theta[:22]).torque(pid.Signals(time, q, v, a, rate=100.0))
    assert (np.abs(expected - without).max(axis=0) > 0.1).all()
    np.testing.assert_allclose(space["torque_along"](time + 7.0, q, v, a), expected, rtol=1e-9, atol=1e-9)
    state = np.zeros((2, 2))
    for k in range(1, 300):
        state = space["advanced"](state, 0.5 * (v[k - 1] + v[k]), 0.01)
    once = space["torque"](q[299], v[299], a[299], state, t=time[299])
    np.testing.assert_allclose(once, expected[299], rtol=1e-9, atol=1e-9)


def test_python_file_needs_numpy_only(tmp_path: Path) -> None:
    pid.export_python(physical_model(lumped(), seed=11), tmp_path / "arm.py")
    code = "import sys, arm; arm.torque([1, 2], [0, 0], [0, 0]); print([m for m in sys.modules if m.split('.')[0] in ('physident', 'casadi', 'pinocchio')])"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.fixture(scope="module")
def estimate(tmp_path_factory: pytest.TempPathFactory) -> pid.Estimate:
    """A two-joint arm identified from a noisy motion."""
    robot = lumped()
    time, q, v, a = pid.random_trajectory(robot, seed=1, duration=20.0).sample(100.0)
    torque = physical_model(robot, seed=12).torque(pid.Signals.of_states(q, v, a))
    torque = torque + 0.05 * np.random.default_rng(0).normal(size=torque.shape)
    return pid.identify(robot, [pid.Recording(time, q, torque, "torque", dq=v)])


def test_json_has_units_and_intervals_that_agree_with_the_estimate(estimate: pid.Estimate, tmp_path: Path) -> None:
    pid.export_parameters(estimate, tmp_path / "p.json")
    data = json.loads((tmp_path / "p.json").read_text())
    assert data == json.loads(json.dumps(parameters_of(estimate)))
    assert [p["value"] for p in data["parameters"]] == list(estimate.theta)
    for parameter, std in zip(data["parameters"], estimate.standard_errors, strict=True):
        assert (parameter["interval"] is None) == bool(np.isnan(std))
        if parameter["interval"]:
            low, high = parameter["interval"]
            assert low < parameter["value"] < high
            assert high - low == pytest.approx(2 * t_quantile(estimate.blocks) * std, rel=1e-9)
    assert {p["unit"] for p in data["parameters"]} == {"kg", "kg m", "kg m^2", "N m", "N m s/rad"}
    assert [p["interval"] for p in data["base_parameters"]] == estimate.intervals().tolist()
    truth = physical_model(lumped(), seed=12)
    friction = [p for p in data["parameters"] if p["effect"] == "viscous_friction"]
    for parameter, value in zip(friction, truth.parameters("viscous_friction"), strict=True):
        assert abs(parameter["value"] - value) < 5 * parameter["std"]


def test_command_line_writes_all_or_nothing(
    estimate: pid.Estimate, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    model = physical_model(lumped(), seed=13)
    good, bad = tmp_path / "good.json", tmp_path / "bad.json"
    replace(estimate, model=model).save(good)
    theta = np.array(model.theta)
    theta[0] = -1.0
    replace(estimate, model=replace(model, theta=theta)).save(bad)
    out = [tmp_path / name for name in ("a.urdf", "a.json", "a.py")]
    options = ["--urdf", str(out[0]), "--json", str(out[1]), "--python", str(out[2])]
    assert run(["export", "--model", str(bad), *options]) == 2
    assert "link 1 (arm, moved by shoulder)" in capsys.readouterr().err
    assert not any(path.exists() for path in out)
    assert run(["export", "--model", str(good)]) == 2
    assert run(["export", "--model", str(good), "--urdf", str(out[0]), "--json", str(out[0])]) == 2
    assert not any(path.exists() for path in out)
    assert run(["export", "--model", str(good), *options]) == 0
    assert run(["export", "--model", str(good), *options]) == 0  # replaces what it wrote, without --force
    assert "not expressible in URDF: rotor_inertia" in capsys.readouterr().out
    assert all(path.exists() for path in out)
    assert reader.parse_urdf(out[0].read_text(), "a.urdf").get("name") == "lumped"
