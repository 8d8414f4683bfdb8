"""How often searches on halves of the recordings find what the search on all of them found.

Source: Shah and Samworth, "Variable selection with error control: another look at stability selection" (2013): pairs of
halves that share no block.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.result.findings import SEARCHES
from physident.diagnosis.rivals.imitators import is_not_imitated
from physident.diagnosis.rivals.rivals import RivalCheck
from physident.diagnosis.search.candidate_scores import CandidateScores
from physident.diagnosis.search.contact_scan import CONTACT
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.stability.half_search import search_half
from physident.diagnosis.statistics.stored_products import Key, store_products
from physident.effects.catalogue import CATALOGUE
from physident.effects.learned.one_torque import are_one_torque, is_curve_of
from physident.effects.scales.shared_scale import SharedScale
from physident.identifiability.visibility import VISIBLE
from physident.processes import mapped

PAIRS = SEARCHES // 2
# by theorem 1 of the source, of effects that a search on a half finds with probability p or less, at most 5 p times as many
# pass as such a search names: what chance brings in once in a hundred is a twentieth as frequent
STABLE = 0.6
HALF = 0.5  # of the threshold: evidence grows with the rows, and what chance brings in more often is kept out by STABLE
FEWEST_UNITS = 4  # below, a half has nothing to leave out


def stability_of(
    first: CandidateScores,
    last: CandidateScores,
    checks: Sequence[RivalCheck],
    stands_for: Mapping[Key, Key] = MappingProxyType({}),
) -> dict[Key, float | None]:
    """For each accepted effect the share of 20 searches on halves that find it, a rival, a larger law that contains it, a learned curve of its
    torque or a law that it is the curve of, which a half is too short to tell apart, or what it ``stands_for``; None for a contact, which belongs to one time, for an effect of every arm that the model lacked, such as friction, which no search has chosen, and where the recordings are
    too short to be halved. Halves are searched for what the ``first`` scores could see."""
    hypothesis = last.hypothesis
    result: dict[Key, float | None] = {check.accepted.candidate.key: None for check in checks}
    ordinary = {one.candidate.key for one in hypothesis.problem.missing_default_effects}
    checks = [
        check
        for check in checks
        if check.accepted.candidate is not CONTACT and check.accepted.candidate.key not in ordinary
    ]
    if not checks:
        return result
    known = {c.key for c in first.hypothesis.data.candidates}
    later = {c.key for c in hypothesis.data.candidates if c.key not in known}  # what the search tried at its end alone
    stored = store_products(hypothesis, later | searched_in_halves(first, result))
    if stored.units < FEWEST_UNITS:
        return result
    rng = np.random.default_rng([hypothesis.problem.seed, 43])
    halves, half = [], stored.units // 2
    for _ in range(PAIRS):
        order = rng.permutation(stored.units)
        halves += [order[:half], order[half : 2 * half]]
    lower = {c.accepted.candidate.key: HALF * c.threshold for c in checks if c.threshold is not None}
    found = mapped(lambda units: search_half(stored, units, hypothesis, HALF * last.threshold, lower), halves)
    for check in checks:
        key = check.accepted.candidate.key
        same = {key, stands_for.get(key, key), *(other.key for other in (*check.rivals, *check.same, *check.larger))}
        same |= _scales_of_the_only_joint(hypothesis, check.accepted)
        laws = [key[0], *(name for name, joints in result if joints == key[1] and are_one_torque(name, key[0]))]
        result[key] = sum(bool(same & keys) or _as_a_curve(laws, key[1], keys) for keys in found) / len(found)
    return result


def _scales_of_the_only_joint(hypothesis: Hypothesis, accepted: AcceptedEffect) -> set[Key]:
    """What scales an arm of a single joint as a whole, of an accepted effect's family: a half is too short to tell the two apart."""
    if hypothesis.problem.model.robot.n > 1:
        return set()
    scales = [one for one in hypothesis.problem.candidates if isinstance(one.options[0].effect, SharedScale)]
    return {one.key for one in scales if CATALOGUE[one.name].family is accepted.effect.family}


def _as_a_curve(laws: Sequence[str], joints: tuple[int, ...], found: Collection[Key]) -> bool:
    """Whether a half ``found`` a learned curve in the place of a law of some joints, or of several ``laws`` that are one torque; or a law in the
    place of a curve."""
    return any(
        where == joints and (is_curve_of(name, law) or is_curve_of(law, name)) for name, where in found for law in laws
    )


def searched_in_halves(first: CandidateScores, found: Collection[Key]) -> set[Key]:
    """What the ``first`` scores could see, without what the whole search refused there as a leak between channels or a lag of friction, unless it
    was ``found`` in the end: a half is too short to tell, and would take it for what imitates it."""
    result = set()
    for index, candidate in enumerate(first.hypothesis.data.candidates):
        if first.visible_share[index] < VISIBLE:
            continue
        told = candidate.key not in found and not candidate.placebo and first.beats_chance(index)
        if not told or is_not_imitated(first.hypothesis, candidate):
            result.add(candidate.key)
    return result
