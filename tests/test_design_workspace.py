"""Limits beyond the joints' own: distances checked by coal, torques by Pinocchio, and errors that name the limit."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.excitation.limits.capsules import bounding_capsule, capsules_of, collision_geometry, nearest_points
from physident.excitation.limits.limit import DISTANCE_RESERVE, LENGTH_UNIT
from physident.excitation.limits.workspace import Workspace
from physident.excitation.limits.workspace_constraints import workspace_constraints
from physident.excitation.motion.series import Series

coal: Any = import_module("coal")  # comes with Pinocchio; it ships no types

BOXES = """<robot name="boxes">
 <link name="base"><collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision></link>
 <link name="one"><inertial><mass value="3"/><origin xyz="0 0 0.2"/><inertia ixx="0.1" iyy="0.1" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><origin xyz="0 0 0.25"/><geometry><box size="0.08 0.06 0.4"/></geometry></collision></link>
 <joint name="a" type="revolute"><parent link="base"/><child link="one"/><origin xyz="0 0 0.15"/><axis xyz="0 1 0"/>
  <limit lower="-2.5" upper="2.5" velocity="2" effort="{effort}"/></joint>
 <link name="two"><inertial><mass value="2"/><origin xyz="0 0 0.2"/><inertia ixx="0.05" iyy="0.05" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><origin xyz="0 0 0.2" rpy="0.1 0 0"/><geometry><cylinder radius="0.04" length="0.3"/></geometry></collision></link>
 <joint name="b" type="revolute"><parent link="one"/><child link="two"/><origin xyz="0 0 0.5"/><axis xyz="0 1 0.2"/>
  <limit lower="-3" upper="3" velocity="2" effort="60"/></joint>
</robot>"""


def boxes(tmp_path: Path, effort: float = 80.0) -> pid.Robot:
    file = tmp_path / "boxes.urdf"
    file.write_text(BOXES.format(effort=effort))
    return pid.load_robot(file)


def test_capsule_distances_are_coals():
    rng = np.random.default_rng(0)
    p, q = rng.uniform(-1, 1, (2, 60, 2, 3))
    q[:5, 1] = q[:5, 0]  # a point
    q[5:10, 1] = q[5:10, 0] + p[5:10, 1] - p[5:10, 0]  # parallel
    s, t = nearest_points(p[:, 0], p[:, 1] - p[:, 0], q[:, 0], q[:, 1] - q[:, 0])
    gap = p[:, 0] + s[:, None] * (p[:, 1] - p[:, 0]) - q[:, 0] - t[:, None] * (q[:, 1] - q[:, 0])
    for one, other, distance in zip(p, q, np.linalg.norm(gap, axis=1), strict=True):
        # a capsule so thin that coal sees a line
        placed = [_capsule(*ends) for ends in (one, other)]
        result = coal.DistanceResult()
        found = coal.distance(*placed[0], *placed[1], coal.DistanceRequest(), result)
        assert found + 2e-4 == pytest.approx(distance, abs=1e-5)


def _capsule(start: np.ndarray, end: np.ndarray) -> tuple:
    axis = end - start
    length = float(np.linalg.norm(axis))
    R = np.eye(3) if length == 0 else pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), axis).toRotationMatrix()
    return coal.Capsule(1e-4, max(length, 1e-9)), coal.Transform3s(R, (start + end) / 2)


def test_bounding_capsules_hold_their_points(tmp_path):
    rng = np.random.default_rng(1)
    for scale in ([1, 0.2, 0.1], [1, 1, 1], [1, 0.9, 0.0]):
        points = rng.standard_normal((200, 3)) * scale + 3
        start, end, radius = bounding_capsule(points)
        s, _ = nearest_points(
            np.broadcast_to(start, points.shape), np.broadcast_to(end - start, points.shape), points, 0 * points
        )
        assert np.linalg.norm(start + s[:, None] * (end - start) - points, axis=1).max() <= radius + 1e-9
    capsules = capsules_of(collision_geometry(boxes(tmp_path)))
    assert [c.link for c in capsules] == [0, 1, 2]
    assert capsules[1].radius == pytest.approx(0.05)  # half the diagonal of 0.08 x 0.06
    assert np.linalg.norm(capsules[2].end - capsules[2].start) == pytest.approx(0.3)


def test_rows_are_the_physics_they_name(ur5):
    model = pid.Model.nominal(ur5)
    workspace, series = Workspace.of(model), Series(6, 4, 0.15)
    y = 0.4 * np.random.default_rng(0).standard_normal(series.size)
    rows = workspace_constraints(workspace, series)
    found = rows.value(y).reshape(48, -1)
    motion = series.trajectory(y)
    states = motion.states(np.arange(48) / 48 * series.period)
    data = ur5.pinocchio.createData()
    rotor = model.parameters("rotor_inertia")
    for k in range(0, 48, 5):
        torque = pin.rnea(ur5.pinocchio, data, states.q[k], states.v[k], states.a[k]) + rotor * states.a[k]
        room = 0.97 * ur5.torque_limit - model.parameters("coulomb_friction")
        np.testing.assert_allclose(found[k, :6], torque / room, rtol=1e-4, atol=1e-6)
        pin.forwardKinematics(ur5.pinocchio, data, states.q[k], states.v[k])
        tool = pin.SE3(np.eye(3), ur5.tool)
        speed = np.linalg.norm(tool.actInv(data.v[6]).linear)
        assert found[k, 6] == pytest.approx((speed / 0.97) ** 2)
        for (i, j), value in zip(
            workspace.self_collision.pairs, found[k, 7 + len(workspace.table.ends) :], strict=True
        ):
            shapes = []
            for c in (workspace.arm.capsules[i], workspace.arm.capsules[j]):
                frame = data.oMi[c.link] if c.link else pin.SE3.Identity()
                shapes.append((_capsule(frame.act(c.start), frame.act(c.end)), c.radius))
            result = coal.DistanceResult()
            gap = coal.distance(*shapes[0][0], *shapes[1][0], coal.DistanceRequest(), result) + 2e-4
            expected = (gap - shapes[0][1] - shapes[1][1] - 0.02 - DISTANCE_RESERVE) / LENGTH_UNIT
            assert value == pytest.approx(expected, abs=1e-4)


def test_gradients_of_rows_and_penalty(ur5):
    workspace, series = Workspace.of(pid.Model.nominal(ur5)), Series(6, 4, 0.15)
    rows = workspace_constraints(workspace, series)
    y = 0.4 * np.random.default_rng(3).standard_normal(series.size)
    J = np.zeros((len(rows.lower), series.size))
    J[rows.pattern[:, 0], rows.pattern[:, 1]] = rows.jacobian(y)
    for seed in range(3):
        d = np.random.default_rng(seed).standard_normal(series.size)
        np.testing.assert_allclose(J @ d, (rows.value(y + 1e-6 * d) - rows.value(y - 1e-6 * d)) / 2e-6, atol=1e-7)
        slope = rows.penalty(y, 0.1)[1] @ d
        sides = [rows.penalty(y + step * d, 0.1)[0] for step in (1e-6, -1e-6)]
        assert slope == pytest.approx((sides[0] - sides[1]) / 2e-6, rel=1e-6)


def test_all_limits_hold_between_the_nodes(tmp_path):
    robot = boxes(tmp_path)
    found = pid.design_trajectory(robot, harmonics=3, base_frequency=0.2, seed=0, starts=1, generations=5)
    assert all(one.margin > 0 for one in found.margins)
    assert {one.limit for one in found.margins} >= {"torque", "table", "self-collision", "position"}
    _, q, v, a = found.trajectory.sample(700.0)
    data, shapes = robot.pinocchio.createData(), collision_geometry(robot)
    names = [int(g.parentJoint) for g in shapes.geometryObjects]
    shapes.addCollisionPair(pin.CollisionPair(names.index(0), names.index(2)))
    geometry = pin.GeometryData(shapes)
    for one in zip(q[::4], v[::4], a[::4], strict=True):
        assert (np.abs(pin.rnea(robot.pinocchio, data, *one)) <= robot.torque_limit).all()
        pin.computeDistances(robot.pinocchio, data, shapes, geometry, one[0])
        assert geometry.distanceResults[0].min_distance >= 0.02


def test_the_limit_that_cannot_be_met_is_named(tmp_path, ur5):
    with pytest.raises(pid.NotSolvedError, match="torque of joint 1 reaches"):
        pid.design_trajectory(boxes(tmp_path, effort=0.02), harmonics=3, starts=1, generations=3)
    with pytest.raises(pid.NotSolvedError, match="table of link"):
        pid.design_trajectory(boxes(tmp_path), harmonics=3, starts=1, generations=3, table=2.0)
    stuck = boxes(tmp_path)
    bare = stuck.urdf.replace('lower="-3" upper="3"', 'lower="0.1" upper="0.1"')
    with pytest.raises(pid.InputError, match="joint 2 cannot move"):
        pid.design_trajectory(pid.Robot("stuck", bare))
    shapeless = boxes(tmp_path).urdf.replace("collision", "visual")
    with pytest.raises(pid.InputError, match="no link has a collision element"):
        pid.design_trajectory(pid.Robot("bare", shapeless))


@pytest.mark.parametrize(
    "settings",
    [
        {"criterion": "best"},
        {"limits": "none"},
        {"harmonics": 1},
        {"base_frequency": 0.0},
        {"periods": 0},
        {"clearance": -1.0},
    ],
)
def test_settings_that_cannot_be_used(ur5, settings):
    with pytest.raises(pid.InputError, match="expected"):
        pid.design_trajectory(ur5, **settings)
