"""Standard errors: against literal leave-out refits, closed forms, and the share of intervals that hold the truth."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

import physident as pid
from physident.dynamics.model import Model
from physident.dynamics.regressor import JointRows, Regressor, build_regressor
from physident.effects.effect import Column
from physident.errors import PhysidentWarning
from physident.estimation import uncertainty
from physident.estimation.estimators import Physical
from physident.estimation.least_squares import least_squares
from physident.estimation.regressor_fit import estimate_from
from physident.estimation.uncertainty import block_labels, correlation_rows, jackknife, t_quantile
from physident.estimation.weighting import weight_rows
from physident.identifiability.base_parameters import BaseParameters
from physident.recordings.signals import Filter, Signals
from tests.conftest import UR10E_COLUMNS, UR10E_GAINS

ROWS, COLUMNS = 600, 4
TRUTH = np.array([1.0, -2.0, 0.5, 3.0])
BASE = BaseParameters(
    tuple(Column(f"theta_{i}", "1", 1, "made") for i in range(COLUMNS)),
    np.arange(COLUMNS), np.array([], dtype=np.intp), np.zeros((COLUMNS, 0)), np.ones(COLUMNS), (1.0, 0.0),
)  # fmt: skip


def slow(keep: float, shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
    """First-order noise of unit variance that keeps this share of itself from row to row."""
    drive = rng.standard_normal((shape[0] + 500, *shape[1:]))
    return np.asarray(lfilter([np.sqrt(1 - keep**2)], [1, -keep], drive, axis=0))[500:]


def made(noise: np.ndarray, seed: int = 0, keep: float = 0.9) -> Regressor:
    """One joint with slow columns, as a motion's are, in two segments."""
    Y = slow(keep, (ROWS, COLUMNS), np.random.default_rng(1000 + seed))
    segment = np.repeat([0, 1], ROWS // 2)
    rows = JointRows(np.arange(COLUMNS), Y)
    torque = (Y @ TRUTH + noise)[:, None]
    return Regressor(
        BASE.columns, (rows,), torque, np.arange(ROWS) / 20.0, segment, segment, 20.0, np.ones((ROWS, 1), bool)
    )


def test_jackknife_is_leaving_blocks_out() -> None:
    regressor = made(slow(0.8, (ROWS,), np.random.default_rng(0)))
    solution = least_squares(regressor, BASE, np.zeros(COLUMNS), "diagonal")
    white = weight_rows(regressor, 1 / solution.sigma)
    residual = white.torque - white.predict(solution.base)
    found = jackknife(white, BASE, residual, 3.0)
    labels = block_labels(regressor.segment, 30)
    Y, tau = regressor.joints[0].values, regressor.torque[:, 0]
    refits = [np.linalg.lstsq(Y[labels != b], tau[labels != b], rcond=None)[0] for b in range(labels.max() + 1)]
    np.testing.assert_allclose(found.deviations, solution.base - np.array(refits), rtol=1e-6, atol=1e-10)
    assert found.blocks == 20


def test_errors_of_white_noise_are_the_textbook_ones() -> None:
    ratios = []
    for seed in range(20):
        regressor = made(np.random.default_rng(seed).standard_normal(ROWS), seed)
        solution = least_squares(regressor, BASE, np.zeros(COLUMNS), "diagonal")
        Y = regressor.joints[0].values
        ratios.append(np.sqrt(np.diag(solution.covariance)) / np.sqrt(np.diag(np.linalg.inv(Y.T @ Y))))
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.1)


def test_intervals_cover_and_textbook_ones_do_not() -> None:
    hits, textbook = [], []
    for seed in range(150):
        regressor = made(slow(0.9, (ROWS,), np.random.default_rng(seed)), seed)
        solution = least_squares(regressor, BASE, np.zeros(COLUMNS), "diagonal")
        wrong = np.abs(solution.base - TRUTH)
        hits.append(wrong <= t_quantile(solution.blocks) * np.sqrt(np.diag(solution.covariance)))
        Y = regressor.joints[0].values
        textbook.append(wrong <= 1.96 * solution.sigma * np.sqrt(np.diag(np.linalg.inv(Y.T @ Y))))
    assert 0.90 <= np.mean(hits) <= 0.99
    assert np.mean(textbook) < 0.75


def test_intervals_cover_where_most_blocks_show_nothing() -> None:
    """A joint that rests for most of a recording: its blocks are many, but few of them know anything."""
    hits = []
    for seed in range(150):
        regressor = made(slow(0.6, (ROWS,), np.random.default_rng(seed)), seed)
        known = (np.arange(ROWS) % 100 < 20).astype(float)[:, None]
        solution = least_squares(weight_rows(regressor, 1e-4 + known), BASE, np.zeros(COLUMNS), "diagonal")
        wrong = np.abs(solution.base - TRUTH)
        hits.append(wrong <= t_quantile(solution.blocks) * np.sqrt(np.diag(solution.covariance)))
    assert 0.92 <= np.mean(hits) <= 0.985


@pytest.mark.parametrize("keep", [0.5, 0.8, 0.9])
def test_correlation_time_of_first_order_noise(keep: float) -> None:
    """(1 + a) / (1 - a) rows for noise that keeps a share a of itself from row to row."""
    times = [
        correlation_rows(made(np.zeros(ROWS)), slow(keep, (ROWS, 1), np.random.default_rng(seed)))[0]
        for seed in range(60)
    ]
    assert np.mean(times) == pytest.approx((1 + keep) / (1 - keep), rel=0.15)


def test_correlation_time_of_a_long_series_is_that_of_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """Worked on in pieces, or in one."""
    series = slow(0.9, (ROWS, 1), np.random.default_rng(5)), np.sin(np.arange(ROWS) / 400)[:, None]
    whole = [correlation_rows(made(np.zeros(ROWS)), one)[0] for one in series]
    monkeypatch.setattr(uncertainty, "BLOCK", 64)  # shorter than the second series remembers
    pieces = [correlation_rows(made(np.zeros(ROWS)), one)[0] for one in series]
    assert pieces == pytest.approx(whole, rel=1e-9)


def test_blocks_do_not_cross_segments() -> None:
    segment = np.repeat([0, 1, 2], [100, 7, 55])
    labels = block_labels(segment, 20)
    assert all(len(set(segment[labels == b])) == 1 for b in np.unique(labels))
    assert (np.diff(labels) >= 0).all()


def test_few_independent_samples_are_said() -> None:
    with pytest.warns(PhysidentWarning, match="standard errors are rough"):
        least_squares(made(slow(0.995, (ROWS,), np.random.default_rng(0))), BASE, np.zeros(COLUMNS), "equal")


# --- a whole arm ---------------------------------------------------------------------------------------------------

FILTER = Filter(5.0)
SIGMA = np.array([2.0, 3.0, 1.5, 0.4, 0.5, 0.5])


@pytest.fixture(scope="module")
def estimates(ur5: pid.Robot) -> dict[str, pid.Estimate]:
    model = Model.nominal(ur5)
    friction = np.repeat([0.5, 5.0, 4.0, 0.1], 6)
    truth = Model(ur5, model.effects, np.concatenate([model.theta[:60], friction]))
    t, q, v, a = pid.random_trajectory(ur5, seed=8, duration=30.0).sample(100.0)
    motion = Signals(t, q, v, a, rate=100.0)
    noise = SIGMA * slow(0.95, q.shape, np.random.default_rng(8))
    regressor = build_regressor(ur5, model.effects, [replace(motion, torque=truth.torque(motion) + noise)], FILTER)
    methods = {
        "wls": "wls",
        "linear": Physical(resamples=0),
        "bootstrap": Physical(resamples=80, seed=1),
        "same": Physical(resamples=20, seed=1),
        "again": Physical(resamples=20, seed=1),
    }
    return {k: estimate_from(ur5, model.effects, regressor, [], m, FILTER) for k, m in methods.items()}


def test_bootstrap_and_linearised_errors_agree_inside_the_cones(estimates: dict[str, pid.Estimate]) -> None:
    linear, bootstrap = (np.sqrt(np.diag(estimates[k].covariance)) for k in ("linear", "bootstrap"))
    assert np.median(bootstrap / linear) == pytest.approx(1.0, abs=0.2)
    np.testing.assert_array_equal(estimates["same"].covariance, estimates["again"].covariance)  # the seed decides


def test_prior_narrows_what_data_leave_open(estimates: dict[str, pid.Estimate]) -> None:
    free, bound = (np.sqrt(np.diag(estimates[k].covariance)) for k in ("wls", "linear"))
    shares = np.array(estimates["linear"].base_shares)
    narrowed = bound / free
    assert np.median(narrowed[shares < 0.5]) < 0.5 < np.median(narrowed[shares > 0.99]) < 1.1


def test_intervals_widen_with_their_level(estimates: dict[str, pid.Estimate]) -> None:
    wls = estimates["wls"]
    narrow, wide = wls.intervals(0.5), wls.intervals(0.99)
    assert (wide[:, 0] < narrow[:, 0]).all()
    assert (wide[:, 1] > narrow[:, 1]).all()
    np.testing.assert_allclose(wide.mean(axis=1), wls.base.values(wls.theta))
    with pytest.raises(pid.InputError, match="level is 95"):
        wls.intervals(95)


def test_round_trip_of_a_real_arm(data: Path) -> None:
    """Torques simulated from the model identified on a real UR10e, identified again, lie in the stated intervals."""
    robot = pid.load_robot(data / "ur10e/ur10e.urdf")
    runs = pid.load_recordings(str(data / "ur10e/ur-20_02_1*.csv"), UR10E_COLUMNS, UR10E_GAINS)
    filter = Filter(5.0, 100.0)
    first = pid.identify(robot, runs, filter=filter)
    rng = np.random.default_rng(0)
    signals = []
    for run in runs:
        one = pid.prepare(run, filter)
        signals.append(replace(one, torque=first.model.torque(one) + first.sigma * slow(0.97, one.q.shape, rng)))
    regressor = build_regressor(robot, first.model.effects, signals, filter)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PhysidentWarning)
        for method in ("wls", "robust"):
            again = estimate_from(robot, first.model.effects, regressor, [], method, filter)
            ends, target = again.intervals(), first.base.values(first.theta)
            inside = (ends[:, 0] <= target) & (target <= ends[:, 1])
            assert inside.mean() >= 0.85  # 58 parameters, 95 % each, noise shared by the parameters of a joint
