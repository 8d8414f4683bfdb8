"""The arm in 3D: poses as Pinocchio has them, shapes where they belong."""

from __future__ import annotations

import itertools
import struct
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.graphics.labels import HEIGHT, VIEW_FROM, WIDTH, label_offsets
from physident.graphics.scene import _logged, link_poses, tool_path
from physident.graphics.visuals import Visual, arm_visuals, turned_to
from physident.robots.sources import packaged_meshes
from tests.robots import TREE

BOXED = """<robot name="boxed">
 <link name="base"><visual><geometry><cylinder radius="0.1" length="0.2"/></geometry></visual></link>
 <link name="arm"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
  <visual><origin xyz="0.3 0 0" rpy="0 0 1.5707963267948966"/><geometry><box size="0.6 0.1 0.2"/></geometry></visual></link>
 <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
  <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
 <link name="hand"><visual><geometry><mesh filename="package://parts/meshes/hand.stl" scale="2 2 2"/></geometry></visual></link>
 <joint name="grip" type="fixed"><parent link="arm"/><child link="hand"/><origin xyz="0.6 0 0" rpy="0 1.5707963267948966 0"/></joint>
</robot>"""


@pytest.fixture
def tree(tmp_path: Path) -> pid.Robot:
    path = tmp_path / "tree.urdf"
    path.write_text(TREE)
    return pid.load_robot(path)


@pytest.mark.parametrize("which", ["ur5", "tree"])
def test_poses_are_those_of_pinocchio(which: str, request: pytest.FixtureRequest) -> None:
    robot: pid.Robot = request.getfixturevalue(which)
    q = np.random.default_rng(3).uniform(-2, 2, (5, robot.n))
    rotations, positions = link_poses(robot, q)
    path, data = tool_path(robot, rotations, positions), robot.pinocchio.createData()
    for k in range(len(q)):
        pin.framesForwardKinematics(robot.pinocchio, data, q[k])
        for j in range(robot.n):
            np.testing.assert_allclose(rotations[j, k], data.oMi[j + 1].rotation, atol=1e-12)
            np.testing.assert_allclose(positions[j, k], data.oMi[j + 1].translation, atol=1e-12)
        last = [i for i, f in enumerate(robot.pinocchio.frames) if f.parentJoint == robot.n][-1]
        np.testing.assert_allclose(path[k], data.oMf[last].translation, atol=1e-12)


def test_capsules_reach_from_each_joint_to_the_next(tree: pid.Robot) -> None:
    shapes = [shape for shape in arm_visuals(tree) if shape.kind == "capsule"]
    assert {shape.joint for shape in shapes} >= set(range(tree.n))
    far = [joint for joint in tree.joints if np.linalg.norm(joint.translation) > 0.05]
    assert len(far) == tree.n
    for joint in far:
        ends = [s.translation + s.rotation[:, 2] * s.size[1] for s in shapes if s.joint == joint.parent]
        starts = [s.translation for s in shapes if s.joint == joint.parent]
        near = [
            np.linalg.norm(end - joint.translation) + np.linalg.norm(start)
            for end, start in zip(ends, starts, strict=True)
        ]
        assert min(near) < 1e-12, joint.name


def test_shapes_of_the_description_stand_where_it_puts_them(tmp_path: Path) -> None:
    urdf, mesh = tmp_path / "boxed.urdf", tmp_path / "parts" / "meshes" / "hand.stl"
    urdf.write_text(BOXED)
    robot = pid.load_robot(urdf)
    without = {shape.kind for shape in arm_visuals(robot) if shape.joint == 0}
    assert without == {"capsule"}  # half a link is none: the hand's mesh is not there
    mesh.parent.mkdir(parents=True)
    triangle = struct.pack("<12fH", 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0)
    mesh.write_bytes(bytes(80) + struct.pack("<I", 1) + triangle)
    shapes = arm_visuals(robot, tmp_path)
    (base,) = [shape for shape in shapes if shape.joint < 0]
    assert (base.kind, base.size) == ("cylinder", (0.1, 0.2))
    box, hand = (next(s for s in shapes if s.kind == kind) for kind in ("box", "mesh"))
    np.testing.assert_allclose(box.rotation @ [1, 0, 0], [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(box.translation, [0.3, 0, 0])
    np.testing.assert_allclose(hand.translation, [0.6, 0, 0], atol=1e-12)
    np.testing.assert_allclose(hand.rotation @ [0, 0, 1], [1, 0, 0], atol=1e-12)
    assert (hand.mesh, hand.size) == (mesh, (2, 2, 2))


def test_a_turn_to_a_direction_is_a_rotation() -> None:
    for direction in np.vstack([np.random.default_rng(0).normal(size=(20, 3)), np.eye(3), -np.eye(3)]):
        R = turned_to(direction)
        np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
        assert np.linalg.det(R) == pytest.approx(1)
        np.testing.assert_allclose(R[:, 2], direction / np.linalg.norm(direction), atol=1e-12)


@pytest.mark.parametrize(("ending", "media_type"), [("dae", "model/vnd.collada+xml"), ("DAE", "model/vnd.collada+xml")])
def test_a_collada_mesh_is_logged_with_its_type(tmp_path: Path, ending: str, media_type: str) -> None:
    """The viewer draws a mesh of a type that it is told; the SDK knows that of the other formats by their endings."""
    mesh = tmp_path / f"hand.{ending}"
    mesh.write_text("<COLLADA/>")
    asset, _ = _logged(Visual("mesh", 0, np.eye(3), np.zeros(3), (1.0, 1.0, 1.0), mesh))
    assert asset.media_type.as_arrow_array().to_pylist() == [media_type]


@pytest.mark.parametrize("name", ["ur5", "ur10e"])
def test_names_of_joints_do_not_cover_one_another_on_opening(name: str) -> None:
    robot = pid.load_robot(name)
    rng = np.random.default_rng(4)
    across, up = _screen()
    for _ in range(5):
        q = np.cumsum(np.vstack([rng.uniform(-1.5, 1.5, robot.n), rng.normal(0, 0.02, (200, robot.n))]), axis=0)
        _, positions = link_poses(robot, q)
        labels = positions[:, 0] + label_offsets(positions, np.eye(3))
        reach = np.ptp(positions.reshape(-1, 3), axis=0).max()
        for a, b in itertools.combinations(labels, 2):
            assert abs((a - b) @ across) > WIDTH * reach or abs((a - b) @ up) > HEIGHT * reach


def _screen() -> tuple[np.ndarray, np.ndarray]:
    """The directions to the right and up of a camera that looks from the front right, a little above."""
    across = np.array([0.95, 0.7, 0.0]) / np.hypot(0.95, 0.7)
    return across, np.cross(VIEW_FROM / np.linalg.norm(VIEW_FROM), across)


def test_a_packaged_arm_is_drawn_with_its_own_meshes() -> None:
    if packaged_meshes() is None:
        pytest.skip("the Panda's description is not installed (pip install example-robot-data)")
    meshes = [visual for visual in arm_visuals(pid.load_robot("panda")) if visual.kind == "mesh"]
    assert {visual.joint for visual in meshes} == set(range(-1, 7))
    assert all(visual.mesh is not None and visual.mesh.is_file() for visual in meshes)
