"""The search on a half of the units: the same candidates, thresholds and physical signs, on stored products alone.

A half is too short to be left out of again: what an effect explains is computed on the rows that it is fitted to, less what as many
numbers explain of noise, which is what it would explain of rows that are left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect, Candidate, prior_precision
from physident.diagnosis.search.contact_scan import CONTACT
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.search.physical_signs import physical_contradiction
from physident.diagnosis.statistics.product_fit import Chosen, ProductFit, best_alone, fit_chosen
from physident.diagnosis.statistics.stored_products import Key, Products, StoredProducts
from physident.diagnosis.statistics.thresholds import MIN_REDUCTION_PERCENT

Array = NDArray[np.float64]

COMPARED = 20  # candidates of the most evidence, the first of which that meets every condition is taken
MORE = 5  # effects than the whole search found: a half that goes on beyond finds what the others do not


def search_half(
    stored: StoredProducts,
    units: Sequence[int] | NDArray[np.intp],
    whole: Hypothesis,
    threshold: float,
    lower: Mapping[Key, float],
) -> set[Key]:
    """The names and places of the effects that a forward search with removal accepts on some units.

    Each must explain more than a ``threshold``, or than one that is ``lower`` for some. It begins twice, with the default effects
    that the model lacks, as the search on all units did, and with what that search found, and the shorter description of the half
    wins: one wrong first step must not decide.
    """
    half = _Half(stored, stored.over(units), whole, {key: lower.get(key, threshold) for key in stored.options})
    own = {a.candidate.key for a in whole.problem.missing_default_effects}
    found = [
        Chosen(a.candidate.key, *stored.options[a.candidate.key][0])
        for a in whole.accepted
        if a.candidate is not CONTACT
    ]
    starts = [[one for one in found if one.key in own], found]
    ends = [half.without_redundant(half.with_more(start)) for start in starts]
    return {one.key for one in min(ends, key=half.length)}


@dataclass(frozen=True, eq=False)
class _Half:
    """A half of the units, searched for what a ``whole`` search found; each effect must explain more than its threshold."""

    stored: StoredProducts
    products: Products
    whole: Hypothesis
    thresholds: Mapping[Key, float]

    def fit(self, chosen: Sequence[Chosen], start: Array | None = None) -> ProductFit:
        """The joint fit of some effects."""
        return fit_chosen(self.stored, self.products, chosen, self.whole, start)

    def length(self, chosen: Sequence[Chosen]) -> float:
        """How long the description of the half by some effects is, each of which costs its threshold."""
        fit = self.fit(chosen)
        numbers = (
            float(fit.numbers[self.stored.baseline :].sum())
            if _held(chosen)
            else sum(len(one.columns) for one in chosen)
        )
        left = float(np.sum(self.products.worth * 2 * np.log(fit.fit.sigma)))
        return left + fit.contradicted + _chance(fit, numbers) + sum(self.thresholds[c.key] for c in chosen)

    def with_more(self, start: Sequence[Chosen]) -> list[Chosen]:
        """The effects of a start and what a forward search adds to them."""
        chosen, now = list(start), self.fit(start)
        while len(chosen) < len(self.whole.accepted) + MORE:
            better = _next(self.stored, now, chosen, self.whole, self.thresholds)
            if better is None:
                break
            chosen.append(better)
            now = self.fit(chosen, now.fit.sigma)
        return chosen

    def without_redundant(self, chosen: Sequence[Chosen]) -> list[Chosen]:
        """The effects without those that are no evidence beside the others, the least evident first."""
        kept = list(chosen)
        while kept:
            now = self.fit(kept)
            without = [self.fit([c for c in kept if c is not one], now.fit.sigma) for one in kept]
            worth = [_evidence(b, now, one) - self.thresholds[one.key] for b, one in zip(without, kept, strict=True)]
            if min(worth) > 0:
                break
            del kept[int(np.argmin(worth))]
        return kept


def _next(
    stored: StoredProducts,
    now: ProductFit,
    chosen: Sequence[Chosen],
    whole: Hypothesis,
    thresholds: Mapping[Key, float],
) -> Chosen | None:
    """The effect of the largest gain that beats chance, is of use, and is physically possible."""
    usual = whole.problem.taken_off_squares / np.maximum(whole.problem.regressor.counted.sum(axis=0), 1)
    for one in best_alone(stored, now, COMPARED, {c.key for c in chosen}):
        after = fit_chosen(stored, now.products, [*chosen, one], whole, now.fit.sigma)
        useful = (
            100 * np.max(1 - np.sqrt((after.fit.sigma**2 + usual) / (now.fit.sigma**2 + usual)))
            >= MIN_REDUCTION_PERCENT
        )
        if not useful or _evidence(now, after, one) <= thresholds[one.key]:
            continue
        every = tuple(AcceptedEffect(Candidate(c.key[0], c.key[1], ()), c.effect) for c in (*chosen, one))
        if physical_contradiction(replace(whole, accepted=every, fit=after.fit)) is None:
            return one
    return None


def _evidence(before: ProductFit, after: ProductFit, one: Chosen) -> float:
    """The evidence for an effect, as on rows that were left out: twice its columns less, more where little is left to decide. What
    earlier rows said of the model counts as in the search on all units."""
    worth = before.products.worth
    seen = float(np.sum(worth * 2 * np.log(before.fit.sigma / after.fit.sigma)))
    return seen + before.contradicted - after.contradicted - _chance(after, _numbers(after, one))


def _held(chosen: Sequence[Chosen]) -> bool:
    """Whether a prior holds the values of any effect."""
    return any(prior_precision(one.effect, len(one.columns)).any() for one in chosen)


def _numbers(fit: ProductFit, one: Chosen) -> float:
    """How many numbers an effect chooses in a fit: one a column, less where a prior holds them."""
    if not _held([one]):
        return len(one.columns)
    return float(fit.numbers[np.isin(fit.active, one.columns)].sum())


def _chance(fit: ProductFit, numbers: float) -> float:
    """What so many numbers explain of noise on the rows that they are fitted to, beyond rows that are left out."""
    whole = float(fit.products.worth.sum())
    return 2 * numbers * whole / max(whole - fit.fit.decided, 1.0)
