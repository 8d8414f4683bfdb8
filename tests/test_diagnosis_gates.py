"""Every gate of the search keeps something out: each test fails where its gate is loosened."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.problem.search_data import OUTSIDE
from physident.diagnosis.search import acceptance, forward_search
from physident.diagnosis.search.acceptance import choose_candidate, contact_accepted, contradiction
from physident.diagnosis.search.candidate_scores import (
    CandidateScores,
    contact_thresholds,
    score_candidates,
    surrogate_responses,
)
from physident.diagnosis.search.contact_scan import most_without_the_strongest, scan_contacts
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.left_out_gains import left_out_gains
from physident.diagnosis.statistics.left_out_residuals import reduction_percent
from physident.diagnosis.statistics.thresholds import MIN_REDUCTION_PERCENT
from physident.dynamics.regressor import build_regressor
from physident.effects.catalogue import make_effects
from physident.estimation.identify import prepare_all
from physident.identifiability.visibility import VISIBLE
from physident.recordings.white_noise import white_noise
from tests.opened import opened
from tests.plant import Arm, Sensors


@pytest.fixture(scope="module")
def healthy(ur5: pid.Robot, healthy_runs: list[pid.Recording]) -> Hypothesis:
    return opened(ur5, healthy_runs)


@pytest.fixture(scope="module")
def seen(healthy: Hypothesis) -> CandidateScores:
    least, least_without = contact_thresholds(healthy)
    scores = score_candidates(healthy)
    return replace(scores, contact_threshold=least, contact_threshold_without_best_joint=least_without)


def test_fresh_noise_beats_the_thresholds_as_rarely_as_they_say(healthy: Hypothesis, seen: CandidateScores) -> None:
    fresh = replace(healthy, problem=replace(healthy.problem, seed=1))
    responses = surrogate_responses(fresh)
    luckiest = (
        left_out_gains(fresh.data, fresh.baseline, fresh.fit, responses)
        .evidence_without_best_fold[seen.visible_share >= VISIBLE]
        .max(axis=0)
    )
    assert np.mean(luckiest > seen.threshold) < 0.04
    assert np.mean(scan_contacts(fresh, responses).evidence > seen.contact_threshold) < 0.04


def test_a_gain_of_no_use_is_not_named_however_sure(healthy: Hypothesis, seen: CandidateScores) -> None:
    certain = replace(seen, threshold=-np.inf, visible_share=np.ones_like(seen.visible_share))
    placebos = [c.placebo for c in healthy.data.candidates]
    assert choose_candidate(replace(certain, gain=np.where(placebos, -np.inf, certain.gain))) is None


def test_a_gain_that_one_block_makes_is_not_named(healthy: Hypothesis, monkeypatch: pytest.MonkeyPatch) -> None:
    candidate = healthy.data.candidates[0]
    before = np.ones((16, 6))
    after = 1.02 * before
    after[3] = 0.0

    def costs(state: Hypothesis, one: object, weights: object = None) -> np.ndarray:
        return before if one is None else after

    monkeypatch.setattr(acceptance, "left_out_costs", costs)
    assert reduction_percent(before.sum(axis=0), after.sum(axis=0)) > MIN_REDUCTION_PERCENT
    assert not acceptance.is_useful(healthy, candidate)


@pytest.mark.parametrize(("gain", "least", "share"), [(90.0, 5.0, 0.5), (90.0, 80.0, 1e-5)])
def test_one_fold_is_not_enough_and_what_the_baseline_can_imitate_is_nothing(
    seen: CandidateScores, gain: float, least: float, share: float
) -> None:
    given = np.full_like(seen.gain, gain), np.full_like(seen.evidence_without_best_fold, least)
    one = replace(
        seen,
        gain=given[0],
        evidence_without_best_fold=given[1],
        visible_share=np.full_like(seen.visible_share, share),
        threshold=20.0,
    )
    assert not one.beats_chance(0)
    assert replace(
        one, evidence_without_best_fold=one.gain, visible_share=np.ones_like(one.visible_share)
    ).beats_chance(0)


@pytest.mark.parametrize(("found", "few"), [((1, 2, 4, 6), True), ((1, 2, 4), False), ((), False)])
def test_where_most_joints_have_an_effect_only_the_others_can_be_lucky(
    seen: CandidateScores, found: tuple[int, ...], few: bool
) -> None:
    name, draws = "nonlinear_viscous_friction", np.linspace(0.0, 1.0, 101)
    candidates = {c.key: c for c in seen.hypothesis.data.candidates if c.name == name}
    scores = replace(seen, chance={key: 10.0 * key[1][0] + draws for key in candidates}, threshold=80.0)
    accepted = [AcceptedEffect(candidates[name, (j,)], make_effects(name)[0]) for j in found]
    # of joints 3 and 5, the fifth is the luckier one on every draw
    assert scores.threshold_of((name, (3,)), accepted) == pytest.approx(50.99 if few else 80.0)
    assert replace(scores, threshold=20.0).threshold_of((name, (3,)), accepted) == 20.0
    assert scores.threshold_of(("payload", ()), accepted) == 80.0


def test_friction_that_would_drive_its_joint_is_not_named(ur5: pid.Robot, healthy_runs: list[pid.Recording]) -> None:
    v = healthy_runs[2].dq
    assert v is not None
    driven = opened(ur5, healthy_runs[:3], -3 * Arm().friction.coulomb * np.tanh(v / 0.01) * (np.arange(6) == 4))
    (coulomb,) = (c for c in driven.data.candidates if c.key == ("coulomb_friction", (5,)))
    assert "drive" in str(contradiction(driven, coulomb))
    assert ("coulomb_friction", (5,)) not in {
        c.candidate.key for c in forward_search.search_effects(driven.problem).accepted
    }


def test_a_contact_too_small_to_matter_is_not_named(seen: CandidateScores) -> None:
    for reduction, felt, expected in ((10.0, 10.0, True), (1.0, 10.0, False), (10.0, 1.0, False)):
        strong = pressed(seen, 1e3, 1e3)
        found = replace(strong.contact, reduction=reduction, joint_reduction=felt)
        assert contact_accepted(replace(strong, contact=found), None) is expected


def test_a_contact_must_beat_its_own_surrogates_and_every_other_candidate(seen: CandidateScores) -> None:
    for evidence, rival, expected in ((1.1, None, True), (0.9, None, False), (1.1, 1.2, False), (1.1, 1.0, True)):
        found = pressed(seen, evidence * seen.contact_threshold, 1e3)
        assert contact_accepted(found, rival and rival * seen.contact_threshold) is expected


def test_what_one_joint_alone_says_is_no_contact(seen: CandidateScores) -> None:
    for least, expected in ((1.1, True), (0.9, False)):
        assert contact_accepted(pressed(seen, 1e3, least * seen.contact_threshold_without_best_joint), None) is expected


def test_a_contact_ends_before_what_one_joint_alone_makes_much_of() -> None:
    """Else the run of the largest sum is refused for one joint's sake, and the push within it with it."""
    gain = np.full((12, 3, 1), -1.0)
    gain[4:6, :, 0] = 2.0
    gain[6, 0, 0] = 50.0
    first, last, found = most_without_the_strongest(gain)
    assert (first[0], last[0]) == (4, 6)
    np.testing.assert_allclose(found[:, 0], 4.0)


def test_a_contact_that_two_joints_feel_in_turn_is_one() -> None:
    """Neither run that leaves out one joint of the two is the best."""
    gain = np.full((12, 3, 1), -1.0)
    gain[3:6, :, 0] = [[10.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 10.0, 0.0]]
    first, last, _ = most_without_the_strongest(gain)
    assert (first[0], last[0]) == (3, 6)


def test_the_best_run_is_the_best_of_all_runs() -> None:
    random = np.random.default_rng(3)
    gain = random.normal(size=(40, 4, 25))
    first, last, found = most_without_the_strongest(gain)
    for s in range(25):
        runs = [gain[i : i + k, :, s].sum(axis=0) for k in range(1, 21) for i in range(41 - k)]
        best = max(run.sum() - run.max() for run in runs)
        np.testing.assert_allclose(found[:, s].sum() - found[:, s].max(), best)
        np.testing.assert_allclose(found[:, s], gain[first[s] : last[s], :, s].sum(axis=0))


def pressed(seen: CandidateScores, evidence: float, least: float) -> CandidateScores:
    """A look whose contact has some evidence, less of it without the joint that speaks most, and is large enough."""
    S = seen.contact.evidence.shape
    found = replace(
        seen.contact,
        evidence=np.full(S, evidence),
        evidence_without_best_joint=np.full(S, least),
        reduction=10.0,
        joint_reduction=10.0,
    )
    return replace(seen, contact=found)


def test_surrogates_know_a_healthy_model_no_better_than_it_was_identified(healthy: Hypothesis) -> None:
    """What an uncertain parameter does to the torque is no effect: surrogates hold as much of it as its covariance says."""
    vague = 1e4  # as many times the variance: then it is nearly all that surrogates hold
    prior = healthy.baseline.prior / vague
    state = replace(healthy, baseline=replace(healthy.baseline, prior=prior))
    known = healthy.problem.freedom.prior > 0
    counted = healthy.data.regressor.counted
    expected = np.array(
        [
            np.sum((B[:, known] * seen[:, None]) ** 2 / prior[known])
            for B, seen in zip(state.baseline.joints, counted.T, strict=True)
        ]
    )
    held = np.mean(np.sum(surrogate_responses(state) ** 2, axis=0), axis=1)
    np.testing.assert_allclose(held, expected, rtol=0.3)


def test_rows_at_reversals_weigh_what_the_noise_of_velocity_leaves_them(healthy: Hypothesis) -> None:
    signals = healthy.problem.signals[0]
    assert (white_noise(signals.v) < 0.5 * Sensors().velocity_noise).all()  # smoothed
    regressor, weights = healthy.data.regressor, healthy.problem.weights
    rows = (regressor.recording == 0) & (healthy.data.fold != OUTSIDE)
    at = np.searchsorted(signals.time, regressor.time[rows])
    for j in range(6):
        slow = np.abs(signals.v[at, j]) < 0.01
        if slow.any():
            assert weights[rows, j][slow].mean() < 0.8 * weights[rows, j][np.abs(signals.v[at, j]) > 0.3].mean()
    # what is left has one size, near reversals and away from them
    slow = np.abs(signals.v[at]) < 0.05
    left = healthy.fit.residual[rows]
    assert np.std(left[slow] / np.broadcast_to(healthy.fit.sigma, left.shape)[slow]) < 1.5


def test_columns_of_another_model_are_zero_where_no_row_counts(
    ur5: pid.Robot, healthy_runs: list[pid.Recording]
) -> None:
    """A row that counts for another set of effects, and not here, has no torque here: a column there would ask for none."""
    signals = prepare_all(ur5, healthy_runs[:1], pid.Filter(5.0))
    regressor = build_regressor(ur5, make_effects(["rigid_body", "viscous_friction"]), signals, pid.Filter(5.0))
    counted = regressor.counted.copy()
    counted[10:40, 2] = False
    fewer = replace(regressor, counted=counted)
    again = fewer.with_columns(regressor, np.arange(len(regressor.columns)))
    for j, (rows, before) in enumerate(zip(again.joints, regressor.joints, strict=True)):
        assert not rows.values[~counted[:, j]].any()
        np.testing.assert_array_equal(rows.values[counted[:, j]], before.values[counted[:, j]])


def test_of_two_that_explain_as_much_the_one_of_fewer_numbers_is_taken(
    ur5: pid.Robot, healthy_runs: list[pid.Recording]
) -> None:
    """More dry friction of joint 3: friction that fades as the arm warms up holds it, too, and may win by chance."""
    v = healthy_runs[2].dq
    assert v is not None
    scores = score_candidates(opened(ur5, healthy_runs[:3], 2.0 * np.tanh(v / 0.01) * (np.arange(6) == 2)))
    keys = [c.key for c in scores.hypothesis.data.candidates]
    larger, true = keys.index(("warm_up", (3,))), keys.index(("coulomb_friction", (3,)))
    gain = scores.gain.copy()
    gain[larger] = gain.max() + 1.0
    assert choose_candidate(replace(scores, gain=gain)) == true
