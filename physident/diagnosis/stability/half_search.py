"""The search on a half of the units: the same candidates, thresholds and physical signs, on stored products alone.

A half is too short to be left out of again: what an effect explains is computed on the rows that it is fitted to, less what as many
numbers explain of noise, which is what it would explain of rows that are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect, Candidate
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.search.physical_signs import physical_contradiction
from physident.diagnosis.search.thresholds import MIN_REDUCTION_PERCENT
from physident.diagnosis.statistics.product_fit import Chosen, ProductFit, best_alone, fit_chosen
from physident.diagnosis.statistics.stored_products import Key, StoredProducts

COMPARED = 20  # candidates of the most evidence, the first of which that meets every condition is taken
MORE = 5  # effects than the whole search found: a half that goes on beyond finds what the others do not


def search_half(
    stored: StoredProducts, units: Sequence[int] | NDArray[np.intp], whole: Hypothesis, threshold: float
) -> set[Key]:
    """The names and places of the effects that a forward search on some units accepts.

    It begins as the search on all units did, with the default effects that the model lacks, which count as found if they
    are evidence beside all others.
    """
    products = stored.over(units)
    start = [
        Chosen(a.candidate.key, *stored.options[a.candidate.key][0])
        for a in whole.problem.missing_default_effects
        if a.candidate.key in stored.options
    ]
    chosen, now = list(start), fit_chosen(stored, products, start, whole)
    while len(chosen) < len(start) + len(whole.accepted) + MORE:
        better = _next(stored, now, chosen, whole, threshold)
        if better is None:
            break
        chosen.append(better)
        now = fit_chosen(stored, products, chosen, whole, now.fit.sigma)
    kept = {
        one.key
        for one in start
        if _evidence(fit_chosen(stored, products, [c for c in chosen if c is not one], whole), now, one) > threshold
    }
    return kept | {one.key for one in chosen[len(start) :]}


def _next(
    stored: StoredProducts, now: ProductFit, chosen: Sequence[Chosen], whole: Hypothesis, threshold: float
) -> Chosen | None:
    """The effect of the largest gain that beats chance, is of use, and is physically possible."""
    for one in best_alone(stored, now, COMPARED, {c.key for c in chosen}):
        after = fit_chosen(stored, now.products, [*chosen, one], whole, now.fit.sigma)
        useful = 100 * np.max(1 - after.fit.sigma / now.fit.sigma) >= MIN_REDUCTION_PERCENT
        if not useful or _evidence(now, after, one) <= threshold:
            continue
        every = tuple(AcceptedEffect(Candidate(c.key[0], c.key[1], ()), c.effect) for c in (*chosen, one))
        if physical_contradiction(replace(whole, accepted=every, fit=after.fit)) is None:
            return one
    return None


def _evidence(before: ProductFit, after: ProductFit, one: Chosen) -> float:
    """The evidence for an effect, as on rows that were left out: twice its columns less, more where little is left to decide."""
    worth = before.products.worth
    free = float(worth.sum()) - after.fit.decided
    chance = 2 * len(one.columns) * float(worth.sum()) / max(free, 1.0)
    return float(np.sum(worth * 2 * np.log(before.fit.sigma / after.fit.sigma))) - chance
