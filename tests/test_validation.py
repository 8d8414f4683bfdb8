"""Scores: their definition, and that a model cannot be judged on what it was fitted to."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.recordings.channels import Channels
from physident.recordings.recording import recording_from_rows
from tests.serial_arms import ARMS, urdf
from tests.test_identify import _recording
from tests.test_turning_speeds import slipping


@pytest.fixture(scope="module")
def estimate(ur5: pid.Robot) -> pid.Estimate:
    return pid.identify(ur5, [_recording(ur5, 1, 0.3)])


def test_relative_error_is_what_it_says(ur5: pid.Robot, estimate: pid.Estimate) -> None:
    """A measured torque of (1 + k) times the prediction has the error k / (1 + k), whatever the filter."""
    run = _recording(ur5, 2)
    assert run.dq is not None
    signals = pid.prepare(run, estimate.filter)
    torque = 1.25 * estimate.model.torque(signals)
    scaled = recording_from_rows(
        Channels(time=signals.time, q=signals.q, effort=torque, effort_kind="torque", dq=signals.v), "scaled"
    )
    score = pid.validate(estimate, [scaled])
    np.testing.assert_allclose(score.relative, 20.0, atol=0.05)
    assert 0.5 < score.share <= 1.0


def test_mean_over_recordings_not_over_samples(ur5: pid.Robot, estimate: pid.Estimate) -> None:
    two = [_recording(ur5, 2, 1.0), _recording(ur5, 3, 0.0)]
    both = pid.validate(estimate, two)
    single = np.array([pid.validate(estimate, [run]).relative for run in two])
    np.testing.assert_allclose(both.relative, single.mean(axis=0), rtol=1e-9)
    single_all = np.array([pid.validate(estimate, [run]).relative_all for run in two])
    np.testing.assert_allclose(both.each, single_all, rtol=1e-9)


def test_fitted_recordings_are_refused_even_renamed(ur5: pid.Robot, estimate: pid.Estimate) -> None:
    again = _recording(ur5, 1, 0.3)
    renamed = pid.Recording(again.time, again.q, again.effort, "torque", again.dq, source="other name")
    with pytest.raises(pid.InputError, match="training recording of this model"):
        pid.validate(estimate, [renamed])
    assert pid.validate(estimate, [renamed], include_fitted=True).rms.shape == (6,)


def test_gain_of_the_better_model(ur5: pid.Robot, estimate: pid.Estimate) -> None:
    plain = pid.identify(ur5, [_recording(ur5, 1, 0.3)], effects=["rigid_body"])
    gain = pid.compare(plain, estimate, on=[_recording(ur5, 2)])
    assert (gain.reduction > 50).all()
    np.testing.assert_allclose(gain.reduction, 100 * (1 - gain.after.rms / gain.before.rms))
    assert "better" in repr(gain)
    same = pid.compare(estimate, estimate, on=[_recording(ur5, 2)])
    assert "as good as" in repr(same)


def test_models_with_other_filters_are_not_compared(ur5: pid.Robot, estimate: pid.Estimate) -> None:
    other = pid.identify(ur5, [_recording(ur5, 1, 0.3)], filter=pid.Filter(3.0))
    with pytest.raises(pid.InputError, match="expected one filter"):
        pid.compare(estimate, other, on=[_recording(ur5, 2)])


def test_identify_says_what_validate_says_of_the_same_recordings(tmp_path: Path) -> None:
    """Rows near a reversal, where the sign of friction is uncertain, count for less in the fit; the error is of all rows."""
    (tmp_path / "two.urdf").write_text(urdf(ARMS["two"]))
    runs = [slipping(seed) for seed in (1, 2)]
    estimate = pid.identify(tmp_path / "two.urdf", runs)
    score = pid.validate(estimate, runs, include_fitted=True)
    np.testing.assert_allclose(estimate.relative, score.relative_all, rtol=1e-6)
    assert score.rms[0] > 1.5 * estimate.sigma[0]  # friction that builds up errs most where its sign is uncertain
