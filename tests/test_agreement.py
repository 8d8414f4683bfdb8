"""A model's parameters are known no better than its own recordings agree on them, and no worse than they need to be."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.grading.agreement import as_recordings_agree, theta_without_each
from physident.diagnosis.problem.problem import state_problem
from physident.diagnosis.problem.question import known_covariance
from physident.dynamics.regressor import build_regressor
from physident.estimation.identify import prepare_all
from physident.estimation.results.predictions import predictions_of
from tests.serial_arms import ARMS, swinging, urdf
from tests.test_diagnosis_completed import stored

pytestmark = pytest.mark.slow

WANDERING = 2  # the joint, from 1, whose dry friction is another one in each recording
STEPS = (2.0, -1.0, -2.0, 1.0)  # N m


def errors(estimate: pid.Estimate, runs: list[pid.Recording]) -> dict[str, float]:
    """Standard errors that a diagnosis trusts, by the names of base parameters."""
    signals = prepare_all(estimate.model.robot, runs, estimate.filter)
    rows = build_regressor(estimate.model.robot, estimate.model.effects, signals, estimate.filter)
    names = [estimate.base.columns[i].name for i in estimate.base.independent]
    return dict(zip(names, np.sqrt(np.diag(known_covariance(estimate, rows))), strict=True))


@pytest.fixture(scope="module")
def trusted(ur5: pid.Robot, healthy_runs: list[pid.Recording]) -> tuple[dict[str, float], ...]:
    """Standard errors as identified, and as the recordings agree: of a healthy arm, and of one whose friction wanders."""
    found = []
    for steps in ((0.0,) * 4, STEPS):
        runs = [_with_friction(run, step) for run, step in zip(healthy_runs, steps, strict=True)]
        estimate = pid.identify(ur5, runs)
        agreed = as_recordings_agree(estimate, prepare_all(ur5, runs, estimate.filter))
        found += [errors(estimate, runs), errors(agreed, runs)]
    return tuple(found)


def test_recordings_that_agree_leave_the_errors_as_they_are(trusted: tuple[dict[str, float], ...]) -> None:
    before, after, _, _ = trusted
    ratio = np.array([after[name] / before[name] for name in before])
    assert (ratio >= 1 - 1e-9).all()
    assert np.median(ratio) < 1.3


def test_friction_that_wanders_is_known_as_well_as_a_mean_of_its_values(trusted: tuple[dict[str, float], ...]) -> None:
    """Of four values that scatter by 1.8 N m, the mean is known to 0.9 N m; blocks of rows alone claim a third of that."""
    _, _, before, after = trusted
    name = f"coulomb_friction_{WANDERING}"
    expected = np.std(STEPS, ddof=1) / np.sqrt(len(STEPS))
    assert before[name] < 0.5 * expected
    assert after[name] == pytest.approx(expected, rel=0.5)


def test_other_joints_are_known_as_well_as_before(trusted: tuple[dict[str, float], ...]) -> None:
    _, _, before, after = trusted
    for joint in (4, 5, 6):
        name = f"viscous_friction_{joint}"
        assert after[name] < 1.5 * before[name]


def test_what_is_different_is_asked_with_these_errors(
    ur5: pid.Robot, healthy_runs: list[pid.Recording], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = [
        stored(_with_friction(run, step), tmp_path / f"{step}.csv")
        for run, step in zip(healthy_runs, STEPS, strict=False)
    ][:2]
    asked: list[pid.Estimate] = []

    def state(question: str, given: pid.Estimate, *more: Any) -> Any:
        if question == "different":
            asked.append(given)
        return state_problem(question, given, *more)  # pyright: ignore[reportArgumentType]

    monkeypatch.setattr("physident.diagnosis.asked.state_problem", state)
    estimate = pid.identify(ur5, before)
    pid.diagnose(estimate, healthy_runs[2:3])
    name = f"coulomb_friction_{WANDERING}"
    assert errors(asked[0], before)[name] > 1.5 * errors(estimate, before)[name]


def _with_friction(run: pid.Recording, by: float) -> pid.Recording:
    assert run.dq is not None
    moving = np.sign(run.dq[:, WANDERING - 1]) * np.minimum(np.abs(run.dq[:, WANDERING - 1]) / 0.03, 1.0)
    effort = run.effort.copy()
    effort[:, WANDERING - 1] += by * moving
    return replace(run, effort=effort)


def test_one_recording_has_nothing_to_agree_with(
    healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording]
) -> None:
    signals = prepare_all(healthy_estimate.model.robot, healthy_runs[:1], healthy_estimate.filter)
    assert as_recordings_agree(healthy_estimate, signals) is healthy_estimate


def test_a_curve_is_held_where_only_the_recording_that_is_left_out_has_been(tmp_path: Path) -> None:
    """Without it the curve's prior alone speaks there, as in a fit of the other recordings; without the prior, the error is three times that."""
    (tmp_path / "two.urdf").write_text(urdf(ARMS["two"]))
    robot = pid.load_robot(tmp_path / "two.urdf")
    runs = [with_cable(number, reach) for number, reach in ((1, 0.6), (2, 0.6), (3, 1.0))]
    effects = ["rigid_body", "viscous_friction", "torque_offset", "learned_position"]
    whole = pid.identify(robot, runs, effects=effects)
    signals = prepare_all(robot, runs, whole.filter)
    others = pid.identify(robot, runs[:2], effects=whole.model.effects)
    model = pid.Model(robot, whole.model.effects, theta_without_each(whole, signals)[2])
    left_out, fitted = (predictions_of(one, signals[2:], whole.filter).rms for one in (model, others.model))
    np.testing.assert_allclose(left_out, fitted, rtol=0.1)


def with_cable(number: int, reach: float) -> pid.Recording:
    """Twenty seconds of two joints, by pinocchio, whose cable stiffens, within a part ``reach`` of their range."""
    rng, time = np.random.default_rng(number), np.arange(0.0, 20.0, 0.004)
    q, v, tau = swinging(rng, time, ARMS["two"], 0.3 * reach, (0.5, 4.0))
    tau += 2.0 * v + 3.0 * q**3 + 0.05 * rng.standard_normal(tau.shape)
    return pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=str(number))
