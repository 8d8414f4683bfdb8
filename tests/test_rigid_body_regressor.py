"""The symbolic regressor against Pinocchio, an independent implementation, on serial, prismatic and tree robots."""

from __future__ import annotations

from pathlib import Path

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.dynamics.rigid_body_regressor import torque_entries, torque_expression, torque_pattern, torque_regressor
from tests.robots import TREE, urdf_of


def _states(robot: pid.Robot, count: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.uniform(-3, 3, size=(3, count, robot.n))


def _robot(which: str, request: pytest.FixtureRequest) -> pid.Robot:
    if which == "ur5":
        return pid.load_robot("ur5")
    if which == "tree":
        return pid.Robot("tree", TREE)
    if which == "tilted ur5":
        return pid.load_robot("ur5", gravity=(1.0, -2.0, -9.5))
    if which == "sample":
        return pid.Robot("sample", urdf_of(pin.buildSampleModelManipulator()))
    data: Path = request.getfixturevalue("data")
    name = {"ur10e": "ur10e/ur10e.urdf", "tx40": "tx40/tx40_mdh_modified.urdf"}[which]
    return pid.Robot(which, (data / name).read_text())


ROBOTS = ("ur5", "tilted ur5", "tree", "sample", "ur10e", "tx40")


@pytest.mark.parametrize("which", ROBOTS)
def test_equals_pinocchio(which: str, request: pytest.FixtureRequest) -> None:
    robot = _robot(which, request)
    model, q, v, a = robot.pinocchio, *_states(robot, 50, seed=3)
    data = model.createData()
    theirs = np.array([pin.computeJointTorqueRegressor(model, data, *s).copy() for s in zip(q, v, a, strict=True)])
    ours = torque_regressor(robot, q, v, a)
    assert np.abs(ours - theirs).max() <= 1e-12 * max(1.0, np.abs(theirs).max())
    torque = np.array([pin.rnea(model, data, *s).copy() for s in zip(q, v, a, strict=True)])
    np.testing.assert_allclose(ours @ robot.nominal, torque, rtol=0, atol=1e-10)


@pytest.mark.parametrize("which", ["ur5", "tree"])
def test_entries_left_out_are_zero_in_pinocchio(which: str, request: pytest.FixtureRequest) -> None:
    robot = _robot(which, request)
    model, q, v, a = robot.pinocchio, *_states(robot, 50, seed=4)
    data = model.createData()
    theirs = np.array([pin.computeJointTorqueRegressor(model, data, *s).copy() for s in zip(q, v, a, strict=True)])
    pattern = torque_pattern(robot)
    theirs[:, pattern[:, 0], pattern[:, 1]] = 0.0
    assert np.abs(theirs).max() < 1e-13


def test_chunks_do_not_show(ur5: pid.Robot) -> None:
    q, v, a = _states(ur5, 4500, seed=5)
    whole = torque_entries(ur5, q, v, a)
    rows = [0, 2047, 2048, 4095, 4096, 4499]
    np.testing.assert_array_equal(whole[:, rows], torque_entries(ur5, q[rows], v[rows], a[rows]))


def test_expression_gives_exact_gradients(ur5: pid.Robot) -> None:
    function = torque_expression(ur5)
    q, v, a = _states(ur5, 1, seed=6)[:, 0]
    symbol = ca.SX.sym("q", 6)
    torque = ca.mtimes(function(symbol, v, a), ur5.nominal)
    jacobian = ca.Function("J", [symbol], [ca.jacobian(torque, symbol)])
    data = ur5.pinocchio.createData()
    theirs = pin.computeRNEADerivatives(ur5.pinocchio, data, q, v, a)[0].copy()
    np.testing.assert_allclose(np.array(jacobian(q)), theirs, atol=1e-10)
