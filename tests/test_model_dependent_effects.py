"""Effects whose columns depend on the model, against Pinocchio and finite differences of the whole model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.identifiability.base_parameters import random_motion
from tests.test_effects import motion, ready


def _rnea(model: object, signals: pid.Signals) -> np.ndarray:
    data = model.createData()  # pyright: ignore[reportAttributeAccessIssue]
    states = zip(signals.q, signals.v, signals.a, strict=True)
    return np.array([pin.rnea(model, data, *s).copy() for s in states])


def _fine_motion(robot: pid.Robot, rate: float = 500.0) -> pid.Signals:
    """A smooth motion whose derivatives in time are well resolved."""
    time = np.arange(int(6 * rate)) / rate
    w, phase = np.array([0.9, 1.3, 1.7, 2.1, 2.6, 3.1]), np.arange(6.0)
    angle = w * time[:, None] + phase
    q, v, a = np.sin(angle), w * np.cos(angle), -(w**2) * np.sin(angle)
    signals = pid.Signals(time, q, v, a, rate=rate)
    return pid.Model.nominal(robot, ["rigid_body"]).refer(signals)


def test_gravity_tilt_is_the_change_of_torque_with_gravity(ur5: pid.Robot) -> None:
    signals = motion(ur5)
    columns = ready("gravity_tilt", ur5).regressor(ur5, signals)
    upright = _rnea(ur5.pinocchio, signals)
    for axis in range(2):
        tilted = ur5.pinocchio.copy()
        tilted.gravity.linear = np.array(ur5.gravity) + np.eye(3)[axis]
        np.testing.assert_allclose(columns[:, :, axis], _rnea(tilted, signals) - upright, atol=1e-9)


def test_payload_is_a_heavier_last_link(ur5: pid.Robot) -> None:
    signals = motion(ur5)
    load = pin.Inertia(2.0, np.array([0.02, -0.01, 0.08]), np.diag([0.004, 0.005, 0.003]))
    heavier = ur5.pinocchio.copy()
    heavier.inertias[6] = heavier.inertias[6] + load
    torque = ready("payload", ur5).regressor(ur5, signals) @ load.toDynamicParameters()
    np.testing.assert_allclose(torque, _rnea(heavier, signals) - _rnea(ur5.pinocchio, signals), atol=1e-9)


def test_link_inertia_is_a_change_of_that_link(ur5: pid.Robot) -> None:
    signals = motion(ur5)
    change = pin.Inertia(0.7, np.array([0.1, 0.02, 0.03]), np.diag([0.01, 0.012, 0.008]))
    heavier = ur5.pinocchio.copy()
    heavier.inertias[3] = heavier.inertias[3] + change
    effect = pid.CATALOGUE["link_inertia"](joints=(3,))
    torque = effect.regressor(ur5, signals) @ change.toDynamicParameters()
    np.testing.assert_allclose(torque, _rnea(heavier, signals) - _rnea(ur5.pinocchio, signals), atol=1e-9)


def test_joint_zero_offset_is_the_derivative_in_the_angle(ur5: pid.Robot) -> None:
    signals = motion(ur5)
    columns = ready("joint_zero_offset", ur5).regressor(ur5, signals)
    data = ur5.pinocchio.createData()
    for k in (0, 57, 211, 399):
        state = signals.q[k], signals.v[k], signals.a[k]
        theirs = pin.computeRNEADerivatives(ur5.pinocchio, data, *state)[0].copy()
        np.testing.assert_allclose(columns[k], theirs, atol=1e-5)
    # an upright arm's first joint, and a last link that is round about its axis, show nothing
    size = np.abs(columns).max(axis=(0, 1))
    assert size[0] < 1e-6
    assert size[5] < 1e-6
    assert (size[1:5] > 1e-3).all()


def test_joint_elasticity_is_the_torque_of_a_link_that_lags(ur5: pid.Robot) -> None:
    signals = _fine_motion(ur5)
    columns = ready("joint_elasticity", ur5).regressor(ur5, signals)
    links = _rnea(ur5.pinocchio, signals)
    compliance = 1e-7
    for joint in (1, 3):
        bend = np.zeros_like(links)
        bend[:, joint] = compliance * links[:, joint]
        rate = np.gradient(bend, 1 / signals.rate, axis=0)
        lagging = replace(
            signals, q=signals.q - bend, v=signals.v - rate, a=signals.a - np.gradient(rate, 1 / signals.rate, axis=0)
        )
        change = (_rnea(ur5.pinocchio, lagging) - links) / compliance
        inner = slice(5, -5)
        scale = np.abs(change).max()
        np.testing.assert_allclose(columns[inner, :, joint], change[inner], atol=1e-3 * scale)


def test_time_delay_and_torque_constant_act_on_the_motor_torque(ur5: pid.Robot) -> None:
    signals = _fine_motion(ur5)
    torque = _rnea(ur5.pinocchio, signals)
    np.testing.assert_allclose(ready("torque_constant", ur5).regressor(ur5, signals)[:, 2, 2], torque[:, 2], atol=1e-9)
    column = ready("time_delay", ur5).regressor(ur5, signals)[:, :, 0]
    late = np.column_stack([np.interp(signals.time - 0.002, signals.time, x) for x in torque.T])
    inner = slice(5, -5)
    np.testing.assert_allclose(0.002 * column[inner], (late - torque)[inner], atol=0.02 * np.abs(late - torque).max())


def test_a_late_channel_shows_the_torque_of_its_joint_as_it_was(ur5: pid.Robot) -> None:
    signals = _fine_motion(ur5)
    torque = _rnea(ur5.pinocchio, signals)
    effect, delays = ready("torque_delay", ur5, (2, 5)), np.array([0.003, -0.002])
    first_order = effect.regressor(ur5, signals) @ delays
    shown = effect.measure(ur5, delays, replace(signals, torque=torque)).torque
    assert shown is not None
    inner = slice(5, -5)
    for joint, delay in zip((1, 4), delays, strict=True):
        late = np.interp(signals.time - delay, signals.time, torque[:, joint])
        np.testing.assert_allclose(shown[:, joint], late, atol=1e-12)
        change = (late - torque[:, joint])[inner]
        np.testing.assert_allclose(first_order[inner, joint], change, atol=0.02 * np.abs(change).max())
    others = [0, 2, 3, 5]
    np.testing.assert_array_equal(shown[:, others], torque[:, others])
    np.testing.assert_array_equal(first_order[:, others], 0.0)


def test_crosstalk_shows_a_share_of_the_other_joints_torques(ur5: pid.Robot) -> None:
    signals = _fine_motion(ur5)
    torque = _rnea(ur5.pinocchio, signals)
    effect = ready("torque_crosstalk", ur5, (2, 5))
    shares = np.array([0.1, -0.2, 0.0, 0.3, 0.05, 0.2, 0.0, -0.1, 0.4, 0.0])
    mixing = np.zeros((6, 6))
    mixing[1, [0, 2, 3, 4, 5]], mixing[4, [0, 1, 2, 3, 5]] = shares[:5], shares[5:]
    np.testing.assert_allclose(effect.regressor(ur5, signals) @ shares, torque @ mixing.T, atol=1e-9)
    shown = effect.measure(ur5, shares, replace(signals, torque=torque)).torque
    assert shown is not None
    np.testing.assert_allclose(shown, torque + torque @ mixing.T, atol=1e-12)


def test_contact_is_the_tools_jacobian(ur5: pid.Robot) -> None:
    signals = motion(ur5)
    effect = pid.CATALOGUE["contact"](intervals=((4.0, 5.2),))
    assert len(effect.columns(ur5)) == 9  # pieces of 0.5, 0.5 and 0.2 s
    columns = effect.regressor(ur5, signals)
    data, tool = ur5.pinocchio.createData(), ur5.pinocchio.getFrameId("tool0")
    inside = np.flatnonzero((signals.time >= 4.5) & (signals.time < 5.0))
    for k in inside:
        pin.computeJointJacobians(ur5.pinocchio, data, signals.q[k])
        pin.framesForwardKinematics(ur5.pinocchio, data, signals.q[k])
        J = pin.getFrameJacobian(ur5.pinocchio, data, tool, pin.LOCAL_WORLD_ALIGNED)[:3]
        np.testing.assert_allclose(columns[k, :, 3:6], J.T, atol=1e-12)
    outside = (signals.time < 4.5) | (signals.time >= 5.0)
    assert np.abs(columns[outside][:, :, 3:6]).max() == 0
    elsewhere = pid.CATALOGUE["contact"](intervals=((4.0, 5.2),), recording="another")
    assert np.abs(elsewhere.values(ur5, signals)).max() == 0


def test_load_is_what_the_links_need(ur5: pid.Robot) -> None:
    """``load`` has no friction and no rotor, which turns before its gear; ``motor`` has all but the measurement effects, which act last on it."""
    smooth = pid.CATALOGUE["coulomb_friction"](smoothing=0.01)
    base = pid.Model.nominal(ur5, ["rigid_body", "rotor_inertia", "viscous_friction", smooth, "torque_offset"])
    effects = (*base.effects, ready("torque_constant", ur5, (2,)))
    theta = np.concatenate([base.theta, [0.1]])
    theta[-7:-1] = 3.0  # torque offsets
    signals = pid.Model(ur5, effects, theta).refer(random_motion(ur5, 5))
    rotor = np.array([d.gear_ratio**2 * d.motor_inertia for d in ur5.drives or ()])
    assert signals.load is not None
    assert signals.motor is not None
    np.testing.assert_allclose(signals.load, _rnea(ur5.pinocchio, signals), atol=1e-9)
    friction = base.parameters("coulomb_friction") * np.tanh(signals.v / 0.01)
    np.testing.assert_allclose(signals.motor, signals.load + rotor * signals.a + friction, atol=1e-9)
    measured = pid.Model(ur5, effects, theta).torque(random_motion(ur5, 5))
    expected = signals.motor * np.array([1, 1.1, 1, 1, 1, 1]) + 3.0
    np.testing.assert_allclose(measured, expected, atol=1e-9)


@pytest.mark.parametrize("gravity", [(0.0, 0.0, -9.81), (3.0, -2.0, -8.0), (0.0, 0.0, 0.0)])
def test_gravity_magnitude_is_the_change_of_torque_with_the_size_of_gravity(gravity: tuple[float, ...]) -> None:
    robot = pid.load_robot("ur5", gravity=gravity)
    signals = motion(robot)
    signals = pid.Model.nominal(robot, ["rigid_body"]).refer(signals)
    column = pid.CATALOGUE["gravity_magnitude"]().regressor(robot, signals)[:, :, 0]
    stronger = robot.pinocchio.copy()
    size = np.linalg.norm(gravity)
    stronger.gravity.linear = np.array(gravity) * (1 + 1 / size) if size else np.array([0.0, 0.0, -1.0])
    np.testing.assert_allclose(column, _rnea(stronger, signals) - _rnea(robot.pinocchio, signals), atol=1e-9)


@pytest.mark.parametrize(("per_ampere", "words"), [(0.85, "15 % less"), (1.25, "25 % more")])
def test_a_gain_says_what_the_motor_gives_for_a_current(per_ampere: float, words: str, ur5: pid.Robot) -> None:
    """A motor that gives a share of its torque needs one over that share of its current, and shows as much."""
    effect = pid.make_effects(["torque_constant"])[0]
    told = replace(effect, joints=(3,)).in_words(ur5, np.array([1 / per_ampere - 1]))
    assert told.startswith("Joint 3 ")
    assert f"{words} torque for a current" in told
