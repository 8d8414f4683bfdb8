"""The search's last step: curves where no law is left that explains anything, and in the place of laws that explain clearly less.

A curve meets the conditions that every effect meets, against surrogates and placebos that have as many numbers as it has. Its
smoothness is the one that predicts left-out rows best. Where a law takes as much as the curve, the law stays.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.learned.more_laws import with_more_laws
from physident.diagnosis.learned.nearest_law import changed_laws, laws_by_share
from physident.diagnosis.learned.pool import CurvePool
from physident.diagnosis.learned.turning_speed import with_own_width
from physident.diagnosis.problem.candidates import AcceptedEffect, Candidate
from physident.diagnosis.remainder.unexplained import white_memory
from physident.diagnosis.search.acceptance import is_admissible
from physident.diagnosis.search.candidate_scores import over_surrogates, score_candidates
from physident.diagnosis.search.forward_search import HANDFUL, SearchResult, count_findings, placed, without_redundant
from physident.diagnosis.search.hypothesis import Hypothesis, state_hypothesis
from physident.diagnosis.search.left_out_costs import RIVAL_STANDARD_ERRORS, is_worth_naming, left_out_costs
from physident.diagnosis.search.shape_refinement import refine_shape
from physident.diagnosis.statistics.left_out_gains import Judge, left_out_gains
from physident.diagnosis.statistics.left_out_residuals import standard_error
from physident.diagnosis.statistics.thresholds import effect_threshold
from physident.effects.classification import Family
from physident.effects.learned.curve import LearnedCurve
from physident.estimation.uncertainty import correlation_rows
from physident.identifiability.visibility import VISIBLE

Array = NDArray[np.float64]
REMEMBERS = 1.3  # times what noise through the filter remembers: its own estimate scatters by a tenth, a curve worth naming adds more
MOST = 4  # curves: what takes more is no joint's own quantity


def learn_curves(found: SearchResult, progress: Callable[[str], None] = lambda _: None) -> SearchResult:
    """A finished search, with curves beside its effects or in their place where these are better on left-out rows."""
    start = found.last.hypothesis
    if start.problem.resting_joints.issuperset(range(1, start.problem.model.robot.n + 1)):
        return found
    joints = joints_with_structure(start)
    if not joints:
        return found
    pool, threshold = CurvePool.of(start, joints), found.last.threshold
    now = state_hypothesis(pool.problem, start.accepted, start.model, pool.data)
    now = _with_replacements(now, pool, threshold, progress)
    overfull = found.overfull and count_findings(start.problem, now.accepted) > HANDFUL
    for _ in range(0 if overfull else MOST):
        better = _best_beside(now, pool, threshold)
        if better is None:
            break
        progress(f"learned {placed(better)}")
        now = state_hypothesis(now.problem, (*now.accepted, better), now.model, now.data)
    now = now if overfull else _with_one_story(_with_laws_of_their_shape(now, progress), pool, threshold, progress)
    curves = [one for one in now.accepted if isinstance(one.effect, LearnedCurve)]
    if len(now.accepted) == len(start.accepted) and all(
        a is b for a, b in zip(now.accepted, start.accepted, strict=True)
    ):
        return found
    finished = _finished(replace(found, overfull=overfull), pool, now, curves)
    now = _with_laws_of_their_shape(
        finished.last.hypothesis, progress
    )  # beside what the curves made redundant none took as much
    if now is not finished.last.hypothesis:
        finished = replace(finished, accepted=now.accepted, last=score_candidates(now))
    return with_more_laws(finished, progress)


def joints_with_structure(hypothesis: Hypothesis) -> list[int]:
    """The joints (from 1) with something to learn: whose residual remembers more than noise through the filter, or that have a law of
    one quantity, which a curve may replace."""
    memory = correlation_rows(hypothesis.problem.regressor, hypothesis.fit.residual)
    lawful = {one.candidate.joints for one in hypothesis.accepted if one.effect.variable is not None}
    left = memory > REMEMBERS * white_memory(hypothesis)
    return [j + 1 for j in range(len(left)) if left[j] or (j + 1,) in lawful]


def _finished(found: SearchResult, pool: CurvePool, now: Hypothesis, curves: Sequence[AcceptedEffect]) -> SearchResult:
    """The search with the curves among its candidates, those of the same joints as possible rivals, and without laws that they make
    redundant. A law that takes as much as the curve does stays: the curve is what it leaves."""
    joints = {joint for one in curves for joint in one.candidate.joints}
    sizes = {one.candidate.key: one.candidate for one in curves}
    others = [
        sizes.get((curve.effect.name, (curve.joint,)), curve.candidate(10.0, float(now.fit.sigma[curve.joint - 1])))
        for curve in pool.curves
        if curve.joint in joints
    ]
    problem = pool.with_only(found.last.hypothesis.problem, others)
    places = {candidate.key: candidate for candidate in problem.candidates}
    accepted = [replace(one, candidate=places.get(one.candidate.key, one.candidate)) for one in now.accepted]
    hypothesis = state_hypothesis(problem, accepted, now.model)
    last = replace(found.last, hypothesis=hypothesis)
    kept = without_redundant(problem, hypothesis.accepted, last)
    lost = [one for one in hypothesis.accepted if not any(one is other for other in kept)]
    won = [one for one in lost if any(_takes_as_much(hypothesis, one, curve) for curve in kept)]
    kept = tuple(one for one in hypothesis.accepted if any(one is other for other in (*kept, *won)))
    if len(kept) < len(hypothesis.accepted):
        hypothesis = state_hypothesis(problem, kept, now.model, hypothesis.data)
    return replace(found, accepted=kept, last=score_candidates(hypothesis))


def _takes_as_much(hypothesis: Hypothesis, law: AcceptedEffect, curve: AcceptedEffect) -> bool:
    """Whether an accepted law explains as much as an accepted curve of the same joint would in its place."""
    if not isinstance(curve.effect, LearnedCurve) or law.candidate.joints != curve.candidate.joints:
        return False
    others = [one for one in hypothesis.accepted if one is not law and one is not curve]
    rest = state_hypothesis(hypothesis.problem, others, hypothesis.model, hypothesis.data)
    near = laws_by_share(rest, curve.candidate)
    return any(one.is_enough for one in near if one.law.key == law.candidate.key)


def _with_replacements(
    now: Hypothesis, pool: CurvePool, threshold: float, progress: Callable[[str], None]
) -> Hypothesis:
    """The hypothesis with a curve in the place of each joint's laws of one quantity, where these explain clearly less."""
    for joint in range(1, now.problem.model.robot.n + 1):
        for variable in ("position", "velocity", "load", "torque", "temperature", "time"):
            for laws in _laws_together(now, joint, variable):
                replaced = _with_replacement(now, pool, threshold, laws, joint, variable, progress)
                if replaced is not now:
                    now = replaced
                    break
    return now


def _laws_together(now: Hypothesis, joint: int, variable: str) -> list[list[AcceptedEffect]]:
    """The laws of a joint that a curve may replace, most of them first. A bend of the torque is imitated by a gain and friction that grows with the
    load, together."""
    laws = [one for one in now.accepted if _is_law(now, one, joint, variable)]
    more = [one for one in now.accepted if variable == "torque" and _is_law(now, one, joint, "load")]
    return [some for some in ([*laws, *more] if more else [], laws) if some and laws]


def _with_replacement(
    now: Hypothesis,
    pool: CurvePool,
    threshold: float,
    laws: Sequence[AcceptedEffect],
    joint: int,
    variable: str,
    progress: Callable[[str], None],
) -> Hypothesis:
    """The hypothesis with a curve in the place of some laws of a joint, where these explain clearly less; as it is elsewhere."""
    rest = state_hypothesis(now.problem, [a for a in now.accepted if a not in laws], now.model, now.data)
    curve = _smoothest(rest, [c for c in pool.candidates(rest, [joint]) if _variable(c) == variable], threshold)
    if curve is None or not is_admissible(rest, curve):
        return now
    is_one_for_several = (
        len({one.effect.variable for one in laws}) > 1
    )  # the shorter description wins where it predicts better at all
    if not (_is_better(now, rest, curve) if is_one_for_several else _is_clearly_better(now, rest, curve)):
        return now
    law = _law_of_its_shape(rest, curve)
    if law is not None and law.candidate.key in {one.candidate.key for one in laws}:
        return now
    new = law or AcceptedEffect(curve, with_own_width(rest, curve, _effect(curve)))
    progress(f"{'added' if law else 'learned'} {placed(new)} in the place of {', '.join(map(placed, laws))}")
    return state_hypothesis(now.problem, (*rest.accepted, new), now.model, now.data)


def _with_laws_of_their_shape(now: Hypothesis, progress: Callable[[str], None]) -> Hypothesis:
    """The hypothesis with laws that the model has in the place of each curve, and of its joint's laws of the same quantity, where these take
    as much: what changed is their values. Beside a law that the model lacks, a curve is what this leaves, and of use."""
    for curve in [one for one in now.accepted if isinstance(one.effect, LearnedCurve)]:
        (joint,), variable = curve.candidate.joints, curve.effect.variable
        parts = [one for one in now.accepted if one is curve or _is_law(now, one, joint, variable or "")]
        rest = state_hypothesis(now.problem, [a for a in now.accepted if a not in parts], now.model, now.data)
        laws = changed_laws(rest, curve.candidate)
        if laws:
            progress(f"{' and '.join(map(placed, laws))} in the place of {', '.join(map(placed, parts))}")
            now = state_hypothesis(now.problem, (*rest.accepted, *laws), now.model, now.data)
    return now


def _with_one_story(now: Hypothesis, pool: CurvePool, threshold: float, progress: Callable[[str], None]) -> Hypothesis:
    """The hypothesis with a curve in the place of each joint's laws of velocity, where another joint's friction needs a curve and left-out
    rows do not object: what bends the friction of several joints is one thing, and a law that fits one of them does so by chance. A law that
    the model has bends nothing: its value changed."""
    if not any(isinstance(one.effect, LearnedCurve) and one.effect.variable == "velocity" for one in now.accepted):
        return now
    for joint in range(1, now.problem.model.robot.n + 1):
        laws = [one for one in now.accepted if _is_law(now, one, joint, "velocity")]
        if all(one.candidate.key in now.problem.present for one in laws):
            continue
        rest = state_hypothesis(now.problem, [a for a in now.accepted if a not in laws], now.model, now.data)
        curve = _smoothest(rest, [c for c in pool.candidates(rest, [joint]) if _variable(c) == "velocity"], threshold)
        law = None if curve is None else _law_of_its_shape(rest, curve)
        if law is not None and law.candidate.key in now.problem.present:
            continue
        if curve is not None and is_admissible(rest, curve) and not _is_clearly_worse(now, rest, curve):
            new = AcceptedEffect(curve, with_own_width(rest, curve, _effect(curve)))
            progress(f"learned {placed(new)} in the place of {', '.join(map(placed, laws))}")
            now = state_hypothesis(now.problem, (*rest.accepted, new), now.model, now.data)
    return now


def _is_law(now: Hypothesis, one: AcceptedEffect, joint: int, variable: str) -> bool:
    """Whether an accepted effect is a law of one quantity of a joint, which the search has found."""
    ordinary = {own.candidate.key for own in now.problem.missing_default_effects}
    return (
        one.candidate.joints == (joint,)
        and one.effect.variable == variable
        and one.effect.family is not Family.LEARNED
        and one.candidate.key not in ordinary
    )


def _variable(candidate: Candidate) -> str | None:
    return _effect(candidate).variable


def _effect(candidate: Candidate) -> LearnedCurve:
    (option,) = candidate.options
    assert isinstance(option.effect, LearnedCurve)
    return option.effect


def _smoothest(rest: Hypothesis, candidates: Sequence[Candidate], threshold: float) -> Candidate | None:
    """The curve, with the amplitude, of the most evidence on left-out rows; None where even that is no evidence."""
    if not candidates:  # the model has this curve already
        return None
    data = replace(rest.data, candidates=tuple(candidates))
    gains = left_out_gains(data, rest.baseline, rest.fit, products=rest.products)
    best = int(np.argmax(gains.evidence[:, 0]))
    shown = gains.visible[best] >= VISIBLE and gains.evidence_without_best_fold[best, 0] > threshold
    return candidates[best] if shown else None


def _is_better(now: Hypothesis, rest: Hypothesis, curve: Candidate) -> bool:
    """Whether left-out rows are predicted better with a curve than with the laws in its place, be it by chance."""
    return bool(np.sum(left_out_costs(rest, curve, now.fit.weights) - left_out_costs(now, None)) < 0)


def _is_clearly_better(now: Hypothesis, rest: Hypothesis, curve: Candidate) -> bool:
    """Whether left-out rows are predicted better with a curve than with the laws in its place."""
    return _clearly_less(now, left_out_costs(rest, curve, now.fit.weights), left_out_costs(now, None))


def _is_clearly_worse(now: Hypothesis, rest: Hypothesis, curve: Candidate) -> bool:
    """Whether left-out rows are predicted worse with a curve than with the laws in its place."""
    return _clearly_less(now, left_out_costs(now, None), left_out_costs(rest, curve, now.fit.weights))


def _clearly_less(now: Hypothesis, cost: Array, other: Array) -> bool:
    """Whether a cost (G, n) is below another beyond the scatter over blocks and by as much as is worth naming."""
    gain = (other - cost).sum(axis=1)
    return is_worth_naming(now, other, cost) and bool(gain.sum() > RIVAL_STANDARD_ERRORS * standard_error(gain))


def _law_of_its_shape(rest: Hypothesis, curve: Candidate) -> AcceptedEffect | None:
    """The law of the same joint, or of the whole arm, that takes as much as a curve, the one of the most gain; None where there is none."""
    for near in laws_by_share(rest, curve):
        if not near.is_enough:
            return None
        if is_admissible(rest, near.law):
            return AcceptedEffect(near.law, refine_shape(rest, near.law))
    return None


def _best_beside(now: Hypothesis, pool: CurvePool, threshold: float) -> AcceptedEffect | None:
    """The curve of the largest gain beside a hypothesis that meets every condition, or None. Beside a law of the same quantity it is also larger
    than what the model may err by: that much shape is no change."""
    candidates = pool.candidates(now)
    if not candidates:
        return None
    plain = replace(now.data, candidates=tuple(candidates))
    first = left_out_gains(plain, now.baseline, now.fit, products=now.products)
    if not (first.evidence_without_best_fold[:, 0] > threshold).any():
        return None
    every = [*candidates, *pool.placebo_candidates(now)]
    data = replace(now.data, candidates=tuple(every))
    judge = Judge(data, now.baseline, now.fit, now.products)
    gains = judge.gains()
    stable, at = gains.evidence_without_best_fold, [one.joints[0] - 1 for one in every]
    taken = gains.gain.sum(axis=1)[np.arange(len(every)), at, 0]  # on the curve's own joint
    drawn = over_surrogates(now, lambda some: judge.gains(judge.products_with(some)).evidence_without_best_fold)
    level = max(threshold, effect_threshold(np.concatenate(drawn, axis=1), gains.visible))
    for index in np.argsort(-gains.evidence[:, 0]):
        candidate = every[int(index)]
        if gains.visible[index] < VISIBLE or stable[index, 0] <= level:
            continue
        if candidate.placebo:
            return None  # curves after a placebo are no better than chance
        (joint,), variable = candidate.joints, _variable(candidate) or ""
        lawful = any(_is_law(now, one, joint, variable) for one in now.accepted)
        if lawful and taken[index] <= now.usual_power(joint):
            continue
        if is_admissible(_fresh(now), candidate):
            return AcceptedEffect(candidate, with_own_width(now, candidate, _effect(candidate)))
    return None


def _fresh(now: Hypothesis) -> Hypothesis:
    """The same hypothesis without what it remembers of candidates, which the same curve with another amplitude would take over."""
    return replace(now)
