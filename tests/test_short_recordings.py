"""Motions of any length from a tenth of a second to five seconds: an answer, or one line that names the recording."""

from __future__ import annotations

import warnings

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import physident as pid
from physident.recordings.channels import Channels
from physident.recordings.recording import recording_from_rows
from tests.test_identify import COULOMB, VISCOUS, _recording

RATE = 125.0
REST = 2.0  # s before and after the motion


def brief(robot: pid.Robot, length: float) -> pid.Recording:
    """An arm that rests, moves for ``length`` seconds, and rests."""
    _, q, v, a = pid.random_trajectory(robot, seed=5, duration=length, base_frequency=1 / length).sample(RATE)
    rest = int(REST * RATE)
    q = np.pad(q, ((rest, rest), (0, 0)), mode="edge")
    v, a = (np.pad(x, ((rest, rest), (0, 0))) for x in (v, a))
    data = robot.pinocchio.createData()
    torque = np.array([pin.rnea(robot.pinocchio, data, *s).copy() for s in zip(q, v, a, strict=True)])
    torque += COULOMB * np.tanh(v / 0.01) + VISCOUS * v + 0.2 * np.random.default_rng(5).standard_normal(q.shape)
    time = np.arange(len(q)) / RATE
    return recording_from_rows(
        Channels(time=time, q=q, effort=torque, effort_kind="torque", dq=v), f"brief_{length:.2f}"
    )


@pytest.fixture(scope="module")
def estimate(ur5: pid.Robot) -> pid.Estimate:
    return pid.identify(ur5, [_recording(ur5, seed, 0.2) for seed in (1, 2)])


@pytest.fixture(scope="module")
def good(ur5: pid.Robot) -> pid.Recording:
    return _recording(ur5, 3, 0.2)


@settings(
    max_examples=10,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(length=st.floats(0.1, 5.0))
@pytest.mark.slow
def test_any_length_is_judged_or_refused_by_name(
    length: float, ur5: pid.Robot, estimate: pid.Estimate, good: pid.Recording
) -> None:
    recording = brief(ur5, length)
    for ask in (
        lambda: pid.diagnose(estimate, [recording]),
        lambda: pid.diagnose(estimate, [good, recording]),
        lambda: pid.identify(ur5, [recording]),
        lambda: pid.identify(ur5, [good, recording]),
        lambda: pid.validate(estimate, [recording]),
    ):
        said = recording.source
        with warnings.catch_warnings(action="ignore", category=pid.PhysidentWarning):
            try:
                ask()
            except pid.InputError as error:
                said = str(error)
        assert recording.source in said or "in any recording" in said  # of a joint that does not move
        assert len(said.splitlines()) == 1


@pytest.mark.parametrize("length", [0.3, 0.85, 0.9, 1.0])
def test_a_recording_too_short_is_refused_before_the_search(
    length: float, ur5: pid.Robot, estimate: pid.Estimate, monkeypatch: pytest.MonkeyPatch
) -> None:
    def search(*_: object) -> None:
        raise AssertionError("the search began")

    monkeypatch.setattr("physident.diagnosis.searched.search_and_learn", search)
    with pytest.raises(pid.InputError, match="left after the filter"):
        pid.diagnose(estimate, [brief(ur5, length)])
