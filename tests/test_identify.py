"""Identification: known truths come back, and what must not matter does not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.effects.friction import CoulombFriction, ViscousFriction
from physident.effects.inertia import RigidBody, RotorInertia
from physident.recordings.channels import Channels
from physident.recordings.recording import recording_from_rows
from tests.conftest import UR5_GAINS
from tests.robots import TREE

RATE = 125.0
COULOMB = np.array([7.7, 8.3, 7.8, 1.4, 2.0, 2.1])
VISCOUS = np.array([9.0, 9.0, 6.0, 2.5, 2.0, 1.5])


def _recording(robot: pid.Robot, seed: int, noise: float = 0.0) -> pid.Recording:
    """A recording whose torque comes from Pinocchio and closed-form friction, not from the package's effects."""
    time, q, v, a = pid.random_trajectory(robot, seed=seed, duration=20.0, base_frequency=0.1).sample(RATE)
    data = robot.pinocchio.createData()
    torque = np.array([pin.rnea(robot.pinocchio, data, *s).copy() for s in zip(q, v, a, strict=True)])
    torque += COULOMB * np.tanh(v / 0.01) + VISCOUS * v
    torque += noise * np.random.default_rng(seed).normal(size=torque.shape)
    return recording_from_rows(Channels(time=time, q=q, effort=torque, effort_kind="torque", dq=v), f"made {seed}")


@pytest.fixture(scope="module")
def runs(ur5: pid.Robot) -> list[pid.Recording]:
    return [_recording(ur5, seed, noise=0.3) for seed in (1, 2, 3)]


@pytest.mark.parametrize("method", ["wls", "ols"])
def test_truth_comes_back(method: str, ur5: pid.Robot) -> None:
    estimate = pid.identify(ur5, [_recording(ur5, seed) for seed in (1, 2)], method=method)
    np.testing.assert_allclose(estimate.model.parameters("coulomb_friction"), COULOMB, rtol=2e-2)
    np.testing.assert_allclose(estimate.model.parameters("viscous_friction"), VISCOUS, rtol=2e-2)
    truth = pid.Model.nominal(ur5, estimate.model.effects)
    gravity = pid.Signals.of_states(
        np.random.default_rng(0).uniform(-3, 3, (20, 6)), np.zeros((20, 6)), np.zeros((20, 6))
    )
    np.testing.assert_allclose(estimate.model.torque(gravity), truth.torque(gravity), atol=0.3)


def test_weights_pay_where_joints_differ(ur5: pid.Robot) -> None:
    """With noise on joint 2 alone, weighting keeps it out of the wrist's parameters."""
    clean = _recording(ur5, 4)
    noisy = clean.effort + np.array([0, 60.0, 0, 0, 0, 0]) * np.random.default_rng(0).normal(size=clean.effort.shape)
    run = recording_from_rows(
        Channels(time=clean.time, q=clean.q, effort=noisy, effort_kind="torque", dq=clean.dq), "noisy joint 2"
    )
    errors = {}
    for method in ("wls", "ols"):
        found = pid.identify(ur5, [run], method=method).model.parameters("viscous_friction")
        errors[method] = np.abs(found[2:] - VISCOUS[2:]).max()
    assert errors["wls"] < errors["ols"]


def test_units_of_torque_do_not_matter(ur5: pid.Robot, runs: list[pid.Recording]) -> None:
    """Torques and their drive gains scaled inversely give the same estimate."""
    scale = (2.0, 0.5, 3.0, 1.0, 0.1, 4.0)
    as_current = [
        pid.Recording(r.time, r.q, r.effort / np.array(scale), "current", r.dq, drive_gains=scale) for r in runs
    ]
    one, two = pid.identify(ur5, runs), pid.identify(ur5, as_current)
    np.testing.assert_allclose(two.theta, one.theta, rtol=1e-7, atol=1e-7)
    assert two.drive_gains == scale


def test_order_of_recordings_does_not_matter(ur5: pid.Robot, runs: list[pid.Recording]) -> None:
    one, two = pid.identify(ur5, runs), pid.identify(ur5, runs[::-1])
    np.testing.assert_allclose(two.theta, one.theta, rtol=1e-7, atol=1e-8)
    np.testing.assert_allclose(two.sigma, one.sigma, rtol=1e-7)


def test_order_of_effects_does_not_matter(ur5: pid.Robot, runs: list[pid.Recording]) -> None:
    names = ["rigid_body", "viscous_friction", "coulomb_friction"]
    one, two = pid.identify(ur5, runs, names), pid.identify(ur5, runs, names[::-1])
    for name in names:
        np.testing.assert_allclose(two.model.parameters(name), one.model.parameters(name), rtol=1e-5, atol=1e-6)


def test_least_squares_is_stationary(ur5: pid.Robot, runs: list[pid.Recording]) -> None:
    """The residual is orthogonal to every column: checked on the dense regressor, not on the solver's word."""
    estimate = pid.identify(ur5, runs, method="ols")
    signals = [pid.prepare(run, estimate.filter) for run in runs]
    regressor = pid.build_regressor(ur5, estimate.model.effects, signals, estimate.filter)
    Y = regressor.Y.reshape(-1, 84)
    residual = (regressor.torque - regressor.predict(estimate.theta)).ravel()
    size = np.linalg.norm(Y, axis=0)
    gradient = np.abs(Y.T @ residual)[size > 1e-9] / size[size > 1e-9] / np.linalg.norm(residual)
    assert gradient.max() < 1e-8
    assert estimate.certificate.stationarity < 1e-8


def test_what_no_motion_shows_stays_nominal(ur5: pid.Robot, runs: list[pid.Recording]) -> None:
    estimate = pid.identify(ur5, runs)
    change = estimate.theta - pid.Model.nominal(ur5).theta
    K = estimate.base.grouping
    hidden = np.eye(len(change)) - np.linalg.pinv(K) @ K
    assert np.abs(hidden @ change).max() < 1e-8


def test_a_joint_that_never_moves_is_named(ur5: pid.Robot) -> None:
    """Its friction and rotor cannot be seen: asked for, an error; left out, the other joints are identified."""
    run = _recording(ur5, 5)
    q, v = run.q.copy(), np.array(run.dq)
    q[:, 5], v[:, 5] = 0.3, 0.0
    still = recording_from_rows(
        Channels(time=run.time, q=q, effort=run.effort, effort_kind="torque", dq=v), "joint 6 still"
    )
    with pytest.raises(pid.InputError, match=r"joint 6.*record a motion of joint 6"):
        pid.identify(ur5, [still])
    moving = tuple(range(1, 6))
    effects = [RigidBody(), RotorInertia(moving), ViscousFriction(moving), CoulombFriction(moving)]
    estimate = pid.identify(ur5, [still], effects)
    np.testing.assert_allclose(estimate.model.parameters("coulomb_friction"), COULOMB[:5], rtol=0.1)


def test_saved_model_is_the_same_model(ur5: pid.Robot, runs: list[pid.Recording], tmp_path: Path) -> None:
    estimate = pid.identify(ur5, runs, filter=pid.Filter(6.0))
    estimate.save(tmp_path / "model.json")
    back = pid.load_estimate(tmp_path / "model.json")
    states = pid.Signals.of_states(*np.random.default_rng(0).normal(size=(3, 20, 6)))
    np.testing.assert_array_equal(back.model.torque(states), estimate.model.torque(states))
    np.testing.assert_array_equal(back.covariance, estimate.covariance)
    assert back.filter == estimate.filter
    assert [s.sha256 for s in back.sources] == [run.sha256 for run in runs]
    assert back.as_dict() == estimate.as_dict()


def test_real_ur5_is_predicted(data: Path, ur5: pid.Robot) -> None:
    """Within 5 % of what another implementation of the same method reached on an unseen movement."""
    train = pid.load_recordings([data / f"ur5/{k}.csv.gz" for k in ("move6", "move5", "move9")], drive_gains=UR5_GAINS)
    estimate = pid.identify(ur5, train, filter=pid.Filter(8.0))
    score = pid.validate(estimate, pid.load_recordings(data / "ur5/move8.csv.gz"))
    assert (score.relative <= 1.05 * np.array([17.3, 4.5, 7.2, 19.0, 10.3, 47.6])).all()


def test_bad_calls_are_refused(ur5: pid.Robot, runs: list[pid.Recording]) -> None:
    with pytest.raises(pid.InputError, match="method 'magic' is unknown"):
        pid.identify(ur5, runs, method="magic")
    with pytest.raises(pid.InputError, match="no recordings"):
        pid.identify(ur5, [])
    still = np.zeros((1000, 6))
    standing = recording_from_rows(
        Channels(time=np.arange(1000) / RATE, q=still, effort=still + 1, effort_kind="torque", dq=still), "pose"
    )
    with pytest.raises(pid.InputError, match="no joint moves"):
        pid.identify(ur5, [standing])


@pytest.mark.parametrize("method", ["ols", "wls", "robust"])
def test_order_of_joints_does_not_matter(method: str) -> None:
    """The same tree with its branches named the other way round has its joints in another order, and the same physics."""
    one = pid.Robot("tree", TREE)
    two = pid.Robot("tree", TREE.replace('"left', '"z_left'))
    names = [name.replace("left", "z_left") for name in one.joint_names]
    order = [names.index(name) for name in two.joint_names]
    assert order != sorted(order)
    time = np.arange(0, 20, 1 / RATE)
    w, phase = np.array([1.1, 1.7, 2.3, 2.9]), np.arange(4.0)
    angle = w * time[:, None] + phase
    q, v, a = 0.6 * np.sin(angle), 0.6 * w * np.cos(angle), -0.6 * w**2 * np.sin(angle)
    data = one.pinocchio.createData()
    torque = np.array([pin.rnea(one.pinocchio, data, *s).copy() for s in zip(q, v, a, strict=True)])
    torque += [3.0, 0.5, 0.7, 0.2] * np.tanh(v / 0.01)
    torque += 0.05 * np.random.default_rng(0).normal(size=torque.shape)
    effects = ["rigid_body", "coulomb_friction"]
    first = pid.identify(
        one,
        [recording_from_rows(Channels(time=time, q=q, effort=torque, effort_kind="torque", dq=v), "a")],
        effects,
        method,
    )
    swapped = recording_from_rows(
        Channels(time=time, q=q[:, order], effort=torque[:, order], effort_kind="torque", dq=v[:, order]), "b"
    )
    second = pid.identify(two, [swapped], effects, method)
    np.testing.assert_allclose(second.sigma, first.sigma[order], rtol=1e-5)
    found = second.model.parameters("coulomb_friction")
    np.testing.assert_allclose(found, first.model.parameters("coulomb_friction")[order], rtol=1e-5)
    states = [x[::50] for x in (q, v, a)]
    ours = first.model.torque(pid.Signals.of_states(*states))[:, order]
    theirs = second.model.torque(pid.Signals.of_states(*(x[:, order] for x in states)))
    np.testing.assert_allclose(theirs, ours, atol=1e-4)
