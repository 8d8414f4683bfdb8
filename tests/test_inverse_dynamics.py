"""Torques and their derivatives against Pinocchio, the regressor, differences and closed formulas."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.dynamics.inverse_dynamics import gravity_torque, inverse_dynamics, torque_changes
from physident.dynamics.rigid_body_regressor import torque_regressor
from tests.robots import TREE

JOINT = """<joint name="joint_{i}" type="{kind}"><parent link="body_{parent}"/><child link="body_{i}"/>
 <origin xyz="{place}" rpy="{turn}"/><axis xyz="{axis}"/><limit lower="-3" upper="3" velocity="3" effort="100"/></joint>"""
BODY = """<link name="body_{i}"><inertial><origin xyz="{place}" rpy="{turn}"/><mass value="1.5"/>
 <inertia ixx="0.05" ixy="0.004" ixz="0.002" iyy="0.06" iyz="-0.003" izz="0.04"/></inertial></link>"""


def _random_tree(seed: int) -> pid.Robot:
    """Seven joints, each on any link before it, turning or sliding about any axis."""
    rng = np.random.default_rng(seed)

    def three(scale: float) -> str:
        return " ".join(map(repr, rng.uniform(-scale, scale, size=3).tolist()))

    lines = ['<link name="body_0"/>']
    for i in range(1, 8):
        lines.append(BODY.format(i=i, place=three(0.2), turn=three(3)))
        kind, parent = ("revolute", "prismatic")[int(rng.random() < 0.4)], rng.integers(i)
        lines.append(JOINT.format(i=i, kind=kind, parent=parent, place=three(0.5), turn=three(3), axis=three(1)))
    return pid.Robot("random", f'<robot name="random">{"".join(lines)}</robot>')


def _robot(which: str) -> pid.Robot:
    if which == "ur5":
        return pid.load_robot("ur5")
    if which == "tilted ur5":
        return pid.load_robot("ur5", gravity=(1.0, -2.0, -9.5))
    return pid.Robot("tree", TREE) if which == "tree" else _random_tree(int(which))


def _states(robot: pid.Robot, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    q, v, a = np.random.default_rng(count).uniform(-3, 3, size=(3, count, robot.n))
    return q, v, a


ROBOTS = ("ur5", "tilted ur5", "tree", "1", "2", "3")


@pytest.mark.parametrize("which", ROBOTS)
def test_torque_equals_pinocchio_and_the_regressor(which: str) -> None:
    """The regressor for any ten numbers a link, for they need not be physical."""
    robot = _robot(which)
    state = _states(robot, 40)
    data = robot.pinocchio.createData()
    theirs = np.array([pin.rnea(robot.pinocchio, data, *s).copy() for s in zip(*state, strict=True)])
    scale = np.abs(theirs).max()
    np.testing.assert_allclose(inverse_dynamics(robot, robot.nominal, *state), theirs, rtol=0, atol=1e-12 * scale)
    links = np.random.default_rng(8).normal(size=10 * robot.n)
    plain = torque_regressor(robot, *state) @ links
    ours = inverse_dynamics(robot, links, *state)
    np.testing.assert_allclose(ours, plain, rtol=0, atol=1e-12 * np.abs(plain).max())


@pytest.mark.parametrize("which", ROBOTS)
def test_gravity_torque_holds_the_arm_under_any_gravity(which: str) -> None:
    """It equals the torque at rest of a robot mounted so, and adds up over directions."""
    robot, direction = _robot(which), np.array([2.0, -3.0, -8.0])
    q = _states(robot, 30)[0]
    data, model = robot.pinocchio.createData(), robot.pinocchio.copy()
    model.gravity.linear = direction
    theirs = np.array([pin.computeGeneralizedGravity(model, data, x).copy() for x in q])
    ours = gravity_torque(robot, robot.nominal, q, direction)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12 * np.abs(theirs).max())
    parts = sum(g * gravity_torque(robot, robot.nominal, q, axis) for g, axis in zip(direction, np.eye(3), strict=True))
    np.testing.assert_allclose(ours, parts, rtol=0, atol=1e-12 * np.abs(theirs).max())


@pytest.mark.parametrize("which", ROBOTS)
def test_changes_equal_pinocchio(which: str) -> None:
    """A motion (d, d', d'') of joint j changes the torque by d dtau/dq_j + d' dtau/dv_j + d'' M_j."""
    robot = _robot(which)
    state, n = _states(robot, 30), robot.n
    motions = np.random.default_rng(9).normal(size=(n, 3, 30))
    ours = torque_changes(robot, robot.nominal, state, tuple(range(n)), motions)
    data = robot.pinocchio.createData()
    for k, s in enumerate(zip(*state, strict=True)):
        slopes = [np.array(slope) for slope in pin.computeRNEADerivatives(robot.pinocchio, data, *s)]
        inertia = np.array(pin.crba(robot.pinocchio, data, s[0]))
        slopes[2] = np.triu(inertia) + np.triu(inertia, 1).T
        theirs = sum(slope * motions[:, order, k] for order, slope in enumerate(slopes))
        np.testing.assert_allclose(ours[:, :, k].T, theirs, rtol=0, atol=1e-11 * np.abs(theirs).max())


@pytest.mark.parametrize("which", ["ur5", "tree", "1"])
@pytest.mark.parametrize("orders", [1, 2, 3])
def test_changes_equal_differences(which: str, orders: int) -> None:
    """Along some of the joints, in any order, for link parameters that no body has."""
    robot, step = _robot(which), 1e-5
    state, joints = _states(robot, 30), (2, 0)
    links = np.random.default_rng(10).normal(size=10 * robot.n)
    motions = np.random.default_rng(11).normal(size=(2, orders, 30))
    ours = torque_changes(robot, links, state, joints, motions)
    for joint, motion, change in zip(joints, motions, ours, strict=True):
        sides = []
        for sign in (step, -step):
            moved = [x.copy() for x in state]
            for x, way in zip(moved, motion, strict=False):
                x[:, joint] += sign * way
            sides.append(inverse_dynamics(robot, links, *moved))
        differences = (sides[0] - sides[1]) / (2 * step)
        np.testing.assert_allclose(change.T, differences, rtol=0, atol=1e-6 * np.abs(differences).max())


def test_an_upright_arm_does_not_feel_where_its_first_joint_is(ur5: pid.Robot) -> None:
    changes = torque_changes(ur5, ur5.nominal, _states(ur5, 20), (0,), np.ones((1, 1, 20)))
    np.testing.assert_array_equal(changes, 0.0)


def test_chunks_do_not_show(ur5: pid.Robot) -> None:
    q, v, a = _states(ur5, 4500)
    whole = inverse_dynamics(ur5, ur5.nominal, q, v, a)
    rows = [0, 2047, 2048, 4095, 4096, 4499]
    np.testing.assert_array_equal(whole[rows], inverse_dynamics(ur5, ur5.nominal, q[rows], v[rows], a[rows]))


@pytest.mark.parametrize("count", [0, 1])
def test_few_samples_and_no_joints_keep_their_shapes(ur5: pid.Robot, count: int) -> None:
    state = tuple(np.zeros((count, 6)) for _ in range(3))
    assert inverse_dynamics(ur5, ur5.nominal, *state).shape == (count, 6)
    assert torque_changes(ur5, ur5.nominal, (state[0], state[1], state[2]), (), np.zeros((0, 1, count))).shape == (
        0,
        6,
        count,
    )
    one = torque_changes(ur5, ur5.nominal, (state[0], state[1], state[2]), (3,), np.zeros((1, 3, count)))
    assert one.shape == (1, 6, count)
