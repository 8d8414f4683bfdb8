"""Searches on halves: what is there is found again, what chance or one stretch brought in is not, and that makes it a hint."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.grading.grades import ExpectedError, graded
from physident.diagnosis.problem.folds import blocks
from physident.diagnosis.result.assemble import make_findings
from physident.diagnosis.rivals.rivals import RivalCheck, check_rivals
from physident.diagnosis.search.candidate_scores import CandidateScores, score_candidates
from physident.diagnosis.search.forward_search import settled_hypothesis
from physident.diagnosis.search.hypothesis import AcceptedEffect, Hypothesis
from physident.diagnosis.stability import half_search, stability
from physident.diagnosis.stability.doubts import trust_in
from physident.diagnosis.stability.stability import STABLE, _as_a_curve, stability_of
from physident.diagnosis.stability.trust import Trust
from physident.diagnosis.statistics.intervals import uncertainty_of
from physident.diagnosis.statistics.product_fit import Chosen
from physident.diagnosis.statistics.stored_products import MAX_UNITS, store_products
from physident.processes import VARIABLE
from tests.opened import opened
from tests.plant import Arm

TRUE = (("coulomb_friction", (3,)), ("viscous_friction", (3,)))
CHANCE = ("friction_asymmetry", (5,))


@pytest.fixture(scope="module")
def first(ur5: pid.Robot, healthy_runs: list[pid.Recording]) -> CandidateScores:
    """Dry and viscous friction of joint 3 doubled."""
    v = healthy_runs[2].dq
    assert v is not None
    friction = Arm().friction
    more = (friction.coulomb * np.tanh(v / 0.01) + friction.viscous * v) * (np.arange(6) == 2)
    return score_candidates(opened(ur5, healthy_runs[:3], more))


@pytest.fixture(scope="module")
def last(first: CandidateScores) -> CandidateScores:
    """The two true effects are accepted, and one that is not there."""
    state = first.hypothesis
    found = {c.key: c for c in state.data.candidates}
    accepted = []
    for key in (*TRUE, CHANCE):
        effect = found[key].options[0].effect
        assert effect is not None
        accepted.append(AcceptedEffect(found[key], effect))
    return replace(first, hypothesis=settled_hypothesis(state.problem, accepted))


def checks(last: CandidateScores) -> list[RivalCheck]:
    return [RivalCheck(one, 10.0, (), threshold=last.threshold) for one in last.hypothesis.accepted]


def test_what_chance_brings_in_seldom_passes() -> None:
    """Theorem 1 of Shah and Samworth: of effects that a search finds with probability p, p / (2 STABLE - 1) times as many pass. Of what chance
    brings in once in a hundred searches, that shall be one in twenty at most."""
    assert 0.01 / (2 * STABLE - 1) <= 0.05 + 1e-12


def test_a_half_finds_what_is_there_and_little_else(last: CandidateScores) -> None:
    state = last.hypothesis
    stored = store_products(state)
    found = [
        half_search.search_half(stored, range(k, stored.units, 2), state, stability.HALF * last.threshold, {})
        for k in range(2)
    ]
    for keys in found:
        assert keys >= set(TRUE)
        assert len(keys - set(TRUE)) <= 1


def test_stored_products_are_those_of_the_rows_and_no_row_is_in_two_units(last: CandidateScores) -> None:
    state = last.hypothesis
    stored = store_products(state)
    assert 2 <= stored.units <= MAX_UNITS
    inside = blocks(state.data, float(state.fit.memory.max())) >= 0
    squares = np.arange(1.0, 7.0)
    effect, columns = stored.options[TRUE[0]][0]
    (own,) = (a for a in state.accepted if a.candidate.key == TRUE[0])
    assert effect is own.effect
    values = state.problem.columns(own.effect, state.model)
    expected = sum(
        s * float(y[inside] @ c[inside, 0]) for s, c, y in zip(squares, values, state.data.response.T, strict=True)
    )
    halves = [stored.over(range(0, stored.units, 2)), stored.over(range(1, stored.units, 2))]
    parts = [half.weighted(squares, columns, np.array([stored.response]))[0, 0] for half in halves]
    assert sum(parts) == pytest.approx(expected, rel=1e-9)
    counted = state.data.regressor.counted[inside].sum(axis=0)
    np.testing.assert_allclose(sum(half.worth for half in halves) * state.fit.memory, counted)


def test_what_is_there_is_found_in_every_half_and_what_is_not_in_few(
    first: CandidateScores, last: CandidateScores
) -> None:
    found = stability_of(first, last, checks(last))
    assert [found[key] for key in TRUE] == [1.0, 1.0]
    share = found[CHANCE]
    assert share is not None
    assert share < STABLE
    assert found == stability_of(first, last, checks(last))  # the seed decides


def test_what_earlier_rows_said_of_the_model_speaks_in_a_half_too(first: CandidateScores) -> None:
    """The model could take up doubled friction, but only against what its own recordings said of it."""
    state = first.hypothesis
    stored = store_products(state)
    half = half_search._Half(
        stored, stored.over(range(stored.units)), state, dict.fromkeys(stored.options, first.threshold)
    )
    effect, columns = stored.options[TRUE[0]][0]
    true = Chosen(TRUE[0], effect, columns)
    before, after = half.fit([]), half.fit([true])
    # the same fit from the rows themselves
    inside = blocks(state.data, float(state.fit.memory.max())) >= 0
    A, y = [np.diag(np.sqrt(before.prior))], [np.zeros(len(before.prior))]
    for j, rows in enumerate(state.baseline.joints):
        A.append(rows[inside] * before.fit.weights[j])
        y.append(state.data.response[inside, j] * before.fit.weights[j])
    x = np.linalg.lstsq(np.concatenate(A), np.concatenate(y), rcond=None)[0]
    assert before.contradicted == pytest.approx(float(before.prior @ x**2), rel=1e-6)
    seen = float(np.sum(half.products.worth * 2 * np.log(before.fit.sigma / after.fit.sigma)))
    relief, numbers = before.contradicted - after.contradicted, len(columns)
    assert abs(relief) > 0.1
    chance = half_search._chance(after, numbers)
    assert half_search._evidence(before, after, true) == pytest.approx(seen + relief - chance, abs=1e-6)
    shorter = half.length([]) - half.length([true])
    assert shorter == pytest.approx(seen + relief - chance - first.threshold, abs=1e-6)


def test_a_rival_counts_as_found(first: CandidateScores, last: CandidateScores) -> None:
    (wrong,) = (a for a in last.hypothesis.accepted if a.candidate.key == CHANCE)
    rivals = tuple(a.candidate for a in last.hypothesis.accepted if a.candidate.key == TRUE[0])
    assert stability_of(first, last, [RivalCheck(wrong, 10.0, rivals)])[CHANCE] == 1.0
    assert stability_of(first, last, [RivalCheck(wrong, 10.0, (), rivals)])[CHANCE] == 1.0
    assert stability_of(first, last, [RivalCheck(wrong, 10.0, (), (), rivals)])[CHANCE] == 1.0


def test_a_larger_law_that_contains_an_effect_is_no_rival_and_finds_it(last: CandidateScores) -> None:
    """Presliding over no distance is Coulomb friction; of powers of the velocity one is near the first; a peak near rest is neither."""
    same = {
        one.candidate.key: {c.key for c in check_rivals(last, one).larger}
        for one in last.hypothesis.accepted
        if one.candidate.key in TRUE
    }
    coulomb, viscous = (same[key] for key in TRUE)
    assert ("presliding_hysteresis", (3,)) in coulomb
    assert ("nonlinear_viscous_friction", (3,)) in viscous
    assert ("stribeck_friction", (3,)) not in coulomb | viscous


def test_halves_are_pairs_that_share_no_unit(
    first: CandidateScores, last: CandidateScores, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[set[int]] = []

    def remember(stored: object, units: np.ndarray, whole: Hypothesis, threshold: float, lower: dict) -> set:
        seen.append({*units.tolist()})
        assert len(seen[-1]) == len(units)
        assert max(threshold, *lower.values()) < last.threshold
        return set()

    monkeypatch.setenv(VARIABLE, "1")  # what another process sees is not seen here
    monkeypatch.setattr(stability, "search_half", remember)
    stability_of(first, last, checks(last))
    assert len(seen) == 20
    for one, other in zip(seen[::2], seen[1::2], strict=True):
        assert len(one) == len(other)
        assert not one & other


def test_what_few_halves_find_is_a_doubt(first: CandidateScores, last: CandidateScores) -> None:
    trust = trust_in(first, last, checks(last))
    assert [bool(trust[key].doubts) for key in (*TRUE, CHANCE)] == [False, False, True]
    assert "of 20 searches" in trust[CHANCE].doubts[0]


def test_a_doubtful_joint_is_a_hint_of_its_own(last: CandidateScores) -> None:
    """It takes nothing from the joint that is sure, though the effect is the same."""
    problem = last.hypothesis.problem
    found = {c.key: c for c in (*last.hypothesis.data.candidates, *(a.candidate for a in last.hypothesis.accepted))}
    accepted = []
    for joint in (3, 5):
        effect = found["coulomb_friction", (joint,)].options[0].effect
        assert effect is not None
        accepted.append(AcceptedEffect(found["coulomb_friction", (joint,)], effect))
    state = settled_hypothesis(problem, accepted)
    trust = {("coulomb_friction", (3,)): Trust(0.9, ()), ("coulomb_friction", (5,)): Trust(0.2, ("rarely found",))}
    own = [RivalCheck(one, 10.0, ()) for one in state.accepted]
    findings = graded(
        state,
        make_findings(state, own, uncertainty_of(state), trust=trust),
        ExpectedError(right=np.full(6, 1e-9), usual=np.full(6, 1e-9)),
    )
    assert [(f.joints, f.stability) for f in findings] == [((3,), 0.9), ((5,), 0.2)]
    assert findings[0].grade != "hint"
    assert (findings[1].grade, findings[1].doubts) == ("hint", ("rarely found",))
    (joined,) = make_findings(state, own, uncertainty_of(state))
    assert joined.joints == (3, 5)


@pytest.mark.parametrize(
    ("whole", "half", "same"),
    [
        ("learned_velocity", ("nonlinear_viscous_friction", (2,)), True),
        ("nonlinear_viscous_friction", ("learned_velocity", (2,)), True),
        ("learned_velocity", ("joint_spring", (2,)), False),
        ("learned_velocity", ("nonlinear_viscous_friction", (3,)), False),
    ],
)
def test_a_half_is_too_short_to_tell_a_curve_from_a_law_of_the_same_quantity(
    whole: str, half: tuple[str, tuple[int, ...]], same: bool
) -> None:
    """Of all recordings a curve took the place of a law, which most halves find; the joint has what bends its friction in all of them."""
    assert _as_a_curve([whole], (2,), {half}) == same
