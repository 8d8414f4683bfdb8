"""The search: the best candidate that beats chance is accepted until none does; then each is tried for removal."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.problem.problem import DiagnosisProblem
from physident.diagnosis.rivals.successors import law_and_successor, succeeded_laws, with_no_successor
from physident.diagnosis.search.acceptance import (
    choose_candidate,
    contact_accepted,
    evidence_without_best_fold,
    is_admissible,
    is_beyond_doubt,
    smaller_of_family,
)
from physident.diagnosis.search.candidate_scores import CandidateScores, rescore_candidates, score_candidates
from physident.diagnosis.search.contact_refinement import refine_contact
from physident.diagnosis.search.contact_scan import CONTACT
from physident.diagnosis.search.hypothesis import Hypothesis, state_hypothesis, values_move
from physident.diagnosis.search.one_for_many import find_replacement
from physident.diagnosis.search.physical_signs import at_share_of_most, uneven_scales
from physident.diagnosis.search.shape_refinement import about_their_sizes, refine_shape
from physident.diagnosis.search.side_results import inside_baseline
from physident.diagnosis.statistics.stored_products import Key
from physident.effects.catalogue import effect_scope

ROUNDS = 3  # of forward search and removal: each round that changes something has raised the left-out gain
REPLACEMENTS = 3  # of several effects by one: each shortens the description, and what it replaced does not come back
HANDFUL = 5  # findings: an arm has one fault or two at a time; what takes more is a baseline that is wrong throughout


@dataclass(frozen=True, kw_only=True, eq=False)
class SearchResult:
    """The accepted effects, the ``first`` scores, and the ``last``, after which nothing more was accepted.

    ``overfull`` says that the search was stopped, because it went on finding more than a handful.
    """

    accepted: tuple[AcceptedEffect, ...]
    first: CandidateScores
    last: CandidateScores
    overfull: bool


def search_effects(
    problem: DiagnosisProblem,
    progress: Callable[[str], None] = lambda _: None,
    begun: Sequence[AcceptedEffect] = (),
) -> SearchResult:
    """Forward search with removal, from nothing or from effects with which it has ``begun``.

    Effects of an ordinary arm that the model lacks, such as friction, are accepted from the start, until removal shows that
    they add nothing: without them the error is so large that it hides rarer effects, or makes them look like common ones.
    """
    first = score_candidates(settled_hypothesis(problem, ()))
    problem, accepted = _without(problem, inside_baseline(first)), of_problem(problem, begun)
    if problem.missing_default_effects and not begun:
        names = dict.fromkeys(a.candidate.name for a in accepted)
        progress(f"added default effects that the model lacks: {', '.join(names)}")
    last, searched, replaced, rounds = None, problem, 0, 0
    tried: list[list[Key]] = []
    sized, pairs = frozenset[Key](), dict[Key, Key]()
    while rounds < ROUNDS:
        accepted, last = add_while_better(searched, accepted, first, progress)
        stays = (*problem.missing_default_effects, *succeeded_laws(last.hypothesis))
        found = find_replacement(last.hypothesis, stays) if replaced < REPLACEMENTS else None
        if found is not None:
            progress(f"{placed(found.accepted[-1])} in the place of {', '.join(map(placed, found.replaces))}")
            accepted, searched, replaced = (
                found.accepted,
                _without(searched, [one.candidate.key for one in found.replaces]),
                replaced + 1,
            )
            continue
        if pair := law_and_successor(last, pairs):
            progress(f"added {placed(pair[1])} in the place of {placed(pair[0])}")
            accepted, pairs = (*accepted, *pair), pairs | {pair[0].candidate.key: pair[1].candidate.key}
            continue
        uneven = uneven_scales(last.hypothesis)
        new = [one for one in uneven if one.candidate.key not in sized]
        if new and (shared := _with_share_of_most(last.hypothesis, new[0], first, progress)):
            accepted, sized = shared, sized | {new[0].candidate.key}
            continue
        if uneven:
            progress(f"removed {', '.join(map(placed, uneven))}: its joints differ by more than one scale lets them")
            accepted = tuple(a for a in last.hypothesis.accepted if a not in uneven)
            problem, searched = (_without(one, [a.candidate.key for a in uneven]) for one in (problem, searched))
            continue
        rounds += 1
        kept = _with_smaller(searched, without_redundant(searched, accepted, last), last)
        kept = _with_their_successors(pairs, accepted, kept)
        keys = [a.candidate.key for a in kept]
        if keys == [a.candidate.key for a in accepted] or keys in tried:  # what was removed came back, and would again
            break
        removed = [one for one in accepted if not any(one is other for other in kept)]
        added = [one for one in kept if not any(one is other for other in accepted)]
        instead = (
            f"fewer parameters do as well: {', '.join(map(placed, added))}" if added else "redundant beside the others"
        )
        progress(f"removed {', '.join(map(placed, removed))}: {instead}")
        accepted = kept
        tried.append(keys)
    assert last is not None
    if last.hypothesis.problem is not problem:  # what was replaced may be a rival
        last = replace(last, hypothesis=replace(last.hypothesis, problem=problem))
    overfull = count_findings(problem, last.hypothesis.accepted) > HANDFUL
    return SearchResult(accepted=last.hypothesis.accepted, first=first, last=last, overfull=overfull)


def of_problem(problem: DiagnosisProblem, begun: Sequence[AcceptedEffect]) -> tuple[AcceptedEffect, ...]:
    """Effects that a search of the same recordings has found, as candidates of a problem, or its missing default ones where there is none."""
    ordinary = {one.candidate.key: one for one in problem.missing_default_effects}
    places = {candidate.key: candidate for candidate in problem.candidates}
    return tuple(
        ordinary.get(one.candidate.key) or replace(one, candidate=places.get(one.candidate.key, one.candidate))
        for one in begun or problem.missing_default_effects
    )


def _without(problem: DiagnosisProblem, keys: Sequence[Key]) -> DiagnosisProblem:
    """The problem without some candidates, which the search would find again: those that one for many has replaced, scales that are
    none, and those inside the baseline, which show of a larger model only what was found, scaled, as if they stood in its place."""
    return replace(problem, barred=problem.barred | set(keys))


def count_findings(problem: DiagnosisProblem, accepted: Sequence[AcceptedEffect]) -> int:
    """How many findings some accepted effects make, the same effect on several joints as one; without the default effects that
    the model lacked, and without contacts, which say nothing about the baseline."""
    own = {one.candidate.key for one in problem.missing_default_effects}
    keys = [a.candidate.key for a in accepted if a.candidate is not CONTACT and a.candidate.key not in own]
    return len({name if effect_scope(name).joins_joints else (name, joints) for name, joints in keys})


def placed(accepted: AcceptedEffect) -> str:
    """An accepted effect and its place, in a message."""
    joints = ", ".join(map(str, accepted.candidate.joints))
    return f"{accepted.candidate.name} on {f'joint {joints}' if joints else 'the arm'}"


def settled_hypothesis(
    problem: DiagnosisProblem, accepted: Sequence[AcceptedEffect], before: Hypothesis | None = None
) -> Hypothesis:
    """The hypothesis of accepted effects whose columns are evaluated by the extended model itself.

    Candidates' columns stay those of a hypothesis ``before`` while the extended model's torque is near enough to it.
    """
    if before is None:
        plain = state_hypothesis(problem, accepted, problem.model)
        return plain if not accepted else state_hypothesis(problem, accepted, plain.extension.model)
    fresh = state_hypothesis(problem, accepted, before.model, before.data)
    model = fresh.extension.model
    return fresh if before.is_near(model) else state_hypothesis(problem, accepted, model)


def add_while_better(
    problem: DiagnosisProblem,
    accepted: tuple[AcceptedEffect, ...],
    first: CandidateScores,
    progress: Callable[[str], None],
) -> tuple[tuple[AcceptedEffect, ...], CandidateScores]:
    """Accept one candidate after the other; returns them with the last scores. The ``first`` ones are those beside nothing.

    What makes more than a handful of findings ends it, once each of them has all of its joints: which ones came before the last
    finding is chance, and a finding told of some of its joints alone is wrong about the others.
    """
    hypothesis, full = settled_hypothesis(problem, accepted), False
    scores = score_candidates(hypothesis) if accepted else rescore_candidates(hypothesis, first)
    while (chosen := _next_effect(scores, full)) is not None:
        accepted = (*accepted, chosen)
        progress(f"added {placed(chosen)}")
        hypothesis = settled_hypothesis(problem, accepted, hypothesis)
        if (sized := about_their_sizes(hypothesis)) != accepted:
            accepted, hypothesis = sized, settled_hypothesis(problem, sized, hypothesis)
        scores = rescore_candidates(hypothesis, scores)
        full = count_findings(problem, accepted) > HANDFUL
        if full or not is_beyond_doubt(scores):
            fresh = score_candidates(hypothesis)
            scores = replace(fresh, chance={**scores.chance, **fresh.chance})
    return accepted, scores


def _with_share_of_most(
    hypothesis: Hypothesis, scale: AcceptedEffect, first: CandidateScores, progress: Callable[[str], None]
) -> tuple[AcceptedEffect, ...]:
    """The accepted effects with an uneven scale at the share that most joints have in common, and what the other joints have of their
    own; empty where most have none in common.

    What was found on these was found beside a scale that took up part of it, and is found anew, beside one that fits all joints alike.
    """
    sized = at_share_of_most(hypothesis, scale)
    if sized is None:
        return ()
    progress(f"{placed(scale)}: sized by what most of its joints have in common")
    problem, others = hypothesis.problem, set(sized.held)
    even = replace(scale, effect=replace(sized, uneven_percent=None, held=()))
    kept = tuple(
        even if one is scale else one
        for one in hypothesis.accepted
        if not (one.candidate.joints and set(one.candidate.joints) <= others) or one in problem.missing_default_effects
    )
    if others:
        elsewhere = [c.key for c in problem.candidates if not (c.joints and set(c.joints) <= others)]
        kept, _ = add_while_better(_without(problem, elsewhere), kept, first, progress)
    return tuple(replace(one, effect=sized) if one is even else one for one in kept)


def _next_effect(scores: CandidateScores, full: bool) -> AcceptedEffect | None:
    """The contact or the candidate to accept next, its shape refined; where the search is ``full``, one more joint of what was found."""
    index = choose_candidate(_of_more_joints(scores) if full else scores)
    if not full and contact_accepted(scores, None if index is None else float(scores.gain[index])):
        return AcceptedEffect(CONTACT, refine_contact(scores.hypothesis, scores.contact.effect))
    if index is None:
        return None
    candidate = scores.hypothesis.data.candidates[index]
    return AcceptedEffect(candidate, refine_shape(scores.hypothesis, candidate))


def _of_more_joints(scores: CandidateScores) -> CandidateScores:
    """Scores of the candidates that make no new finding, and of placebos, none of the others."""
    names = {one.candidate.name for one in scores.hypothesis.accepted if effect_scope(one.candidate.name).joins_joints}
    same = [one.placebo or one.name in names for one in scores.hypothesis.data.candidates]
    return replace(scores, evidence_without_best_fold=np.where(same, scores.evidence_without_best_fold, -np.inf))


def _with_their_successors(
    pairs: Mapping[Key, Key], accepted: Sequence[AcceptedEffect], kept: tuple[AcceptedEffect, ...]
) -> tuple[AcceptedEffect, ...]:
    """The effects that are kept without the laws whose successors were accepted and are not kept: they have lost nothing."""
    gone = {one.candidate.key for one in accepted} - {one.candidate.key for one in kept}
    return tuple(one for one in kept if pairs.get(one.candidate.key) not in gone)


def without_redundant(
    problem: DiagnosisProblem, accepted: tuple[AcceptedEffect, ...], last: CandidateScores
) -> tuple[AcceptedEffect, ...]:
    """The accepted effects without those that no longer meet every condition beside all others. Those that any arm has stay, and nobody knows
    to be zero here, where others would take their part. Those of single joints are tried first: together they imitate one of the whole arm."""
    kept, ordinary = accepted, {one.candidate.key for one in problem.missing_default_effects}
    for one in sorted(accepted, key=lambda accepted: not accepted.candidate.joints):
        rest = tuple(a for a in kept if a is not one)
        # a single effect has just met the conditions, unless it was there from the start, or met them beside what is removed
        proven = len(accepted) == 1 and one.candidate.key not in ordinary
        if proven or one.candidate is CONTACT:
            continue
        hypothesis = state_hypothesis(problem, rest, last.hypothesis.model, last.hypothesis.data)
        gain = evidence_without_best_fold(hypothesis, one.candidate)
        if not (gain > last.threshold_of(one.candidate.key, rest) and is_admissible(hypothesis, one.candidate)):
            kept = rest
    return _with_undecided(problem, accepted, kept, last)


def _with_undecided(
    problem: DiagnosisProblem,
    accepted: Sequence[AcceptedEffect],
    kept: tuple[AcceptedEffect, ...],
    last: CandidateScores,
) -> tuple[AcceptedEffect, ...]:
    """What is kept, with the effects of any arm that were accepted and are lost, all of a name, where they decide the values of what is kept."""
    lost = [one for one in problem.missing_default_effects if one in accepted and one not in kept]
    undecided = with_no_successor(last.hypothesis, lost)
    for name in dict.fromkeys(one.candidate.name for one in undecided):
        both = tuple(one for one in accepted if one in kept or (one in undecided and one.candidate.name == name))
        alone, beside = (
            state_hypothesis(problem, some, last.hypothesis.model, last.hypothesis.data) for some in (kept, both)
        )
        kept = both if values_move(alone, beside) else kept
    return kept


def _with_smaller(
    problem: DiagnosisProblem, accepted: tuple[AcceptedEffect, ...], last: CandidateScores
) -> tuple[AcceptedEffect, ...]:
    """The accepted effects, each in turn replaced by smaller ones of its family where these do as well."""
    kept = accepted
    for one in accepted:
        rest = tuple(a for a in kept if a is not one)
        hypothesis = state_hypothesis(problem, rest, last.hypothesis.model, last.hypothesis.data)
        if smaller := smaller_of_family(hypothesis, one, last.threshold):
            kept = (*rest, *smaller)
    return kept
