"""The search: the best candidate that beats the surrogates joins, until none does; then each is tried for removal."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from physident.diagnosis.problem.candidates import Candidate
from physident.diagnosis.problem.problem import Case
from physident.diagnosis.search.acceptance import admitted, choose, touched
from physident.diagnosis.search.candidate_scores import Look, look
from physident.diagnosis.search.contact import CONTACT, placed
from physident.diagnosis.search.hypothesis import Accepted, State
from physident.diagnosis.search.shape_refinement import refined
from physident.diagnosis.statistics.left_out_gains import gains, shares
from physident.identifiability.visibility import VISIBLE

LOOPS = 3  # of forward search and removal: each loop that changes something has raised the left-out gain


@dataclass(frozen=True, eq=False)
class Search:
    """What was accepted and the ``last`` look, which found nothing more; the ``first``."""

    accepted: tuple[Accepted, ...]
    last: Look
    first: Look


def search(case: Case, progress: Callable[[str], None] = lambda _: None) -> Search:
    """Forward search with removal over a case.

    What every arm has and the model lacks, such as friction, is in from the start, until removal shows that it adds nothing:
    so much error hides what is rare, or makes it look like what is common.
    """
    accepted, first = case.lacking, None
    if accepted:
        first = look(settled(case, ()))
        progress(f"what every arm has: {', '.join(dict.fromkeys(a.candidate.name for a in accepted))}")
    last = None
    for _ in range(LOOPS):
        accepted, last, begun = _forward(case, accepted, progress)
        first = first or begun
        kept = _trimmed(case, accepted, last)
        if [a.candidate.key for a in kept] == [a.candidate.key for a in accepted]:
            break
        accepted = kept
    assert first is not None
    assert last is not None
    return Search(last.state.accepted, last, first)


def settled(case: Case, accepted: Sequence[Accepted], before: State | None = None) -> State:
    """The state beside accepted effects; columns that depend on a model are evaluated by the extended model.

    The columns of candidates stay those of a state ``before`` while the model's torque is near enough to it.
    """
    if before is None:
        before = case.state(accepted, case.model)
        return before if not accepted else case.state(accepted, before.extension.model)
    fresh = case.state(accepted, before.model, before.evidence)
    model = fresh.extension.model
    return fresh if before.near(model) else case.state(accepted, model)


def _forward(
    case: Case, accepted: tuple[Accepted, ...], progress: Callable[[str], None]
) -> tuple[tuple[Accepted, ...], Look, Look]:
    state = settled(case, accepted)
    first = None
    while True:
        now = look(state)
        first = first or now
        index = choose(now)
        if touched(now, None if index is None else float(now.gain[index])):
            chosen = Accepted(CONTACT, placed(state, now.contact.effect))
        elif index is None:
            return accepted, now, first
        else:
            candidate = state.evidence.candidates[index]
            chosen = Accepted(candidate, refined(state, candidate))
        accepted = (*accepted, chosen)
        joints = ", ".join(map(str, chosen.candidate.joints))
        progress(f"{chosen.candidate.name} on {joints or 'the arm'}")
        state = settled(case, accepted, state)


def _trimmed(case: Case, accepted: tuple[Accepted, ...], last: Look) -> tuple[Accepted, ...]:
    """The accepted effects without those whose left-out gain beside all others no longer passes every gate."""
    kept = accepted
    for one in accepted:
        rest = tuple(a for a in kept if a is not one)
        proven = not rest and not any(one is own for own in case.lacking)  # alone, it has just passed
        if proven or one.candidate is CONTACT:
            continue
        state = case.state(rest, last.state.model, last.state.evidence)
        if not (_least(state, one.candidate) > last.threshold and admitted(state, one.candidate)):
            kept = rest
    return kept


def _least(state: State, candidate: Candidate) -> float:
    """A candidate's evidence without the fold that speaks most for it; none where it lies inside the baseline."""
    alone = replace(state.evidence, candidates=(candidate,))
    if state.case.motionless(candidate) or shares(alone, state.baseline, state.fit.weights)[0] < VISIBLE:
        return 0.0
    return float(gains(alone, state.baseline, state.fit, alone.response[:, :, None]).least[0, 0])
