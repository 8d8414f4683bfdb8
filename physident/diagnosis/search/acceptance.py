"""How a cause is accepted: the conditions a candidate must meet to be named, and which of several that do is taken."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect, Candidate
from physident.diagnosis.problem.columns import Columns
from physident.diagnosis.search.candidate_scores import CandidateScores
from physident.diagnosis.search.contact_scan import CONTACT
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.search.physical_signs import FREE, physical_contradiction
from physident.diagnosis.search.shape_refinement import refine_shape
from physident.diagnosis.search.thresholds import MIN_REDUCTION_PERCENT
from physident.diagnosis.statistics.intervals import resampled_reduction
from physident.diagnosis.statistics.left_out_gains import left_out_gains
from physident.diagnosis.statistics.left_out_residuals import standard_error
from physident.effects.catalogue import effect_scope
from physident.effects.classification import Family, Scope
from physident.effects.effect import Effect
from physident.effects.learned.curve import LearnedCurve
from physident.effects.learned.curves import LearnedTorque
from physident.effects.measurement import LateFriction, LeakingChannels, TimeDelay, TorqueConstant, TorqueDelay
from physident.effects.scales.friction_level import FrictionLevel
from physident.effects.scales.torque_scale import TorqueScale
from physident.identifiability.visibility import VISIBLE

Array = NDArray[np.float64]
RIVAL_STANDARD_ERRORS = 1.645  # of a paired difference: the true cause is then missed as a rival once in twenty
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


def is_not_imitated(hypothesis: Hypothesis, candidate: Candidate) -> bool:
    """Whether a candidate is no leak between channels, no lag of friction alone, no scale of friction alone, and not how friction turns."""
    as_a_whole = lags_as_a_whole(hypothesis, candidate) and scales_as_a_whole(hypothesis, candidate)
    return as_a_whole and acts_while_sliding(hypothesis, candidate) and holds_against_leaks(hypothesis, candidate)


def lags_as_a_whole(hypothesis: Hypothesis, candidate: Candidate) -> bool:
    """Whether late channels predict left-out rows better than a lag of friction alone, by more than its standard error over blocks: friction
    that builds up over a distance lags, too, and what a joint carries does not. True of any other candidate."""
    effect = candidate.options[0].effect
    if not isinstance(effect, TorqueDelay | TimeDelay):
        return True
    joints = effect.joints if isinstance(effect, TorqueDelay) else None  # each of them by a lag of its own
    gain = (_cost_of(hypothesis, LateFriction(joints)) - left_out_costs(hypothesis, candidate)).sum(axis=1)
    return bool(gain.sum() > standard_error(gain))


def scales_as_a_whole(hypothesis: Hypothesis, candidate: Candidate) -> bool:
    """Whether a scale of all torque predicts left-out rows better than one of friction alone, each joint by a share of its own, by more than its
    standard error over blocks: friction differs from day to day by itself, and on each joint otherwise. True of any other candidate."""
    options = (one.options[0].effect for one in hypothesis.problem.candidates)
    level = next((one for one in options if isinstance(one, FrictionLevel)), None)
    if not isinstance(scale := candidate.options[0].effect, TorqueScale) or level is None:
        return True
    friction, whole = (_cost_of(hypothesis, replace(one, uneven_percent=FREE, held=())) for one in (level, scale))
    gain = (friction - whole).sum(axis=1)
    return bool(gain.sum() > standard_error(gain))


def acts_while_sliding(hypothesis: Hypothesis, candidate: Candidate) -> bool:
    """Whether a curve over the torque predicts left-out rows better than one that acts about reversals alone, by more than its standard error over
    blocks: the torque of dry friction passes values there that it has at no other time, however slowly it turns. True of any other candidate."""
    (option, *_) = candidate.options
    if not isinstance(option.effect, LearnedTorque):
        return True
    reversals = option.effect.at_reversals(hypothesis.problem.model.robot)
    gain = _cost_of(hypothesis, reversals, option.prior) - left_out_costs(hypothesis, candidate)
    return bool(gain.sum() > standard_error(gain.sum(axis=1)))


def _cost_of(hypothesis: Hypothesis, effect: Effect, prior: Array | None = None) -> Array:
    """Squared left-out residual (G, n) of each block with an effect whose values have a ``prior`` precision (k,), by default none, in units of
    the hypothesis' noise."""
    columns = hypothesis.problem.fresh_columns(effect, hypothesis.model)
    held = np.zeros(columns.count) if prior is None else prior
    return hypothesis.fit.weights**2 * hypothesis.left_out_fits.squares_of_blocks(columns, held)


def holds_against_leaks(hypothesis: Hypothesis, candidate: Candidate) -> bool:
    """Whether what couples two joints acts on both alike, and what scales a joint's torque, or is a curve over its position or load, belongs
    to its own channel: torque that leaks from one channel into another predicts left-out rows no better beyond the scatter over blocks, or by
    less than is worth naming of the error that the candidate is to explain, or takes on no joint more than it leaves of what that leaves."""
    alike = hypothesis.columns(candidate, refine_shape(hypothesis, candidate))
    leaking = _with_leaks(hypothesis, candidate, alike)
    if leaking is None:
        return True
    weights, squares = hypothesis.fit.weights**2, hypothesis.left_out_fits.squares_of_blocks
    law, free = (weights * squares(columns, np.zeros(columns.count)) for columns in (alike, leaking))
    gain = (law - free).sum(axis=1)
    worth = is_worth_naming(hypothesis, law, free, whole=left_out_costs(hypothesis, None))
    worth &= bool(np.any(law.sum(axis=0) > 2 * free.sum(axis=0)))  # else most of what is left is no leak either
    return not (worth and gain.sum() > RIVAL_STANDARD_ERRORS * standard_error(gain))


def _with_leaks(hypothesis: Hypothesis, candidate: Candidate, alike: Columns) -> Columns | None:
    """The columns of leaking channels that a candidate may be mistaken for: with values of its own on each joint for what couples two
    of them, with a share of every joint's torque for a gain or a curve that follows what the arm carries; None for any other candidate, and
    where torques are computed from motor currents, which do not leak."""
    if effect_scope(candidate.name) is Scope.NEIGHBOURS:
        return alike.joint_by_joint()
    if any(one.from_currents for one in hypothesis.problem.signals):
        return None
    effect = candidate.options[0].effect
    if isinstance(effect, TorqueConstant) or (
        isinstance(effect, LearnedCurve) and effect.variable in ("position", "load", "torque")
    ):
        assert effect.joints is not None
        return hypothesis.problem.fresh_columns(LeakingChannels(effect.joints), hypothesis.model)
    return None


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


def is_worth_naming(hypothesis: Hypothesis, before: Array, after: Array, whole: Array | None = None) -> bool:
    """Whether left-out costs (G, n), in units of a hypothesis' noise, fall by enough of a joint's RMS error to be of practical use: of the
    error ``before``, or of a ``whole`` one of which something else has taken its part."""
    usual = hypothesis.fit.weights**2 * hypothesis.problem.taken_off_squares
    costs = (before if whole is None else whole, before, after)
    most, more, less = (np.sqrt(np.maximum(one.sum(axis=0) + usual, 0.0)) for one in costs)
    return bool(np.max(100 * (more - less) / np.maximum(most, 1e-150)) >= MIN_REDUCTION_PERCENT)


def contradiction(hypothesis: Hypothesis, candidate: Candidate) -> str | None:
    """What a candidate makes physically impossible, in words; None where the extended arm can exist."""
    if candidate.key not in hypothesis.contradictions:
        extended = hypothesis.with_effect(candidate, refine_shape(hypothesis, candidate))
        hypothesis.contradictions[candidate.key] = physical_contradiction(extended)
    return hypothesis.contradictions[candidate.key]


def left_out_costs(hypothesis: Hypothesis, candidate: Candidate | None, weights: Array | None = None) -> Array:
    """Squared left-out residual (G, n) of each block, with a candidate or without any, in units of the hypothesis' noise
    or by other ``weights`` (n,)."""
    weights = hypothesis.fit.weights if weights is None else weights
    if candidate is None:
        return weights**2 * hypothesis.left_out_squares
    if candidate.key not in hypothesis.left_out:
        hypothesis.left_out[candidate.key] = hypothesis.left_out_fits.squares_of_blocks(*_options(candidate))
    return weights**2 * hypothesis.left_out[candidate.key]


def contradicted(hypothesis: Hypothesis, candidate: Candidate | None, first: int | None = None) -> float:
    """By how much the model, or its ``first`` values, contradict what earlier rows said of it, chi squared, with a candidate or without."""
    if not hypothesis.baseline.prior.any():
        return 0.0
    return hypothesis.left_out_fits.contradicted(*_options(candidate), first)


def _options(candidate: Candidate | None) -> tuple[list[tuple[int, ...]], list[Array]]:
    """The columns of each option of a candidate, and the prior precision (k,) of its values."""
    options = candidate.options if candidate else ()
    return [option.columns for option in options], [option.prior for option in options]


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
