"""A robot is what its description says: DH tables, URDF, limits, drives, and links that no body can have."""

from __future__ import annotations

import json
import math
import re
import warnings
from importlib import resources
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.robots.dh import urdf_from_table
from physident.robots.dh_table import parse_table
from tests.robots import TREE

# thesis Tables 2.2-2.6, typed from the print; inertias as diagonals and (1, 3) entries
D = (0.089159, 0, 0, 0.10915, 0.09465, 0.0823)
A = (0, -0.425, -0.39225, 0, 0, 0)
ALPHA = (90, 0, 0, 90, -90, 0)
MASS = (3.7, 8.393, 2.33, 1.219, 1.219, 0.1879)
CENTRE = ((0, -0.02561, 0.00193), (0.2125, 0, 0.11336), (0.15, 0, 0.0265), (0, -0.0018, 0.01634), (0, 0.0018, 0.01634), (0, 0, 0.001159))  # fmt: skip
INERTIA = (
    (0.0067, 0.0064, 0.0067), (0.0149, 0.3564, 0.3553), (0.0025, 0.0551, 0.0546),
    (0.0012, 0.0012, 0.0009), (0.0012, 0.0012, 0.009), (0.0001, 0.0001, 0.0001),
)  # fmt: skip
IXZ = (0, 0, 0.0034, 0, 0, 0)
MOTOR_INERTIA = (1.87e-8, 1.87e-8, 1.87e-8, 2.07e-5, 2.07e-5, 2.07e-5)
MOTOR_FRICTION = ((0.076, -0.076), (0.083, -0.082), (0.078, -0.077), (0.014, -0.014), (0.020, -0.019), (0.020, -0.021))
TORQUE_LIMIT = (150, 150, 150, 28, 28, 28)
TORQUE_CONSTANT = (0.125, 0.125, 0.125, 0.0922, 0.0922, 0.0922)


def printed(inertia: tuple = INERTIA) -> dict[str, Any]:
    """The thesis' tables as a DH table, its inertias about the centre of mass."""
    joints = [
        {"d": D[i], "a": A[i], "alpha_deg": ALPHA[i], "mass": MASS[i], "com": list(CENTRE[i])}
        | {"inertia": [inertia[i][0], 0, inertia[i][1], IXZ[i], 0, inertia[i][2]]}
        for i in range(6)
    ]
    return {"schema": "physident.dh/1", "name": "printed", "joints": joints}


def thesis_step(theta: float, d: float, a: float, alpha: float) -> np.ndarray:
    """Roto-translation (4, 4) of one row of a DH table: eq. 2.3, whose matrix 2.2 has its two sines' signs misprinted."""
    ct, st, ca, sa = math.cos(theta), math.sin(theta), math.cos(alpha), math.sin(alpha)
    return np.array([[ct, -st * ca, st * sa, a * ct], [st, ct * ca, -ct * sa, a * st], [0, sa, ca, d], [0, 0, 0, 1]])


def tool_placement(robot: pid.Robot, q: np.ndarray) -> np.ndarray:
    model = robot.pinocchio
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    return data.oMf[model.getFrameId("tool0")].homogeneous


def test_forward_kinematics_is_the_product_of_the_table_s_rows() -> None:
    rng = np.random.default_rng(0)
    table = printed()
    offsets = np.zeros((6, 4))
    for i, joint in enumerate(table["joints"]):
        offsets[i] = rng.normal(scale=(0.01, 0.01, 2.0, 2.0))
        joint["calibration"] = dict(zip(("d", "a", "alpha_deg", "offset_deg"), offsets[i].tolist(), strict=True))
        joint["offset_deg"] = float(rng.uniform(-90, 90))
    robot = pid.Robot("calibrated", urdf_from_table(table))
    for q in rng.uniform(-3, 3, (5, 6)):
        T = np.eye(4)
        for i, joint in enumerate(table["joints"]):
            dd, da, dalpha, dtheta = offsets[i]
            theta = q[i] + math.radians(joint["offset_deg"] + dtheta)
            T = T @ thesis_step(theta, D[i] + dd, A[i] + da, math.radians(ALPHA[i] + dalpha))
        np.testing.assert_allclose(tool_placement(robot, q), T, atol=1e-12)


def test_links_of_a_table_weigh_as_newton_says() -> None:
    """Gravity torque and kinetic energy from the thesis' rows alone: potential energy's slope, moving masses."""
    robot = pid.Robot("printed", urdf_from_table(printed()))
    rng = np.random.default_rng(1)

    def frames(q: np.ndarray) -> list[np.ndarray]:
        result, T = [], np.eye(4)
        for i in range(6):
            T = T @ thesis_step(q[i], D[i], A[i], math.radians(ALPHA[i]))
            result.append(T)
        return result

    def slope(value: Any, q: np.ndarray, direction: np.ndarray, h: float = 1e-5) -> Any:
        return (value(q + h * direction) - value(q - h * direction)) / (2 * h)

    def centres(q: np.ndarray) -> np.ndarray:
        return np.array([(T @ [*c, 1])[:3] for T, c in zip(frames(q), CENTRE, strict=True)])

    def rotations(q: np.ndarray) -> np.ndarray:
        return np.array([T[:3, :3] for T in frames(q)])

    model = robot.pinocchio
    data = model.createData()
    for q, v in rng.uniform(-2, 2, (4, 2, 6)):
        gravity = [9.81 * np.array(MASS) @ slope(centres, q, e)[:, 2] for e in np.eye(6)]
        np.testing.assert_allclose(pin.computeGeneralizedGravity(model, data, q), gravity, atol=1e-7)
        moving, turning = slope(centres, q, v), slope(rotations, q, v)
        energy = 0.5 * np.array(MASS) @ (moving**2).sum(axis=1)
        for i, (R, dR) in enumerate(zip(rotations(q), turning, strict=True)):
            S = R.T @ dR
            w = np.array([S[2, 1], S[0, 2], S[1, 0]])
            tensor = np.diag(INERTIA[i])
            tensor[0, 2] = tensor[2, 0] = IXZ[i]
            energy += 0.5 * w @ tensor @ w
        assert pin.computeKineticEnergy(model, data, q, v) == pytest.approx(energy, rel=1e-7)


def test_the_built_in_ur5_is_the_thesis_robot(ur5: pid.Robot) -> None:
    mended = (*INERTIA[:4], (0.0012, 0.0012, 0.0009), INERTIA[5])
    same = pid.Robot("printed", urdf_from_table(printed(mended)))
    np.testing.assert_allclose(ur5.nominal, same.nominal, atol=1e-12)
    for q in np.random.default_rng(2).uniform(-3, 3, (5, 6)):
        np.testing.assert_allclose(tool_placement(ur5, q), tool_placement(same, q), atol=1e-12)
    assert ur5.drives is not None
    assert tuple(d.motor_inertia for d in ur5.drives) == MOTOR_INERTIA
    assert tuple(d.motor_friction for d in ur5.drives) == MOTOR_FRICTION
    assert tuple(d.torque_constant for d in ur5.drives) == TORQUE_CONSTANT
    assert {d.gear_ratio for d in ur5.drives} == {101.0}
    np.testing.assert_array_equal(ur5.torque_limit, TORQUE_LIMIT)
    np.testing.assert_allclose(ur5.upper, 2 * np.pi)
    np.testing.assert_allclose(ur5.lower, -2 * np.pi)
    np.testing.assert_allclose(ur5.velocity_limit, np.pi)
    np.testing.assert_allclose(ur5.acceleration_limit or (), np.pi)
    assert ur5.tool_speed_limit == 1.0


def test_the_light_urdf_is_the_built_in_robot(ur5: pid.Robot) -> None:
    folder = resources.files("physident") / "robots"
    text = (folder / "ur5.urdf").read_text(encoding="utf-8")
    assert text == urdf_from_table(parse_table((folder / "ur5.toml").read_text(encoding="utf-8"), "ur5.toml"))
    assert "<mesh" not in text
    assert text.count("<collision>") == text.count("<visual>") >= 6 * 3  # a capsule is a cylinder and two spheres
    light = pid.load_robot(str(folder / "ur5.urdf"))
    a, b = light.pinocchio, ur5.pinocchio
    for q in np.random.default_rng(3).uniform(-3, 3, (3, 6)):
        np.testing.assert_allclose(pin.crba(a, a.createData(), q), pin.crba(b, b.createData(), q), atol=1e-12)
        gravities = [pin.computeGeneralizedGravity(m, m.createData(), q) for m in (a, b)]
        np.testing.assert_allclose(gravities[0], gravities[1], atol=1e-12)


# ------------------------------------------------------------------------------------- the thesis' tables as printed
def toml(table: dict[str, Any]) -> str:
    lines = [f"{key} = {value!r}".replace("'", '"') for key, value in table.items() if key != "joints"]
    for joint in table["joints"]:
        lines += ["[[joints]]", *(f"{key} = {json.dumps(value)}" for key, value in joint.items())]
    return "\n".join(lines) + "\n"


def test_a_number_with_two_points_cannot_be_read(tmp_path) -> None:
    path = tmp_path / "thesis.toml"
    path.write_text(re.sub(r"0\.0009\b", "0.0.0009", toml(printed()), count=1))
    with pytest.raises(pid.InputError, match=r"thesis.toml: not valid TOML .*line \d+"):
        pid.load_robot(path)


def test_the_slipped_decimal_of_link_5_is_named(tmp_path) -> None:
    path = tmp_path / "thesis.toml"
    path.write_text(toml(printed()))
    with pytest.warns(pid.PhysidentWarning) as said:
        pid.load_robot(path)
    assert len(said) == 1
    text = str(said[0].message)
    assert "thesis.toml: link 5 (joint_5): triangle inequality" in text
    assert "one principal inertia is about ten times the others: a slipped decimal?" in text


def test_inertia_about_the_wrong_point_is_named(tmp_path) -> None:
    """As the caption of Table 2.4 has it: about the link frame's origin, moved to the centre of mass (Steiner)."""
    table = printed((*INERTIA[:4], (0.0012, 0.0012, 0.0009), INERTIA[5]))
    for joint in table["joints"]:
        ixx, ixy, iyy, ixz, iyz, izz = joint["inertia"]
        m, (x, y, z) = joint["mass"], joint["com"]
        moved = [ixx - m * (y * y + z * z), ixy + m * x * y, iyy - m * (x * x + z * z)]
        joint["inertia"] = [*moved, ixz + m * x * z, iyz + m * y * z, izz - m * (x * x + y * y)]
    assert table["joints"][1]["inertia"][0] < -0.09
    path = tmp_path / "thesis.toml"
    path.write_text(toml(table))
    with pytest.warns(pid.PhysidentWarning) as said:
        pid.load_robot(path)
    texts = [str(one.message) for one in said]
    link_2 = next(text for text in texts if "link 2 (joint_2)" in text)
    assert "inertia about its centre of mass is negative" in link_2
    assert "given about the wrong point" in link_2


def test_the_built_in_robot_warns_of_nothing() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pid.load_robot("ur5")


# ---------------------------------------------------------------------------------------------------- URDF
def test_a_fixed_tool_is_lumped_into_its_link(tmp_path) -> None:
    """Energies of arm with tool: arm without, plus a body that is carried along."""
    tool = """<link name="tool"><inertial><origin xyz="0.05 0 0.1" rpy="0.2 0 0"/><mass value="1.5"/>
      <inertia ixx="0.01" ixy="0" ixz="0.002" iyy="0.008" iyz="0" izz="0.006"/></inertial></link>
     <joint name="mount" type="fixed"><parent link="tip"/><child link="tool"/>
      <origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/></joint></robot>"""
    bare = pid.Robot("bare", TREE)
    robot = pid.Robot("tooled", TREE.replace("</robot>", tool))
    assert robot.n == bare.n
    difference = robot.nominal - bare.nominal
    changed = {i // 10 for i in np.flatnonzero(np.abs(difference) > 1e-12)}
    names = list(robot.joint_names)
    assert changed == {names.index("tip_turn")}
    extra = difference.reshape(-1, 10)[names.index("tip_turn")]
    R = pin.rpy.rpyToMatrix(0.4, 0.5, 0.6)
    turned = R @ pin.rpy.rpyToMatrix(0.2, 0, 0)
    centre = np.array([0.1, 0.2, 0.3]) + R @ [0.05, 0, 0.1]
    own = turned @ np.array([[0.01, 0, 0.002], [0, 0.008, 0], [0.002, 0, 0.006]]) @ turned.T
    about_origin = own + 1.5 * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    np.testing.assert_allclose(extra, [1.5, *(1.5 * centre), *about_origin[np.tril_indices(3)]], atol=1e-12)


def test_a_tree_of_every_kind_of_joint() -> None:
    robot = pid.Robot("tree", TREE)
    by_name = {joint.name: joint for joint in robot.joints}
    assert {name: joint.kind for name, joint in by_name.items()} == {
        "slide": "prismatic", "left_turn": "revolute", "right_turn": "revolute", "tip_turn": "revolute",
    }  # fmt: skip
    names = robot.joint_names
    assert by_name["slide"].parent == -1
    assert names[by_name["left_turn"].parent] == names[by_name["right_turn"].parent] == "slide"
    assert names[by_name["tip_turn"].parent] == "right_turn"
    for joint in robot.joints:
        assert np.linalg.norm(joint.axis) == pytest.approx(1)
    turn = names.index("left_turn")
    assert robot.upper[turn] == math.inf == -robot.lower[turn] == robot.torque_limit[turn]
    # every whole turn of a continuous joint is the same pose, one angle for it
    q = np.zeros(4)
    model = robot.pinocchio
    turned = q + 2 * np.pi * (np.arange(4) == turn)
    masses = [pin.crba(model, model.createData(), x) for x in (q, turned)]
    np.testing.assert_allclose(masses[0], masses[1], atol=1e-12)


def test_a_prismatic_axis_carries_all_that_hangs_on_it() -> None:
    """Along its unit axis: the sum of masses, and their weight along it."""
    robot = pid.Robot("tree", TREE)
    slide = robot.joint_names.index("slide")
    model = robot.pinocchio
    q = np.random.default_rng(4).uniform(-1, 1, 4)
    total = robot.nominal[::10].sum()
    assert pin.crba(model, model.createData(), q)[slide, slide] == pytest.approx(total)
    joint = robot.joints[slide]
    upward = (joint.rotation @ joint.axis)[2]
    weight = pin.computeGeneralizedGravity(model, model.createData(), q)[slide]
    assert weight == pytest.approx(9.81 * total * upward)


def test_dh_tables_know_prismatic_and_continuous_joints() -> None:
    table = printed()
    table["joints"][0]["kind"] = "prismatic"
    table["joints"][5]["kind"] = "continuous"
    robot = pid.Robot("mixed", urdf_from_table(table))
    assert [joint.kind for joint in robot.joints] == ["prismatic", *["revolute"] * 5]
    q = np.zeros(6)
    lifted = tool_placement(robot, q + 0.3 * (np.arange(6) == 0)) - tool_placement(robot, q)
    np.testing.assert_allclose(lifted[:3, 3], [0, 0, 0.3], atol=1e-12)
    assert robot.upper[5] == math.inf


def test_shapes_plugins_and_oddities_change_nothing() -> None:
    odd = TREE.replace("<robot name", '<robot version="9.9" xmlns:x="http://x" name').replace(
        "</robot>",
        '<transmission name="t"><joint name="slide"/></transmission><gazebo reference="tip"><a/></gazebo>'
        '<material name=""/><!-- remark --></robot>',
    )
    odd = odd.replace(
        "</inertial></link>", '</inertial><visual><geometry><mesh filename="no.stl"/></geometry></visual></link>'
    )
    odd = odd.replace("<axis", '<dynamics damping="x"/><safety_controller/><axis')
    np.testing.assert_array_equal(pid.Robot("odd", odd).nominal, pid.Robot("tree", TREE).nominal)


def test_a_robot_survives_json_limits_and_drives_included(ur5: pid.Robot, tmp_path) -> None:
    path = tmp_path / "arm.toml"
    path.write_text(toml(printed((*INERTIA[:4], (0.0012, 0.0012, 0.0009), INERTIA[5]))))
    for robot in (ur5, pid.load_robot(path), pid.Robot("tree", TREE)):
        again = pid.Robot.from_dict(json.loads(json.dumps(robot.as_dict(), allow_nan=False)))
        assert again.as_dict() == robot.as_dict()
        assert again.acceleration_limit == robot.acceleration_limit
        np.testing.assert_array_equal(again.nominal, robot.nominal)


def test_gravity_turns_with_the_mounting() -> None:
    """An arm hung from the ceiling bears the opposite gravity torque."""
    up, down = pid.load_robot("ur5"), pid.load_robot("ur5", gravity=(0, 0, 9.81))
    q = np.array([0.3, -1.0, 0.8, 0.2, 0.5, 0.1])
    torques = [pin.computeGeneralizedGravity(r.pinocchio, r.pinocchio.createData(), q) for r in (up, down)]
    np.testing.assert_allclose(torques[0], -torques[1], atol=1e-12)
    assert np.abs(torques[0]).max() > 10
