"""Distance from singular poses, against the Jacobian's determinant and poses that are singular by construction."""

from __future__ import annotations

import numpy as np
import pytest

import physident as pid
from tests.robots import TREE

STEP = 1e-6


def test_measure_is_the_determinant_of_a_differenced_jacobian(ur5):
    """The tool's motion is differenced from its placement, so no Jacobian of a library is trusted."""
    import pinocchio as pin

    model = ur5.pinocchio
    data = model.createData()
    tool = pin.SE3(np.eye(3), ur5.tool)

    def place(q):
        pin.forwardKinematics(model, data, q)
        return data.oMi[6] * tool

    rng = np.random.default_rng(0)
    poses = rng.uniform(-2, 2, (5, 6))
    found = pid.measure_manipulability(ur5, poses)
    for q, value in zip(poses, found.measure, strict=True):
        columns = []
        for j in range(6):
            up, down = (place(q + s * STEP * np.eye(6)[j]) for s in (1, -1))
            columns.append(pin.log6(down.actInv(up)).vector / (2 * STEP))
        assert value == pytest.approx(abs(np.linalg.det(np.array(columns))), rel=1e-5)


def test_singular_poses_are_named(ur5):
    free = [0.0, -1.0, 1.0, 0.3, 1.0, 0.0]
    stretched = [0.0, -1.0, 0.0, 0.3, 1.0, 0.0]  # elbow straight
    wrist = [0.0, -1.0, 1.0, 0.3, 0.0, 0.0]  # axes of joints 4 and 6 parallel
    found = pid.measure_manipulability(ur5, np.array([free, stretched, wrist]))
    assert found.ratio[0] > 0.03
    assert (found.ratio[1:] < 1e-10).all()
    assert found.near_singular == pytest.approx(2 / 3)
    assert found.lowest in (1, 2)
    assert "near a singularity for 67 %" in str(found.warning)
    assert pid.measure_manipulability(ur5, np.array([free])).warning is None
    with pytest.raises(pid.InputError, match="expected"):
        pid.measure_manipulability(ur5, np.zeros((3, 5)))


def test_a_trees_tool_is_moved_by_its_own_joints_only(tmp_path):
    file = tmp_path / "tree.urdf"
    file.write_text(TREE)
    robot = pid.load_robot(file)
    q = np.array([[0.1, 0.2, 0.3, 0.4], [0.1, -1.0, 0.3, 0.4]])  # the second joint is the other branch
    found = pid.measure_manipulability(robot, q)
    assert found.measure[0] > 1e-3
    assert found.measure[0] == pytest.approx(found.measure[1])
