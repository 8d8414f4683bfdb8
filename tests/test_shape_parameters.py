"""Shape parameters and model-dependent columns are found on data made by closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from scipy.special import erf

import physident as pid
from physident.estimation.shapes.shape_parameters import settled_regressor
from physident.identifiability.projection import Baseline
from physident.recordings.channels import Channels
from physident.recordings.recording import recording_from_rows
from tests.test_identify import COULOMB, VISCOUS, _recording

RATE = 125.0
DEFAULT = ("rigid_body", "rotor_inertia", "viscous_friction", "coulomb_friction", "torque_offset")
WIDTH = 0.008  # rad/s


def sign(v: np.ndarray) -> np.ndarray:
    """A smooth sign of slope 1 / WIDTH: the mean of sgn over velocities with a normal error, which the regressor is made of."""
    return erf(np.sqrt(np.pi) * v / (2 * WIDTH))


def _with_extra(robot: pid.Robot, seed: int, extra: object, noise: float = 0.1) -> pid.Recording:
    """A recording whose torque has ``extra(time, q, v, load)`` (N, 6) on top of the ordinary arm's."""
    time, q, v, a = pid.random_trajectory(robot, seed=seed, duration=20.0, base_frequency=0.1).sample(RATE)
    data = robot.pinocchio.createData()
    load = np.array([pin.rnea(robot.pinocchio, data, *s).copy() for s in zip(q, v, a, strict=True)])
    torque = load + COULOMB * sign(v) + VISCOUS * v + extra(time, q, v, load)  # pyright: ignore[reportCallIssue]
    torque += noise * np.random.default_rng(seed).normal(size=torque.shape)
    return recording_from_rows(Channels(time=time, q=q, effort=torque, effort_kind="torque", dq=v), f"made {seed}")


def _one(joint: int, column: np.ndarray) -> np.ndarray:
    torque = np.zeros((len(column), 6))
    torque[:, joint - 1] = column
    return torque


@pytest.mark.parametrize(
    ("name", "field", "truth", "law"),
    [
        ("stribeck_friction", "velocity", 0.08, lambda t, q, v: 6 * sign(v) * np.exp(-((v / 0.08) ** 2))),
        ("nonlinear_viscous_friction", "exponent", 0.5, lambda t, q, v: 6 * np.sign(v) * np.abs(v) ** 0.5),
        ("torque_ripple", "order", 7.0, lambda t, q, v: 2 * np.sin(7 * q + 0.4)),
        ("warm_up", "time_constant", 8.0, lambda t, q, v: 6 * np.exp(-t / 8) * (sign(v) + v)),
    ],
)
def test_a_strong_shape_is_found_within_ten_percent(
    name: str, field: str, truth: float, law: object, ur5: pid.Robot
) -> None:
    def extra(t: np.ndarray, q: np.ndarray, v: np.ndarray, load: np.ndarray) -> np.ndarray:
        return _one(3, law(t, q[:, 2], v[:, 2]))  # pyright: ignore[reportCallIssue]

    runs = [_with_extra(ur5, seed, extra) for seed in (1, 2)]
    effect = pid.CATALOGUE[name](joints=(3,))
    estimate = pid.identify(ur5, runs, [*DEFAULT, effect], filter=pid.Filter(8.0))
    (found,) = getattr(estimate.model.effects[-1], field)
    assert found == pytest.approx(truth, rel=0.1)
    if not effect.shape_parameters[0].discrete:
        (shape,) = estimate.shape_parameters
        assert (shape.value, shape.joint, shape.field) == (found, 3, field)
        assert abs(found - truth) < 4 * shape.std < truth
        # a parameter beside a shape that had to be found is less sure than beside one that is given
        given = pid.identify(ur5, runs, [*DEFAULT, estimate.model.effects[-1]], filter=pid.Filter(8.0))
        assert given.shape_parameters == ()
        assert (np.diag(estimate.covariance) >= 0.9 * np.diag(given.covariance)).all()


def test_load_dependent_friction_settles_on_the_truth(ur5: pid.Robot) -> None:
    """The column depends on the load, which depends on the parameters: both are found together."""

    def extra(t: np.ndarray, q: np.ndarray, v: np.ndarray, load: np.ndarray) -> np.ndarray:
        return _one(2, 0.15 * sign(v[:, 1]) * np.abs(load[:, 1]))

    runs = [_with_extra(ur5, seed, extra) for seed in (1, 2)]
    lighter = replace(ur5, urdf=ur5.urdf.replace('<mass value="8.393"/>', '<mass value="4.0"/>'))  # a wrong nominal
    effect = pid.CATALOGUE["load_dependent_friction"](joints=(2,))
    estimate = pid.identify(lighter, runs, [*DEFAULT, effect])
    assert estimate.theta[-1] == pytest.approx(0.15, rel=0.05)
    # settled: the regressor at the found parameters predicts what the model itself predicts
    signals = [pid.prepare(run, estimate.filter) for run in runs]
    regressor = pid.build_regressor(lighter, estimate.model.effects, signals, estimate.filter, theta=estimate.theta)
    again = settled_regressor(lighter, estimate.model.effects, signals, estimate.filter)
    difference = np.abs(again.predict(estimate.theta) - regressor.predict(estimate.theta)).max()
    assert difference < 0.02


def test_projected_gain_is_the_gain_of_a_refit(ur5: pid.Robot) -> None:
    """Judging a candidate against the factor equals refitting everything with it."""
    runs = [_recording(ur5, 1, 0.5)]
    filter = pid.Filter()
    signals = [pid.prepare(run, filter) for run in runs]
    effects = pid.make_effects(["rigid_body", "coulomb_friction"])
    extra = pid.make_effects(["viscous_friction"])
    weights = np.linspace(0.5, 2.0, 6)
    regressor = pid.build_regressor(ur5, effects, signals, filter)
    baseline = Baseline.of(regressor, weights)
    judged = baseline.project(pid.build_regressor(ur5, extra, signals, filter))
    both = Baseline.of(pid.build_regressor(ur5, (*effects, *extra), signals, filter), weights)
    assert judged.gain == pytest.approx(baseline.cost - both.cost, rel=1e-6)
    assert 0 < judged.share <= 1
    inside = baseline.project(pid.build_regressor(ur5, pid.make_effects(["coulomb_friction"]), signals, filter))
    assert inside.share < 1e-9
    assert inside.gain == pytest.approx(0.0, abs=1e-6 * baseline.cost)
