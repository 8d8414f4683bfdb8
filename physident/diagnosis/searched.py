"""What the search of a diagnosis ends with: every shape refined beside all others, and the placebos as proof of its thresholds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from physident.diagnosis.learned.search_and_learn import search_and_learn
from physident.diagnosis.problem.candidates import Candidate
from physident.diagnosis.problem.problem import DiagnosisProblem
from physident.diagnosis.result.findings import Placebo
from physident.diagnosis.rivals.same_torque import by_simpler, same_torque
from physident.diagnosis.search.candidate_scores import CandidateScores
from physident.diagnosis.search.forward_search import SearchResult, settled_hypothesis
from physident.diagnosis.search.hypothesis import Hypothesis, state_hypothesis
from physident.diagnosis.search.shape_refinement import refine_shape
from physident.diagnosis.search.side_results import placebos_of, refuse_if_placebos_pass
from physident.diagnosis.statistics.stored_products import Key
from physident.effects.scales.shared_scale import SharedScale


@dataclass(frozen=True, kw_only=True, eq=False)
class Searched:
    """What was ``found``, its ``last`` scores with every shape refined and every effect ``stands_for`` a simpler one, what makes the ``same``
    torque as each on any motion, and the ``placebos``."""

    found: SearchResult
    last: CandidateScores
    stands_for: dict[Key, Key]
    same: dict[Key, list[Candidate]]
    placebos: tuple[Placebo, ...]


def search_and_refine(problem: DiagnosisProblem, progress: Callable[[str], None]) -> Searched:
    found = search_and_learn(problem, progress)
    placebos = placebos_of(found.last)
    refuse_if_placebos_pass(placebos)
    problem = found.last.hypothesis.problem
    refined = _with_refined_shapes(problem, found)
    same = same_torque(refined)
    simpler, stands_for = by_simpler(refined, same)
    if stands_for:
        refined = settled_hypothesis(problem, simpler, refined)
        same = same_torque(refined)
    last = replace(found.last, hypothesis=refined)
    return Searched(found=found, last=last, stands_for=stands_for, same=same, placebos=placebos)


def _with_refined_shapes(problem: DiagnosisProblem, found: SearchResult) -> Hypothesis:
    """The last hypothesis with every shape refined beside all others, and all columns by the extended model."""
    accepted, last = list(found.accepted), found.last.hypothesis
    if not accepted:
        return last
    for i, one in enumerate(accepted):
        held = (
            isinstance(one.effect, SharedScale) and one.effect.held
        )  # beside what was found on the joints that it holds
        if len(one.candidate.options) > 1 and len(accepted) > 1 and not held:
            rest = state_hypothesis(problem, [*accepted[:i], *accepted[i + 1 :]], last.model, last.data)
            accepted[i] = replace(one, effect=refine_shape(rest, one.candidate))
    return settled_hypothesis(problem, accepted, last)
