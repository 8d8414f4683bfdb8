"""Rivals are those that the data cannot tell apart, no others; and what others make superfluous is removed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.problem.candidates import Candidate
from physident.diagnosis.problem.problem import state_problem
from physident.diagnosis.problem.question import choose_question
from physident.diagnosis.result.values import _shapes
from physident.diagnosis.rivals.rivals import check_rivals
from physident.diagnosis.rivals.same_torque import Span
from physident.diagnosis.search import acceptance, forward_search
from physident.diagnosis.search.acceptance import choose_candidate
from physident.diagnosis.search.candidate_scores import score_candidates
from physident.diagnosis.search.forward_search import settled_hypothesis
from physident.diagnosis.search.hypothesis import AcceptedEffect, Hypothesis
from physident.diagnosis.search.shape_refinement import refine_shape
from physident.diagnosis.statistics.intervals import uncertainty_of
from physident.diagnosis.statistics.left_out_gains import left_out_gains
from physident.estimation.identify import prepare_all
from physident.identifiability.visibility import VISIBLE
from tests.opened import opened
from tests.plant import Arm

JOINT = 3


@pytest.fixture(scope="module")
def rubbing(ur5: pid.Robot, healthy_runs: list[pid.Recording]) -> Hypothesis:
    """Dry friction of one joint doubled, viscous friction of it too."""
    v = healthy_runs[2].dq
    assert v is not None
    friction = Arm().friction
    more = friction.coulomb * np.tanh(v / 0.01) + friction.viscous * v
    return opened(ur5, healthy_runs[:3], more * (np.arange(6) == JOINT - 1))


def candidate(state: Hypothesis, name: str, joint: int = JOINT) -> Candidate:
    (found,) = (c for c in state.data.candidates if c.key == (name, (joint,)))
    return found


def accepted(state: Hypothesis, *keys: tuple[str, int]) -> tuple[AcceptedEffect, ...]:
    made = []
    for name, joint in keys:
        own = candidate(state, name, joint)
        assert own.options[0].effect is not None
        made.append(AcceptedEffect(own, own.options[0].effect))
    return tuple(made)


def test_the_search_ends_where_a_placebo_comes_next(rubbing: Hypothesis) -> None:
    """A real effect would pass behind it: what follows a column that cannot be a cause is worth no more."""
    now = score_candidates(rubbing)
    top = choose_candidate(now)
    assert top is not None
    assert now.hypothesis.data.candidates[top].joints == (JOINT,)
    first = next(i for i, c in enumerate(now.hypothesis.data.candidates) if c.placebo)
    gain, least, share = now.gain.copy(), now.evidence_without_best_fold.copy(), now.visible_share.copy()
    gain[first], least[first], share[first] = 2 * gain.max(), 2 * least.max(), 1.0
    assert choose_candidate(replace(now, gain=gain, evidence_without_best_fold=least, visible_share=share)) is None


def test_as_good_is_what_the_scatter_over_blocks_cannot_tell(
    rubbing: Hypothesis, monkeypatch: pytest.MonkeyPatch
) -> None:
    blocks = np.random.default_rng(0).normal(size=(50, 6))
    error = np.sqrt(50) * blocks.sum(axis=1).std(ddof=1)
    one, other = candidate(rubbing, "viscous_friction"), candidate(rubbing, "coulomb_friction")
    cost, weights = np.zeros((50, 6)), rubbing.fit.weights
    for excess, contradicted, expected in ((1.0, 0.0, True), (2.5, 0.0, False), (1.0, 1.5, False)):
        loss = blocks + (excess * error - blocks.sum()) / blocks.size
        monkeypatch.setattr(acceptance, "left_out_costs", lambda *_, loss=loss: loss)
        monkeypatch.setattr(acceptance, "contradicted", lambda *_, more=contradicted * error: more)
        assert acceptance.is_as_good(rubbing, other, cost, weights, 0.0) is expected, (one, excess)


def test_of_two_effects_at_work_neither_replaces_the_other(rubbing: Hypothesis) -> None:
    dry, wet = candidate(rubbing, "coulomb_friction"), candidate(rubbing, "viscous_friction")
    threshold = score_candidates(rubbing).threshold
    assert not acceptance.makes_redundant(rubbing, dry, wet, threshold)
    assert not acceptance.makes_redundant(rubbing, wet, dry, threshold)
    assert acceptance.makes_redundant(rubbing, dry, dry, threshold)


def test_each_of_two_effects_has_no_rival_in_the_other(rubbing: Hypothesis) -> None:
    state = settled_hypothesis(
        rubbing.problem, accepted(rubbing, ("coulomb_friction", JOINT), ("viscous_friction", JOINT))
    )
    now = score_candidates(state)
    for one in state.accepted:
        examined = check_rivals(now, one)
        assert examined.gain > now.threshold
        assert not {c.name for c in examined.rivals} & {"coulomb_friction", "viscous_friction"}


@pytest.mark.parametrize("springs", [True, False])
def test_a_spring_that_is_relaxed_anywhere_is_a_rival_of_a_link_and_a_weight_has_none(
    ur5: pid.Robot, healthy_runs: list[pid.Recording], springs: bool
) -> None:
    """The spring alone would be relaxed at zero, and no rival; what follows the sine of a wide angle is no spring."""
    turned = healthy_runs[2].q[:, 1] + 1.2
    torque = 15 * (turned if springs else np.sin(turned))
    state = opened(ur5, healthy_runs[:3], torque[:, None] * (np.arange(6) == 1))
    (link,) = settled_hypothesis(state.problem, accepted(state, ("link_inertia", 2))).accepted
    beside = settled_hypothesis(state.problem, (link,))
    rivals = check_rivals(score_candidates(beside), link).rivals
    assert (("joint_spring", (2,)) in {one.key for one in rivals}) is springs


def test_what_another_effect_makes_superfluous_is_removed(rubbing: Hypothesis) -> None:
    true = (("coulomb_friction", JOINT), ("viscous_friction", JOINT))
    every = accepted(rubbing, *true, ("coulomb_friction", 5), ("friction_asymmetry", JOINT))
    kept = forward_search.without_redundant(
        rubbing.problem, every, score_candidates(settled_hypothesis(rubbing.problem, every))
    )
    assert {(a.candidate.name, a.candidate.joints[0]) for a in kept} == set(true)


def test_a_shape_beyond_the_grid_is_said_to_lie_at_its_end(rubbing: Hypothesis) -> None:
    """There the value is a bound; and a length, known by its logarithm, is never negative."""
    own = candidate(rubbing, "presliding_hysteresis")
    options = [o.effect for o in own.options if o.effect is not None]
    for place, at_end in ((0, True), (len(options) // 2, False), (len(options) - 1, True)):
        state = settled_hypothesis(rubbing.problem, (AcceptedEffect(own, options[place]),))
        (shape,) = _shapes(state.accepted[0], uncertainty_of(state), state.problem.model.robot)
        assert shape.at_end is at_end, place
        low, high = shape.interval95
        assert 0 < low < shape.value < high
        assert low * high == pytest.approx(shape.value**2)


def test_a_power_is_told_apart_from_the_first(ur5: pid.Robot, healthy_runs: list[pid.Recording]) -> None:
    """v log v is the limit of powers ever nearer to the first, each of them with a larger coefficient: what is told is one that the rows
    tell from viscous friction."""
    runs = []
    for run in healthy_runs[:3]:
        assert run.dq is not None
        bend = 25 * run.dq * np.log(np.abs(run.dq) + 1e-9) * (np.arange(6) == JOINT - 1)
        runs.append(replace(run, effort=run.effort + bend))
    estimate = pid.identify(ur5, runs)
    signals = prepare_all(ur5, runs, estimate.filter)
    problem = state_problem(choose_question(estimate, runs), estimate, signals, estimate.filter, 0)
    bent = settled_hypothesis(problem, ())
    (power,) = (c for c in bent.data.candidates if c.key == ("nonlinear_viscous_friction", (JOINT,)))
    torque = bent.columns(power, refine_shape(bent, power)).torque(np.ones(1)) * bent.fit.weights
    rows = np.concatenate([B * w for B, w in zip(bent.baseline.joints, bent.fit.weights, strict=True)])
    column = torque.T.ravel()  # joint below joint, as the baseline's
    left = column - rows @ np.linalg.lstsq(rows, column, rcond=1e-10)[0]
    assert left @ left > 0.9 * VISIBLE * (column @ column)
    assert left_out_gains(bent.data, bent.baseline, bent.fit).evidence[bent.data.candidates.index(power), 0] > 100


@pytest.mark.parametrize(("before_it", "same"), [(3.0, False), (0.1, True), (0.0, True)])
def test_an_effect_that_is_missing_on_one_joint_makes_another_torque(before_it: float, same: bool) -> None:
    """A weight on a slide is thirty times the noise there, and to the joint before it an inertia of some of its noise, or of little."""
    rng = np.random.default_rng(2)
    weight = np.column_stack([before_it * rng.standard_normal(400), np.full(400, 30.0)]).ravel()
    offset = np.column_stack([np.zeros(400), np.ones(400)]).reshape(-1, 1)
    assert Span.of(offset).makes(weight, 2, 2) is same
