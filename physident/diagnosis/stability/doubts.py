"""What makes an accepted effect a hint: searches on halves that miss it, a sign that changes between recordings, and what it loses near reversals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from physident.diagnosis.grading.signs import OPPOSITE, changes_sign
from physident.diagnosis.result.wording import searches_in_words
from physident.diagnosis.rivals.rivals import RivalCheck
from physident.diagnosis.search.candidate_scores import CandidateScores
from physident.diagnosis.stability.reversals import LOST, loses_near_reversals
from physident.diagnosis.stability.stability import STABLE, stability_of
from physident.diagnosis.stability.trust import Trust
from physident.diagnosis.statistics.stored_products import Key
from physident.processes import mapped


def trust_in(
    first: CandidateScores,
    last: CandidateScores,
    checks: Sequence[RivalCheck],
    stands_for: Mapping[Key, Key] = MappingProxyType({}),
) -> dict[Key, Trust]:
    """The stability and the doubts of each accepted effect; it is found where the one is that it ``stands_for``."""
    shares = stability_of(first, last, checks, stands_for)

    def doubts(check: RivalCheck) -> tuple[str, ...]:
        share, found = shares[check.accepted.candidate.key], []
        if share is not None and share < STABLE:
            found.append(searches_in_words(share))
        if changes_sign(last.hypothesis, check.accepted):
            found.append(OPPOSITE)
        if loses_near_reversals(last.hypothesis, check.accepted):
            found.append(LOST)
        return tuple(found)

    each = zip(checks, mapped(doubts, checks), strict=True)
    return {check.accepted.candidate.key: Trust(shares[check.accepted.candidate.key], found) for check, found in each}
