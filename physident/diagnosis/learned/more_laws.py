"""Laws that show only beside a curve: friction that builds up over a distance is hidden by a hump of friction while nothing describes that."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from physident.diagnosis.learned.pool import AMPLITUDES
from physident.diagnosis.problem.candidates import AcceptedEffect, Candidate
from physident.diagnosis.search.acceptance import choose_candidate
from physident.diagnosis.search.candidate_scores import rescore_candidates, score_candidates
from physident.diagnosis.search.forward_search import HANDFUL, SearchResult, add_while_better, count_findings
from physident.diagnosis.search.hypothesis import Hypothesis, state_hypothesis
from physident.diagnosis.statistics.left_out_gains import left_out_gains
from physident.effects.classification import Family
from physident.effects.learned.curve import LearnedCurve
from physident.effects.learned.one_torque import is_curve_of
from physident.effects.learned.velocity_curve import LearnedVelocity


def with_more_laws(found: SearchResult, progress: Callable[[str], None] = lambda _: None) -> SearchResult:
    """A search that has learned curves over velocity, with the laws of other quantities of the same joints that are found beside them."""
    now, problem = found.last.hypothesis, found.last.hypothesis.problem
    curved = {one.candidate.joints for one in now.accepted if isinstance(one.effect, LearnedVelocity)}
    if found.overfull or not curved:
        return found
    held = {one.key for one in now.data.candidates if one.joints not in curved or _is_held(now, one)}
    narrower = replace(problem, barred=problem.barred | held)
    beside = state_hypothesis(narrower, now.accepted, now.model, now.data)
    if choose_candidate(rescore_candidates(beside, found.last)) is None:
        return found
    accepted, last = add_while_better(narrower, now.accepted, found.first, progress)
    smoother = _smoothed_anew(replace(last.hypothesis, problem=problem))
    overfull = count_findings(problem, accepted) > HANDFUL
    return replace(found, accepted=smoother.accepted, last=score_candidates(smoother), overfull=overfull)


def _is_held(now: Hypothesis, candidate: Candidate) -> bool:
    """Whether a candidate is a curve, or a law of what an accepted curve of its joint is a function of."""
    effect = candidate.options[0].effect
    return (effect is not None and effect.family is Family.LEARNED) or any(
        one.candidate.joints == candidate.joints and is_curve_of(one.candidate.name, candidate.name)
        for one in now.accepted
    )


def _smoothed_anew(now: Hypothesis) -> Hypothesis:
    """The hypothesis with the amplitude of each curve that predicts left-out rows best beside the laws: without these it bends to follow
    what they describe."""
    accepted = tuple(_smoothed(now, one) for one in now.accepted)
    problem = now.problem
    places = {one.candidate.key: one.candidate for one in accepted}
    problem = replace(problem, candidates=tuple(places.get(one.key, one) for one in problem.candidates))
    return state_hypothesis(problem, accepted, now.model)


def _smoothed(now: Hypothesis, one: AcceptedEffect) -> AcceptedEffect:
    """An accepted effect beside the others, where it is a curve with another amplitude."""
    curve, option = one.effect, one.candidate.options[0]
    if not isinstance(curve, LearnedCurve) or curve != option.effect:  # a turn of its own was found for this amplitude
        return one
    rest = state_hypothesis(now.problem, [a for a in now.accepted if a is not one], now.model, now.data)
    left = float(rest.fit.sigma[one.candidate.joints[0] - 1])
    effects = [replace(curve, amplitude=(factor * left,)) for factor in AMPLITUDES]
    tried = tuple(replace(one.candidate, options=(replace(option, effect=effect),)) for effect in effects)
    gains = left_out_gains(replace(rest.data, candidates=tried), rest.baseline, rest.fit, products=rest.products)
    best = int(np.argmax(gains.evidence[:, 0]))
    return AcceptedEffect(tried[best], effects[best])
