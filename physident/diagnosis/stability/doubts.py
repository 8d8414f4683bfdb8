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


def trust_in(
    first: CandidateScores,
    last: CandidateScores,
    checks: Sequence[RivalCheck],
    stands_for: Mapping[Key, Key] = MappingProxyType({}),
) -> dict[Key, Trust]:
    """The stability and the doubts of each accepted effect; it is found where the one is that it ``stands_for``."""
    shares, result = stability_of(first, last, checks, stands_for), {}
    for check in checks:
        key = check.accepted.candidate.key
        share, doubts = shares[key], []
        if share is not None and share < STABLE:
            doubts.append(searches_in_words(share))
        if changes_sign(last.hypothesis, check.accepted):
            doubts.append(OPPOSITE)
        if loses_near_reversals(last.hypothesis, check.accepted):
            doubts.append(LOST)
        result[key] = Trust(share, tuple(doubts))
    return result
