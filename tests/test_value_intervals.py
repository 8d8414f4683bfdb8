"""The interval of a value holds where a joint, or a recording, errs from its one end to the other, as blocks of time cannot tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.search.hypothesis import AcceptedEffect, Hypothesis, state_hypothesis
from physident.diagnosis.statistics.intervals import Spread, Uncertainty, WithoutEach, uncertainty_of
from tests.exact_friction import exact_arm
from tests.opened import opened
from tests.plant import Sensors, hide, multisine, record

pytestmark = pytest.mark.slow

MASS = 0.8  # kg
GAIN = 0.03  # standard deviation of the gain of a joint's torque, or of a recording's, which no model has
SEEDS = (41, 43, 45)


@pytest.fixture(scope="module")
def loaded(ur5: pid.Robot, healthy_runs: list[pid.Recording], tmp_path_factory: pytest.TempPathFactory) -> Hypothesis:
    folder = tmp_path_factory.mktemp("loaded")
    for seed in SEEDS:
        arm = hide(exact_arm(), "payload", (), MASS)
        record(arm, multisine(seed), Sensors(), seed, step=2e-3).write_csv(folder / f"{seed}.csv")
    return opened(ur5, [*healthy_runs[:2], *(pid.load_recording(folder / f"{seed}.csv") for seed in SEEDS)])


def mass_of(loaded: Hypothesis, gains: np.ndarray) -> tuple[float, Uncertainty, np.ndarray]:
    """The mass of a payload where torques are read by their own ``gains``, (n,) or (M, n), with its errors; and the row of theta that it is."""
    regressor = replace(loaded.problem.regressor, torque=loaded.problem.regressor.torque * gains)
    problem = replace(loaded.problem, regressor=regressor, evaluated={}, by_model=[])
    (payload,) = (c for c in problem.candidates if c.name == "payload")
    effect = payload.options[0].effect
    assert effect is not None
    found = state_hypothesis(problem, [AcceptedEffect(payload, effect)], problem.model)
    row = np.zeros((1, len(found.extension.model.theta)))
    row[0, found.extension.places[0][0]] = 1.0
    return float(found.effect_values[0][0]), uncertainty_of(found), row


def test_what_nothing_moves_is_known() -> None:
    """As of exact recordings: an interval without width, and no number that is none."""
    none = np.zeros((3, 2, 2))
    without = WithoutEach(none[:, 0], none + np.eye(2), np.eye(2))
    exact = Spread(none[0], 12, without, without)
    np.testing.assert_array_equal(exact.reach(np.eye(2), several=True), 0.0)


def test_the_mass_lies_in_its_interval_where_joints_disagree(loaded: Hypothesis) -> None:
    rng, held, by_time = np.random.default_rng(5), [], []
    for _ in range(60):
        mass, errors, row = mass_of(loaded, 1 + GAIN * rng.standard_normal(6))
        alone = errors.theta.reach(row, several=False).item()
        held.append(abs(mass - MASS) <= errors.theta.reach(row, several=True).item())
        by_time.append(abs(mass - MASS) <= alone)
    assert np.mean(by_time) < 0.6  # what blocks of time alone would promise
    assert np.mean(held) > 0.8


def test_the_mass_lies_in_its_interval_where_recordings_disagree(loaded: Hypothesis) -> None:
    """Each recording by a gain of its own, as on other days: three of them say by how much such recordings differ."""
    rng, held, one_day = np.random.default_rng(6), [], []
    recording = loaded.problem.regressor.recording
    for _ in range(60):
        gains = 1 + GAIN * rng.standard_normal(len(SEEDS))
        mass, errors, row = mass_of(loaded, gains[recording][:, None])
        spread = errors.theta
        held.append(abs(mass - MASS) <= spread.reach(row, several=True).item())
        together = replace(spread, recordings=replace(spread.recordings, moved=0 * spread.recordings.moved))
        one_day.append(abs(mass - MASS) <= together.reach(row, several=True).item())
    assert np.mean(one_day) < 0.75  # what blocks of time and joints alone would promise
    assert np.mean(held) > 0.85
