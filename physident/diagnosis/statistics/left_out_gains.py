"""The gain of every candidate on rows that were left out while everything else was refitted.

The residual of the baseline is linear in the baseline's own columns, which move with every candidate, and in the
candidate's. Everything a split needs are products of these columns over a fold, so that hundreds of surrogate residuals
are judged at the price of one matrix product.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.baseline_fit import Fit
from physident.diagnosis.problem.search_data import OUTSIDE, Baseline, SearchData
from physident.diagnosis.statistics.baseline_products import BaselineProducts, ResponseProducts, response_products
from physident.diagnosis.statistics.normal_equations import pseudo_inverse
from physident.diagnosis.statistics.split import Class, Split, WeightedProducts, WeightedResponses

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LeftOutGains:
    """Squared weighted residuals in units of the noise, on rows that were left out: of the baseline, ``before`` (folds, n, S),
    and by how much each candidate lowers them, ``gain`` (candidates, folds, n, S); ``relief`` (candidates, folds, S): by how
    much the baseline contradicts its prior less with the candidate, fitted outside the fold; ``worth`` (n,) independent samples;
    ``visible`` (candidates,) the largest share over a candidate's shapes of its columns' energy outside the baseline."""

    before: Array
    gain: Array
    relief: Array
    worth: Array
    visible: Array

    @property
    def evidence(self) -> Array:
        """Evidence (candidates, S) for each candidate over all folds.

        A prior is what earlier rows said: they speak for a candidate too, where new rows contradict them without it.
        """
        return evidence_of(self.before.sum(axis=0), self.gain.sum(axis=1), self.worth) + self.relief.mean(axis=1)

    @property
    def evidence_without_best_fold(self) -> Array:
        """Evidence (candidates, S) without the fold that speaks most for a candidate."""
        before, gain = self.before.sum(axis=0), self.gain.sum(axis=1)
        every = [
            evidence_of(before - self.before[f], gain - self.gain[:, f], self.worth) + self.relief[:, f]
            for f in range(len(self.before))
        ]
        return np.min(every, axis=0)


def evidence_of(before: Array, gain: Array, worth: Array) -> Array:
    """Sum over joints (the last axis but one) of N log(before / after), N independent samples: a log likelihood ratio.

    A logarithm, because the residual that the noise is sized by holds the effect itself: what removes nearly all of it
    must count for more than what removes half.
    """
    after = np.maximum(before - gain, 1e-12 * np.maximum(before, 1e-300))
    return np.sum(worth[:, None] * np.log(np.maximum(before, 1e-300) / after), axis=-2)


def left_out_gains(
    data: SearchData,
    baseline: Baseline,
    fit: Fit,
    responses: Array | None = None,
    products: BaselineProducts | None = None,
) -> LeftOutGains:
    """What each candidate gains on left-out rows for responses (M, n, S), by default the data's own.

    Outside a fold the baseline is fitted with and without the candidate, whose shape is the one of the largest gain there;
    the gain is by how much the squared weighted residual inside the fold is smaller with it. ``products`` are those of data and
    baseline, where they are known.
    """
    judge = Judge(data, baseline, fit, products)
    return judge.gains(None if responses is None else judge.products_with(responses))


class Judge:
    """Judges candidates beside a fitted baseline by any responses; what does not depend on these is computed once."""

    def __init__(
        self, data: SearchData, baseline: Baseline, fit: Fit, products: BaselineProducts | None = None
    ) -> None:
        self.data, self.baseline, self.fit = data, baseline, fit
        self.products = BaselineProducts(data, baseline) if products is None else products
        every = [column for c in data.candidates for option in c.options for column in option.columns]
        self.columns = np.unique(every).astype(np.intp)
        self.classes = [Class(group, np.searchsorted(self.columns, group.columns)) for group in data.groups]
        inside, squares = self.products.own.inside, fit.weights**2
        BB, BC = self.products.BB[inside], self.products.BC(self.columns)[inside]
        CC = [self.products.CC(group.columns)[inside] for group in data.groups]
        for part in (BC, *CC):  # scaled in place: there are many candidates
            part *= squares.reshape(1, -1, *[1] * (part.ndim - 2))
        BB = BB * squares[:, None, None]
        sums = [part.sum(axis=1) for part in (BB, BC, *CC)]
        whole = [part.sum(axis=0) for part in sums]
        self.splits = []
        for f in range(len(inside)):
            train = [total - part[f] for total, part in zip(whole, sums, strict=True)]
            test = [WeightedProducts(BB[f, j], BC[f, j], tuple(one[f, j] for one in CC)) for j in range(len(squares))]
            rest = WeightedProducts(train[0], train[1], tuple(train[2:]))
            self.splits.append(Split(self.classes, rest, test, baseline.prior))
        self.visible = _visible_shares(len(data.candidates), self.classes, baseline, whole)

    def products_with(self, responses: Array) -> ResponseProducts:
        """The products of responses (M, n, S) that ``gains`` needs."""
        return response_products(self.products, responses, self.columns)

    def gains(self, responses: ResponseProducts | None = None) -> LeftOutGains:
        """What each candidate gains for responses, by default for the data's own."""
        own, data = self.products, self.data
        if responses is None:
            By, Cy, yy = own.By[..., None], own.Cy(self.columns)[..., None], own.yy[..., None]
        else:
            By, Cy, yy = responses.By, responses.Cy, responses.yy
        inside, squares = own.own.inside, self.fit.weights**2
        sums = [np.stack([_weighted(part[f], squares) for f in inside]) for part in (By, Cy, yy)]
        whole = [part.sum(axis=0) for part in sums]
        F, n, S = len(inside), len(squares), yy.shape[-1]
        before, gain = np.zeros((F, n, S)), np.zeros((len(data.candidates), F, n, S))
        relief = np.zeros((len(data.candidates), F, S))
        for at, (f, split) in enumerate(zip(inside, self.splits, strict=True)):
            train = WeightedResponses(*(total - part[at] for total, part in zip(whole, sums, strict=True)))
            test = [WeightedResponses(w2 * By[f, j], w2 * Cy[f, j], w2 * yy[f, j]) for j, w2 in enumerate(squares)]
            before[at], gain[:, at], relief[:, at] = split.judge(train, test, len(data.candidates))
        rows = data.regressor.counted[data.fold != OUTSIDE].sum(axis=0)
        return LeftOutGains(before, gain, relief, rows / self.fit.memory, self.visible)


def _weighted(products: Array, squares: Array) -> Array:
    """Products (n, ...) of the joints summed with ``squares`` (n,) of their weights, none of them copied."""
    total = squares[0] * products[0]
    for square, part in zip(squares[1:], products[1:], strict=True):
        total += square * part
    return total


def _visible_shares(count: int, classes: Sequence[Class], baseline: Baseline, whole: Sequence[Array]) -> Array:
    """For each candidate, the largest share over its shapes of its columns' energy outside the baseline; 0 where none."""
    BB, BC, *CC = whole
    Z = pseudo_inverse(BB + np.diag(baseline.prior)) @ BC
    result = np.zeros(count)
    for one, inner in zip(classes, CC, strict=True):
        size = np.trace(inner, axis1=1, axis2=2)
        outside = size - np.einsum("rok,rok->o", BC[:, one.columns], Z[:, one.columns])
        np.maximum.at(result, one.group.owner, np.where(size > 0, outside / np.where(size > 0, size, 1.0), 0.0))
    return result
