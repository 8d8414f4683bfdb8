"""The search on a half of the units: the same gains, thresholds and physical signs, on stored products alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect, Candidate
from physident.diagnosis.problem.folds import FOLDS
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.search.physical_signs import physical_contradiction
from physident.diagnosis.search.thresholds import MIN_REDUCTION_PERCENT
from physident.diagnosis.statistics.left_out_gains import evidence_of
from physident.diagnosis.statistics.left_out_residuals import reduction_percent
from physident.diagnosis.statistics.normal_equations import pseudo_inverse, whitening
from physident.diagnosis.statistics.product_fit import Chosen, ProductFit, best_alone, fit_chosen
from physident.diagnosis.statistics.stored_products import Key, Products, StoredProducts

Array = NDArray[np.float64]
Columns = NDArray[np.intp]
COMPARED = 8  # candidates of the largest gain whose left-out gain is computed: the best one is among them


def search_half(
    stored: StoredProducts,
    units: Sequence[int] | NDArray[np.intp],
    whole: Hypothesis,
    threshold: float,
    rng: np.random.Generator,
) -> set[Key]:
    """The names and places of the effects that a forward search on some units accepts.

    It begins as the search on all units did, with the default effects that the model lacks, which count as found if they
    are evidence beside all others. No unit is in two of the folds.
    """
    units = rng.permutation(units)
    folds = [stored.over(part) for part in np.array_split(units, min(FOLDS[1], len(units)))]
    products = stored.over(units)
    start = [
        Chosen(a.candidate.key, *stored.options[a.candidate.key][0])
        for a in whole.problem.missing_default_effects
        if a.candidate.key in stored.options
    ]
    chosen, most = list(start), len(start) + len(whole.accepted) + COMPARED
    sigma = None
    while len(chosen) < most:
        state = fit_chosen(stored, products, chosen, whole, sigma)
        sigma = state.fit.sigma
        better = _next(stored, folds, state, chosen, whole, threshold)
        if better is None:
            break
        chosen.append(better)
    return {c.key for c in chosen[len(start) :]} | {
        one.key for one in start if _still_evidence(stored, products, folds, chosen, one, whole, threshold)
    }


def _next(
    stored: StoredProducts,
    folds: Sequence[Products],
    state: ProductFit,
    chosen: Sequence[Chosen],
    whole: Hypothesis,
    threshold: float,
) -> Chosen | None:
    """The effect of the largest left-out gain that beats chance, is of use, and is physically possible."""
    taken = {c.key for c in chosen}
    leaders = best_alone(stored, state, COMPARED, taken)
    if not leaders:
        return None
    before, gain = _left_out(folds, state, [c.columns for c in leaders])
    evidence = evidence_of(before.sum(axis=0), gain.sum(axis=1), state.products.worth)
    least = np.min(
        [
            evidence_of(before.sum(axis=0) - before[f], gain.sum(axis=1) - gain[:, f], state.products.worth)
            for f in range(len(folds))
        ],
        axis=0,
    )
    for i in np.argsort(-evidence[:, 0]):
        total = before.sum(axis=0)[:, 0]
        useful = reduction_percent(total, total - gain[i].sum(axis=0)[:, 0]) >= MIN_REDUCTION_PERCENT
        if least[i, 0] > threshold and useful and _is_possible(stored, state, chosen, leaders[i], whole):
            return leaders[i]
    return None


def _left_out(folds: Sequence[Products], state: ProductFit, options: Sequence[Columns]) -> tuple[Array, Array]:
    """Costs (F, n, 1) of the baseline and gains (options, F, n, 1) on each fold, of what the others decide."""
    every = np.concatenate([state.active, [state.response], *options]).astype(np.intp)
    R, squares = len(state.active), (state.fit.weights**2)[:, None, None]
    tests = [squares * fold.each(every, every) for fold in folds]
    whole = np.sum([test.sum(axis=0) for test in tests], axis=0)
    places = np.split(np.arange(R + 1, len(every)), np.cumsum([len(o) for o in options])[:-1])
    n = len(state.fit.weights)
    before, gain = np.zeros((len(folds), n, 1)), np.zeros((len(options), len(folds), n, 1))
    for f, test in enumerate(tests):
        train = whole - test.sum(axis=0)
        inverse = pseudo_inverse(train[:R, :R] + np.diag(state.prior))
        # what remains of the response and of each column when the baseline is fitted outside the fold
        left = np.zeros((len(every), len(every) - R))
        left[:R] = -inverse @ train[:R, R:]
        left[R:] = np.eye(len(every) - R)
        inner = train[R:, R:] + train[R:, :R] @ left[:R]
        apart = np.einsum("ra,jrs,sb->jab", left, test, left, optimize=True)
        before[f, :, 0] = apart[:, 0, 0]
        for i, place in enumerate(places):
            at = place - R
            root = whitening(train[np.ix_(place, place)][None], inner[np.ix_(at, at)][None])[0]
            theta = root @ (root.T @ inner[at, 0])
            gain[i, f, :, 0] = 2 * apart[:, 0, at] @ theta - np.einsum(
                "k,jkl,l->j", theta, apart[:, at][:, :, at], theta
            )
    return before, gain


def _is_possible(
    stored: StoredProducts, state: ProductFit, chosen: Sequence[Chosen], new: Chosen, whole: Hypothesis
) -> bool:
    """Whether the arm with one effect more can exist, by the values that the half gives it."""
    every = [*chosen, new]
    fit = fit_chosen(stored, state.products, every, whole, state.fit.sigma).fit
    accepted = tuple(AcceptedEffect(Candidate(c.key[0], c.key[1], ()), c.effect) for c in every)
    return physical_contradiction(replace(whole, accepted=accepted, model=whole.model, fit=fit)) is None


def _still_evidence(
    stored: StoredProducts,
    products: Products,
    folds: Sequence[Products],
    chosen: Sequence[Chosen],
    one: Chosen,
    whole: Hypothesis,
    threshold: float,
) -> bool:
    """Whether an effect that was there from the start explains more than chance beside all others."""
    state = fit_chosen(stored, products, [c for c in chosen if c is not one], whole, None)
    before, gain = _left_out(folds, state, [one.columns])
    return bool(evidence_of(before.sum(axis=0), gain.sum(axis=1), products.worth)[0, 0] > threshold)
