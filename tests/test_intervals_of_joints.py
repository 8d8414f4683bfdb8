"""An interval of what several joints show holds where a joint errs from end to end of a recording, as blocks of time cannot tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.search.hypothesis import AcceptedEffect, Hypothesis, state_hypothesis
from physident.diagnosis.statistics.intervals import Spread, Uncertainty, WithoutJoints, uncertainty_of
from tests.exact_friction import exact_arm
from tests.opened import opened
from tests.plant import Sensors, hide, multisine, record

MASS = 0.8  # kg
GAIN = 0.03  # standard deviation of the gain of a joint's torque, which no model has


@pytest.fixture(scope="module")
def loaded(ur5: pid.Robot, healthy_runs: list[pid.Recording], tmp_path_factory: pytest.TempPathFactory) -> Hypothesis:
    path = tmp_path_factory.mktemp("loaded") / "run.csv"
    record(hide(exact_arm(), "payload", (), MASS), multisine(41), Sensors(), 41, step=2e-3).write_csv(path)
    return opened(ur5, [*healthy_runs[:2], pid.load_recording(path)])


def mass_of(loaded: Hypothesis, gains: np.ndarray) -> tuple[float, Uncertainty, np.ndarray]:
    """The mass of a payload where each joint's torque is read by its own gain (n,), with its errors; and the row of theta that it is."""
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
    exact = Spread(none[0], 12, WithoutJoints(none[:, 0], none + np.eye(2), np.eye(2)))
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
