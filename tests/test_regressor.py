"""The filtered regressor against the plain way, and properties that splitting, weighing and compressing must keep."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

import physident as pid
from physident.effects.catalogue import DEFAULT_EFFECTS

RATE = 125.0


def _signals(robot: pid.Robot, seed: int = 0, seconds: float = 20.0, noise: float = 0.0) -> pid.Signals:
    time, q, v, a = pid.random_trajectory(robot, seed=seed, duration=seconds, base_frequency=1 / seconds).sample(RATE)
    model = _truth(robot)
    torque = model.torque(pid.Signals.of_states(q, v, a))
    torque = torque + noise * np.random.default_rng(seed).normal(size=torque.shape)
    return pid.Signals(time, q, v, a, torque, rate=RATE, source="made")


def _truth(robot: pid.Robot) -> pid.Model:
    model = pid.Model.nominal(robot)
    rng = np.random.default_rng(7)
    theta = model.theta.copy()
    theta[60:] = rng.uniform(0.5, 2.0, size=24)
    return pid.Model(robot, model.effects, theta)


def test_equals_the_plain_way(ur5: pid.Robot) -> None:
    filter, effects, s = pid.Filter(5.0), pid.make_effects(DEFAULT_EFFECTS), _signals(ur5)
    regressor = pid.build_regressor(ur5, effects, [s], filter, moving_only=False)
    dense = np.concatenate([e.regressor(ur5, s) for e in effects], axis=2)
    taps, D = filter.taps(RATE), filter.decimation(RATE)
    plain = lfilter(taps, 1.0, dense, axis=0)[len(taps) - 1 :][::D]
    np.testing.assert_allclose(regressor.Y, plain, atol=1e-9)
    assert s.torque is not None
    np.testing.assert_allclose(regressor.torque, lfilter(taps, 1.0, s.torque, axis=0)[len(taps) - 1 :][::D], atol=1e-9)
    np.testing.assert_allclose(regressor.time, s.time[(len(taps) - 1) // 2 :][::D][: len(regressor.time)], atol=1e-12)


def test_truth_predicts_the_torque(ur5: pid.Robot) -> None:
    s = _signals(ur5)
    regressor = pid.build_regressor(ur5, _truth(ur5).effects, [s], pid.Filter(5.0))
    np.testing.assert_allclose(regressor.predict(_truth(ur5).theta), regressor.torque, atol=1e-9)


def test_base_parameters_are_recovered_without_noise(ur5: pid.Robot) -> None:
    truth = _truth(ur5)
    signals = [_signals(ur5, seed) for seed in (1, 2, 3)]
    regressor = pid.build_regressor(ur5, truth.effects, signals, pid.Filter(5.0))
    base = pid.find_base_parameters(ur5, truth.effects)
    R, z, rest = regressor.compressed(np.ones(6))
    found = np.linalg.lstsq(R[:, base.independent], z, rcond=None)[0]
    want = base.values(truth.theta)
    assert np.abs(found - want).max() <= 1e-8 * np.abs(want).max()
    assert rest < 1e-12 * (z @ z)


def test_compression_keeps_every_cost(ur5: pid.Robot) -> None:
    regressor = pid.build_regressor(ur5, _truth(ur5).effects, [_signals(ur5, noise=1.0)], pid.Filter(5.0))
    rng = np.random.default_rng(5)
    weights = rng.uniform(0.1, 3.0, size=6)
    R, z, rest = regressor.compressed(weights)
    for _ in range(3):
        theta = rng.normal(size=84)
        tall = weights * (regressor.torque - regressor.predict(theta))
        assert np.sum((R @ theta - z) ** 2) + rest == pytest.approx(np.sum(tall**2), rel=1e-10)


def test_splitting_a_recording_into_segments_changes_no_row(ur5: pid.Robot) -> None:
    """A recording cut in two with an overlap of one filter length gives the same rows as the whole."""
    filter, effects, s = pid.Filter(5.0), _truth(ur5).effects, _signals(ur5)
    whole = pid.build_regressor(ur5, effects, [s], filter, moving_only=False)
    D, length = filter.decimation(RATE), len(filter.taps(RATE))
    cut = D * 100
    parts = [s.part(slice(0, cut + length - D)), s.part(slice(cut, len(s.time)))]
    split = pid.build_regressor(ur5, effects, parts, filter, moving_only=False)
    np.testing.assert_allclose(split.Y, whole.Y, atol=1e-12)
    assert set(split.recording) == {0, 1}


def test_rows_keep_to_the_moving_part(ur5: pid.Robot) -> None:
    filter, effects = pid.Filter(5.0), _truth(ur5).effects
    s = _signals(ur5)
    assert s.torque is not None
    still = int(4 * RATE)
    rest = np.zeros((still, 6))

    def padded(x: np.ndarray, ends: bool) -> np.ndarray:
        return np.concatenate([rest + (x[0] if ends else 0), x, rest + (x[-1] if ends else 0)])

    time = np.arange(len(s.time) + 2 * still) / RATE
    standing = pid.Signals(
        time, padded(s.q, True), padded(s.v, False), padded(s.a, False), padded(s.torque, True), rate=RATE
    )
    regressor = pid.build_regressor(ur5, effects, [standing], filter)
    half = filter.delay(RATE) * filter.decimation(RATE) / RATE
    start, stop = standing.moving or (np.nan, np.nan)
    assert start > 3.5
    assert regressor.time[0] - half >= start - 1e-6
    assert regressor.time[-1] + half <= stop + 1e-6


def test_a_robot_with_other_joints_is_refused(ur5: pid.Robot) -> None:
    q = np.zeros((500, 3))
    signals = pid.Signals(np.arange(500) / RATE, q, q, q, q, rate=RATE, source="three.csv")
    with pytest.raises(pid.InputError, match=r"three\.csv: 3 joints, but robot ur5 has 6"):
        pid.build_regressor(ur5, pid.make_effects(["rigid_body"]), [signals], pid.Filter())


def test_hysteresis_restarts_after_a_gap_and_its_first_travel_does_not_count(ur5: pid.Robot) -> None:
    """Rows of a joint after a gap are zero on both sides until it has travelled three presliding distances; before any
    gap, and for other joints' effects, every row counts."""
    s, filter = _signals(ur5), pid.Filter(5.0)
    assert s.torque is not None
    half = len(s.time) // 2
    cut = pid.Signals(s.time, s.q, s.v, s.a, s.torque, starts=(0, half), rate=RATE, source="made")
    effect = pid.CATALOGUE["presliding_hysteresis"](joints=(2,), distance=(0.05,))
    effects = (*_truth(ur5).effects, effect)
    regressor = pid.build_regressor(ur5, effects, [cut], filter)
    after = regressor.segment == 1
    lost = ~regressor.counted
    assert not lost[~after].any()
    assert not np.delete(lost, 1, axis=1).any()
    assert lost[after, 1].any()
    travel = np.cumsum(np.abs(s.v[half:, 1])) / RATE
    settled = s.time[half:][np.searchsorted(travel, 0.15)]
    window = filter.delay(RATE) * filter.decimation(RATE) / RATE
    np.testing.assert_array_equal(lost[:, 1], after & (regressor.time - window < settled - 1e-9))
    assert np.abs(regressor.torque[lost]).max() == 0
    assert np.abs(regressor.joints[1].values[lost[:, 1]]).max() == 0
    restarted = effect.values(ur5, cut.part(cut.segments[1]))
    assert restarted[0, 0] == 0
