"""A law of the model that another effect has taken the place of: dry friction that builds up over a distance for that which turns at once.

Neither shows without the other. Where a model has the right level of friction, friction that builds up to this level only adds to it, and less
friction is only wrong. So both are tried together, and that the model then has less of the one is no news of its own.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.search.acceptance import evidence_without_best_fold, is_admissible
from physident.diagnosis.search.candidate_scores import CandidateScores
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.search.shape_refinement import refine_shape
from physident.diagnosis.statistics.intervals import Uncertainty
from physident.diagnosis.statistics.stored_products import Key

MOST = 0.1  # of the friction: by more it has changed as well


def law_and_successor(scores: CandidateScores, tried: Collection[Key]) -> tuple[AcceptedEffect, ...]:
    """A change of one of the model's laws, none that was ``tried``, and the effect with a memory that takes its place, of the most evidence;
    empty where there is none."""
    hypothesis, best, found = scores.hypothesis, 0.0, ()
    places = {candidate.key: candidate for candidate in hypothesis.data.candidates}
    for candidate in places.values():
        effect = candidate.options[0].effect
        if effect is None or effect.pointwise or len(candidate.joints) != 1:
            continue
        law = places.get((effect.folded(hypothesis.problem.model.robot, np.ones(1))[0].name, candidate.joints))
        if law is None or law is candidate or law.key in tried:
            continue
        changed = AcceptedEffect(law, refine_shape(hypothesis, law))
        beside = hypothesis.with_effect(law, changed.effect)
        gain = evidence_without_best_fold(beside, candidate)
        if gain > max(best, scores.threshold_of(candidate.key, beside.accepted)) and is_admissible(beside, candidate):
            best, found = gain, (changed, AcceptedEffect(candidate, refine_shape(beside, candidate)))
    return found


def succeeded_laws(hypothesis: Hypothesis) -> list[AcceptedEffect]:
    """The accepted changes of laws whose place another accepted effect has taken."""
    return [one for i, one in enumerate(hypothesis.accepted) if _successor(hypothesis, i) is not None]


def with_no_successor(hypothesis: Hypothesis, laws: Sequence[AcceptedEffect]) -> list[AcceptedEffect]:
    """The laws of one joint each whose place no effect with a memory has that a hypothesis accepts."""
    return [one for one in laws if one.candidate.key not in hypothesis.built_up]


def is_succeeded(hypothesis: Hypothesis, i: int, uncertainty: Uncertainty) -> bool:
    """Whether what an accepted effect (its index) has lost is what another one has taken over: what both together differ by may be nothing, or
    is less than the joint's residual, and is a small part of it."""
    found = _successor(hypothesis, i)
    if found is None:
        return False
    k, level = found
    moves, places = np.zeros((1, len(uncertainty.changes.covariance))), hypothesis.places_of_changes
    moves[0, places[i].start], moves[0, places[k].start] = 1.0, level
    together = hypothesis.effect_values[i][0] + level * hypothesis.effect_values[k][0]
    left = hypothesis.fit.sigma[hypothesis.accepted[i].candidate.joints[0] - 1]
    open_to = max(float(uncertainty.changes.reach(moves, several=False)[0]), float(left))
    return bool(abs(together) <= min(open_to, MOST * abs(hypothesis.effect_values[i][0])))


def counterpart(hypothesis: Hypothesis, i: int) -> int | None:
    """The accepted effect (its index) that has lost what another accepted one (its index) gained, or the reverse, of which one is a law and the
    other builds up to it over a distance; None where there is none."""
    pairs = {k: found[0] for k in range(len(hypothesis.accepted)) if (found := _successor(hypothesis, k)) is not None}
    return pairs.get(i, next((law for law, memory in pairs.items() if memory == i), None))


def is_less_than_none(hypothesis: Hypothesis, i: int) -> bool:
    """Whether another effect has the place of an accepted law (its index) of which the model had nothing, and the law takes some of it back: only
    the sum of both is friction."""
    value = hypothesis.extension.model.theta[hypothesis.extension.places[i]][0]
    had = value - hypothesis.effect_values[i][0]
    return _successor(hypothesis, i) is not None and bool(value <= 0 and had <= 0)


def _successor(hypothesis: Hypothesis, i: int) -> tuple[int, float] | None:
    """The accepted effect (its index) with a memory that an accepted change of a law gives way to, and what a unit of it comes to once it has
    settled, in units of the law; None where there is none."""
    one, lost = hypothesis.accepted[i], hypothesis.effect_values[i]
    for k, other in enumerate(hypothesis.accepted):
        gained = hypothesis.effect_values[k]
        if other.effect.pointwise or other.candidate.joints != one.candidate.joints or len(lost) * len(gained) != 1:
            continue
        settled, levels = other.effect.folded(hypothesis.problem.model.robot, np.ones(1))
        if settled.name == one.candidate.name and lost[0] * levels[0] * gained[0] < 0:
            return k, float(levels[0])
    return None
