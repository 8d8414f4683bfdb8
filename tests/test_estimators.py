"""Every estimator: known truths, stationarity checked on the dense rows, outliers, and settings that survive a file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor, build_regressor
from physident.effects.catalogue import DEFAULT_EFFECTS, make_effects
from physident.estimation.estimators import (
    OLS,
    WLS,
    Physical,
    Robust,
    estimator_as_dict,
    estimator_from_dict,
    estimator_from_options,
)
from physident.estimation.physical.bounds import Bound, Box, Ellipsoid
from physident.estimation.physical.prior import Entropic, NominalDistance, NoPrior
from physident.estimation.regressor_fit import estimate_from
from physident.identifiability.base_parameters import find_base_parameters
from physident.recordings.signals import Filter, Signals

FILTER = Filter(5.0)
FRICTION = np.array([1.2, 1.2, 0.9, 0.2, 0.2, 0.2, 9, 9, 6, 2.5, 2, 1.5, 7.7, 8.3, 7.8, 1.4, 2, 2.1, 0, 0, 0, 0, 0, 0])
SIGMA = np.array([2.0, 3.0, 1.5, 0.4, 0.5, 0.5])  # N m, white at the recording's rate
METHODS = {
    "ols": OLS(),
    "wls": WLS(),
    "full": WLS("full"),
    "robust": Robust(),
    "physical": Physical(resamples=0),
    "physical huber": Physical(loss="huber", resamples=0),
    "physical, nominal": Physical(NominalDistance(), resamples=0),
    "physical, no prior": Physical(NoPrior(), resamples=0),
}


@pytest.fixture(scope="module")
def truth(ur5: pid.Robot) -> Model:
    model = Model.nominal(ur5)
    return Model(ur5, model.effects, np.concatenate([model.theta[:60], FRICTION]))


@pytest.fixture(scope="module")
def motion(ur5: pid.Robot) -> Signals:
    t, q, v, a = pid.random_trajectory(ur5, seed=3, duration=20.0).sample(100.0)
    return Signals(t, q, v, a, rate=100.0)


def regress(truth: Model, motion: Signals, noise: np.ndarray) -> Regressor:
    return build_regressor(truth.robot, truth.effects, [replace(motion, torque=truth.torque(motion) + noise)], FILTER)


@pytest.fixture(scope="module")
def noisy(truth: Model, motion: Signals) -> Regressor:
    return regress(truth, motion, SIGMA * np.random.default_rng(0).normal(size=motion.q.shape))


@pytest.mark.parametrize("name", METHODS)
def test_truth_comes_back_from_little_noise(name: str, truth: Model, motion: Signals) -> None:
    """With the truth as nominal and noise of a ten-thousandth, every method predicts what the arm does."""
    quiet = regress(truth, motion, 1e-4 * np.random.default_rng(0).normal(size=motion.q.shape))
    estimate = estimate_from(truth.robot, truth.effects, quiet, [], METHODS[name], FILTER)
    wrong = np.abs(quiet.predict(estimate.theta - truth.theta)).max(axis=0)
    assert (wrong < 1e-3).all()
    assert estimate.method in ("ols", "wls", "robust", "physical")


def test_huber_is_stationary(truth: Model, noisy: Regressor) -> None:
    """The columns are orthogonal to the clipped residuals: computed on the dense rows, from the median alone."""
    estimate = estimate_from(truth.robot, truth.effects, noisy, [], Robust(1.0), FILTER)
    residual = noisy.torque - noisy.predict(estimate.theta)
    sigma = 1.4826 * np.median(np.abs(residual), axis=0)
    psi = np.clip(residual / sigma, -1.0, 1.0)
    assert (np.abs(residual / sigma) > 1.0).mean() > 0.1
    Y = noisy.Y / sigma[:, None]
    gradient = np.einsum("mjp,mj->p", Y, psi)
    size = np.linalg.norm(Y.reshape(-1, Y.shape[2]), axis=0)
    assert (np.abs(gradient) <= 1e-5 * np.maximum(size, 1e-3) * np.linalg.norm(psi)).all()


def test_full_weights_are_stationary_in_their_own_covariance(truth: Model, motion: Signals) -> None:
    rng = np.random.default_rng(1)
    shared = rng.normal(size=(len(motion.q), 1)) * SIGMA + 0.3 * SIGMA * rng.normal(size=motion.q.shape)
    regressor = regress(truth, motion, shared)
    full = estimate_from(truth.robot, truth.effects, regressor, [], WLS("full"), FILTER)
    residual = regressor.torque - regressor.predict(full.theta)
    weighted = residual @ np.linalg.inv(residual.T @ residual)
    gradient = np.einsum("mjp,mj->p", regressor.Y, weighted)
    size = np.linalg.norm(regressor.Y.reshape(-1, 84), axis=0) * np.linalg.norm(weighted)
    assert (np.abs(gradient) <= 1e-5 * np.maximum(size, 1e-3 * size.max())).all()


def test_full_weights_pay_where_joints_share_their_noise(truth: Model, motion: Signals) -> None:
    error: dict[str, list[float]] = {"full": [], "diagonal": []}
    for seed in range(4):
        rng = np.random.default_rng(seed)
        shared = rng.normal(size=(len(motion.q), 1)) * SIGMA + 0.2 * SIGMA * rng.normal(size=motion.q.shape)
        regressor = regress(truth, motion, shared)
        for noise in ("full", "diagonal"):
            found = estimate_from(truth.robot, truth.effects, regressor, [], WLS(noise), FILTER)
            error[noise].append(float((regressor.predict(found.theta - truth.theta) / SIGMA).std()))
    assert np.mean(error["full"]) < 0.8 * np.mean(error["diagonal"])


@pytest.mark.parametrize("name", ["robust", "physical huber"])
def test_outliers_count_little(name: str, truth: Model, motion: Signals) -> None:
    """Bursts of 40 standard deviations in one row of thirty move weighted least squares several times further."""
    rng = np.random.default_rng(2)
    noise = SIGMA * rng.normal(size=motion.q.shape)
    bursts = (rng.random((len(motion.q) // 20, 1)) < 1 / 30).repeat(20, axis=0)
    outliers = noise + 40 * SIGMA * np.vstack([bursts, np.zeros((len(motion.q) - len(bursts), 1))])
    regressor = regress(truth, motion, outliers)
    distance = {}
    for key, method in (("wls", WLS()), (name, METHODS[name])):
        found = estimate_from(truth.robot, truth.effects, regressor, [], method, FILTER)
        wrong = regressor.predict(found.theta - truth.theta) / SIGMA
        distance[key] = np.sqrt((wrong**2).mean())
    assert distance[name] < distance["wls"] / 2


def test_loss_matters_little_without_outliers(truth: Model, noisy: Regressor) -> None:
    wls, robust = (estimate_from(truth.robot, truth.effects, noisy, [], m, FILTER) for m in (WLS(), Robust()))
    apart = noisy.predict(wls.theta - robust.theta).std(axis=0)
    wrong = noisy.predict(wls.theta - truth.theta).std(axis=0)
    assert (apart < wrong).all()


@pytest.mark.parametrize(
    "estimator",
    [
        *METHODS.values(),
        Physical(Entropic(7.0), "huber", 30.0, (Box(2, (-1, -1, -1), (1, 1, 1)), Ellipsoid(3, (0, 0, 0), (1, 2, 3)))),
        Physical(NominalDistance("auto", (1.0, 2.0)), bounds=(Bound("m_2", 0.5), Bound("m_3", None, 4.0)), seed=3),
    ],
    ids=lambda e: type(e).__name__,
)
def test_settings_survive_a_file(estimator: OLS | WLS | Robust | Physical) -> None:
    import json

    assert estimator_from_dict(json.loads(json.dumps(estimator_as_dict(estimator)))) == estimator


def test_physical_estimate_survives_a_file(truth: Model, noisy: Regressor, tmp_path: Path) -> None:
    estimate = estimate_from(truth.robot, truth.effects, noisy, [], METHODS["physical"], FILTER)
    estimate.save(tmp_path / "model.json")
    back = pid.load_estimate(tmp_path / "model.json")
    assert back.as_dict() == estimate.as_dict()
    np.testing.assert_array_equal(back.intervals(), estimate.intervals())
    text = repr(back)
    assert "of the torque; physical: every link is a rigid body" in text
    assert "the data determine" in text


def test_base_parameters_do_not_depend_on_the_method(truth: Model) -> None:
    base = find_base_parameters(truth.robot, make_effects(DEFAULT_EFFECTS))
    assert base.r == 58


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: Robust(-1.0), "threshold is -1.0"),
        (lambda: WLS("sideways"), "noise is 'sideways'"),  # pyright: ignore[reportArgumentType]
        (lambda: Physical(loss="cubes"), "loss is 'cubes'"),  # pyright: ignore[reportArgumentType]
        (lambda: Physical(total_mass=-3.0), "total_mass is -3.0"),
        (lambda: Physical(resamples=1), "resamples is 1"),
        (lambda: Entropic(-1.0), "prior weight is -1.0"),
        (lambda: Entropic(float("nan")), "prior weight is nan"),
        (lambda: estimator_from_options("wls", "none", None, "squares", None), "belong to --method physical"),
        (lambda: estimator_from_options("physical", "flat", None, "squares", None), "prior 'flat' is unknown"),
        (lambda: estimator_from_options("physical", "entropic", "much", "squares", None), "--prior-weight is 'much'"),
        (lambda: Bound("m_3", 2.0, 1.0), "bounds of m_3 are 2.0 and 1.0"),
        (lambda: Box(2, (0, 0, 0), (1, -1, 1)), "along y is empty"),
        (lambda: Ellipsoid(2, (0, 0, 0), (1, 0, 1)), "semi_axes"),
    ],
)
def test_settings_that_cannot_be_are_refused(call, text: str) -> None:
    with pytest.raises(pid.InputError, match=text):
        call()
