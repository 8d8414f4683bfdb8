"""How a cause is accepted: the conditions a candidate must meet to be named, and which of several that do is taken."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect, Candidate
from physident.diagnosis.rivals.imitators import is_not_imitated
from physident.diagnosis.search.candidate_scores import CandidateScores
from physident.diagnosis.search.contact_scan import CONTACT
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.search.left_out_costs import (
    RIVAL_STANDARD_ERRORS,
    contradicted,
    is_worth_naming,
    left_out_costs,
)
from physident.diagnosis.search.physical_signs import physical_contradiction
from physident.diagnosis.search.shape_refinement import refine_shape
from physident.diagnosis.statistics.intervals import resampled_reduction
from physident.diagnosis.statistics.left_out_gains import left_out_gains
from physident.diagnosis.statistics.left_out_residuals import standard_error
from physident.effects.classification import Family
from physident.identifiability.visibility import VISIBLE

Array = NDArray[np.float64]
BY_CHANCE = 6.6  # chi squared of one number: one in a hundred parameters contradicts earlier rows by more
DOUBT = 2.0  # times an earlier threshold: what a fresh draw of surrogates moves it by is a tenth
MAX_COMPARED = 8  # candidates compared block by block: more rivals would not be a useful answer


def choose_candidate(scores: CandidateScores) -> int | None:
    """Index of the candidate to accept, or None: the one of the largest gain that meets every condition, or a smaller one
    that is as good."""
    order = [int(i) for i in np.argsort(-scores.gain) if scores.beats_chance(int(i))]
    candidates = scores.hypothesis.data.candidates
    for rank, index in enumerate(order):
        if candidates[index].placebo:
            return None  # candidates after a placebo are no better than chance
        if is_admissible(scores.hypothesis, candidates[index]):
            return _smallest(scores, index, order[rank + 1 :][:MAX_COMPARED])
    return None


def is_beyond_doubt(scores: CandidateScores) -> bool:
    """Whether a candidate that is no contact is to be accepted next by any threshold that new surrogates may set."""
    index = choose_candidate(scores)
    if index is None or scores.contact_may_come_first:
        return False
    return bool(scores.evidence_without_best_fold[index] > DOUBT * scores.threshold)


def contact_accepted(scores: CandidateScores, rival_gain: float | None) -> bool:
    """Whether the best contact meets every condition, even without its strongest joint, and explains more than the best
    other candidate, whose gain is ``rival_gain``."""
    contact = scores.contact
    return bool(
        contact.is_of_use
        and contact.evidence[0] > max(scores.contact_threshold, rival_gain or 0.0)
        and contact.evidence_without_best_joint[0] > scores.contact_threshold_without_best_joint
    )


def _smallest(scores: CandidateScores, top: int, others: Sequence[int]) -> int:
    """The candidate with the fewest parameters among those whose gain does not differ significantly from the best one's."""
    hypothesis = scores.hypothesis
    candidates = hypothesis.data.candidates
    best, weights, top_cost, chi_squared = top, None, np.zeros(0), 0.0
    for index in others:
        other = candidates[index]
        if other.size >= candidates[best].size or other.placebo:
            continue
        if weights is None:
            weights = hypothesis.with_effect(candidates[top], refine_shape(hypothesis, candidates[top])).fit.weights
            top_cost = left_out_costs(hypothesis, candidates[top], weights)
            chi_squared = contradicted(hypothesis, candidates[top])
        if not is_as_good(hypothesis, other, top_cost, weights, chi_squared) or not is_useful(hypothesis, other):
            continue
        if contradiction(hypothesis, other) is None and makes_redundant(
            hypothesis, other, candidates[top], scores.threshold
        ):
            best = index
    return best


def smaller_of_family(rest: Hypothesis, first: AcceptedEffect, threshold: float) -> tuple[AcceptedEffect, ...]:
    """Effects of the same family that stand in place of ``first``: fewer parameters in all, without a significant loss on
    left-out rows beside the hypothesis without it; none where there are no such effects.

    A link's inertia also contains what the rotors of several joints add: only together are they as good.
    """
    if (
        first.candidate.size < 3 or first.candidate is CONTACT
    ):  # nothing is smaller than two parameters but one, which was tried
        return ()
    family = first.effect.family
    weights = rest.with_effect(first.candidate, first.effect).fit.weights
    cost, now, found, left = left_out_costs(rest, first.candidate, weights), rest, (), first.candidate.size - 1
    while True:
        smaller = tuple(c for c in now.data.candidates if _is_smaller(c, family, min(left, first.candidate.size - 1)))
        if not smaller:
            return ()
        data = replace(now.data, candidates=smaller)
        gains = left_out_gains(data, now.baseline, now.fit, products=now.products).evidence[:, 0]
        best = smaller[int(np.argmax(gains))]
        if gains.max() < threshold or not is_admissible(now, best):
            return ()
        effect = refine_shape(now, best)
        now, found, left = now.with_effect(best, effect), (*found, AcceptedEffect(best, effect)), left - best.size
        now = replace(now, data=replace(now.data, candidates=tuple(c for c in now.data.candidates if c is not best)))
        loss = (left_out_costs(now, None, weights) - cost).sum(axis=1)
        if loss.sum() < RIVAL_STANDARD_ERRORS * standard_error(loss):
            return found


def _is_smaller(candidate: Candidate, family: Family, size: int) -> bool:
    effect = candidate.options[0].effect
    return effect is not None and effect.family is family and candidate.size <= size


def is_admissible(hypothesis: Hypothesis, candidate: Candidate) -> bool:
    """Whether a candidate's gain is of use, nothing imitates it, and the extended arm is physically possible."""
    return (
        is_useful(hypothesis, candidate)
        and is_not_imitated(hypothesis, candidate)
        and contradiction(hypothesis, candidate) is None
    )


def is_useful(hypothesis: Hypothesis, candidate: Candidate) -> bool:
    """Whether the gain on left-out rows is worth naming, and its 95 % interval over blocks lies above zero.

    Where a law that the model has changes its value, what its parameters then contradict less of earlier rows counts like rows of its joints, in
    each block alike: two values of friction that have changed are else taken up by the parameters, against all that was known of them.
    """
    before, after = left_out_costs(hypothesis, None), left_out_costs(hypothesis, candidate)
    joints = [j - 1 for j in candidate.joints] or list(range(before.shape[1]))
    if candidate.key in hypothesis.problem.present:
        own = len(hypothesis.problem.freedom.prior)  # what a scale of all joints may differ by is no earlier row
        relief = max(0.0, contradicted(hypothesis, None, own) - contradicted(hypothesis, candidate, own) - BY_CHANCE)
        before = before + relief / (len(before) * len(joints)) * np.isin(np.arange(before.shape[1]), joints)
    low, _ = resampled_reduction(before[:, joints].sum(axis=1), after[:, joints].sum(axis=1), hypothesis.problem.seed)
    return low > 0 and is_worth_naming(hypothesis, before, after)


def contradiction(hypothesis: Hypothesis, candidate: Candidate) -> str | None:
    """What a candidate makes physically impossible, in words; None where the extended arm can exist."""
    if candidate.key not in hypothesis.contradictions:
        extended = hypothesis.with_effect(candidate, refine_shape(hypothesis, candidate))
        hypothesis.contradictions[candidate.key] = physical_contradiction(extended)
    return hypothesis.contradictions[candidate.key]


def is_as_good(hypothesis: Hypothesis, other: Candidate, cost: Array, weights: Array, chi_squared: float) -> bool:
    """Whether the loss against another candidate, of a left-out ``cost`` (G, n) and ``chi_squared`` on earlier rows, lies within its scatter over blocks."""
    loss = (left_out_costs(hypothesis, other, weights) - cost).sum(axis=1)
    more = contradicted(hypothesis, other) - chi_squared
    return bool(loss.sum() + more < RIVAL_STANDARD_ERRORS * standard_error(loss))


def makes_redundant(hypothesis: Hypothesis, other: Candidate, first: Candidate, threshold: float) -> bool:
    """Whether beside ``other`` the ``first`` candidate has nothing left to add; else both act, or the first is better."""
    beside = hypothesis.with_effect(other, refine_shape(hypothesis, other))
    data = replace(beside.data, candidates=(first,))
    gains = left_out_gains(data, beside.baseline, beside.fit, products=beside.products)
    return float(gains.evidence[0, 0]) < threshold


def evidence_without_best_fold(hypothesis: Hypothesis, candidate: Candidate) -> float:
    """A candidate's evidence without the fold that supports it most; none where it lies inside the baseline."""
    data = replace(hypothesis.data, candidates=(candidate,))
    if hypothesis.problem.is_friction_of_resting_joint(candidate):
        return 0.0
    gains = left_out_gains(data, hypothesis.baseline, hypothesis.fit, products=hypothesis.products)
    if gains.visible[0] < VISIBLE:
        return 0.0
    return float(gains.evidence_without_best_fold[0, 0])
