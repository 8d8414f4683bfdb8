"""The URDF of a model gives the same torques elsewhere, and nothing else of the file is touched."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.export.urdf import urdf_of
from physident.export.urdf_edit import parse_elements
from physident.identifiability.base_parameters import random_motion
from physident.robots.inertia import link_parameters
from tests.exported_arms import LUMPED, lumped, physical_model, random_states
from tests.robots import TREE


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
    for part in ("rotor_inertia", "torque_offset", "gravity"):
        assert part in listed
    assert [
        text
        for text in exported.folded
        if "friction of joint 2 (elbow) written as the nearest damping 0 N m s/rad" in text
    ]
    assert "coulomb_friction" not in listed
    assert 'damping="0.0"' in exported.text
    assert all(text in repr(exported) for text in (*exported.inexpressible, *exported.folded))


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
