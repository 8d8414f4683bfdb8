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
from physident.diagnosis.statistics.normal_equations import pseudo_inverse, whitening

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
    responses: Array | ResponseProducts | None = None,
    products: BaselineProducts | None = None,
) -> LeftOutGains:
    """What each candidate gains on left-out rows for responses (M, n, S), or their products with ``candidate_columns``; by default for
    the data's own.

    Outside a fold the baseline is fitted with and without the candidate, whose shape is the one of the largest gain there;
    the gain is by how much the squared weighted residual inside the fold is smaller with it. ``products`` are those of data and baseline,
    where they are known.
    """
    products = BaselineProducts(data, baseline) if products is None else products
    columns = candidate_columns(data)
    groups = [np.searchsorted(columns, group.columns) for group in data.groups]
    folds = _folds(products, columns, [group.columns for group in data.groups], fit.weights, responses)
    whole = _total([_total(part) for part in folds])
    S = folds[0][0].yy.shape[-1]
    n = len(fit.weights)
    before = np.zeros((len(folds), n, S))
    gain = np.zeros((len(data.candidates), len(folds), n, S))
    relief = np.zeros((len(data.candidates), len(folds), S))
    for at, part in enumerate(folds):
        before[at], gain[:, at], relief[:, at] = _left_out(data, groups, whole - _total(part), part, baseline.prior)
    rows = data.regressor.counted[data.fold != OUTSIDE].sum(axis=0)
    return LeftOutGains(before, gain, relief, rows / fit.memory, _visible_shares(data, groups, baseline, whole))


def candidate_columns(data: SearchData) -> NDArray[np.intp]:
    """The data's columns (P,) that belong to any candidate, in order."""
    return np.unique([column for c in data.candidates for option in c.options for column in option.columns]).astype(np.intp)


def _visible_shares(
    data: SearchData, groups: Sequence[NDArray[np.intp]], baseline: Baseline, products: _Products
) -> Array:
    """For each candidate, the largest share over its shapes of its columns' energy outside the baseline; 0 where none."""
    Z = pseudo_inverse(products.BB + np.diag(baseline.prior)) @ products.BC
    result = np.zeros(len(data.candidates))
    for group, c, inner in zip(data.groups, groups, products.CC, strict=True):
        size = np.trace(inner, axis1=1, axis2=2)
        outside = size - np.einsum("rok,rok->o", products.BC[:, c], Z[:, c])
        np.maximum.at(result, group.owner, np.where(size > 0, outside / np.where(size > 0, size, 1.0), 0.0))
    return result


@dataclass(frozen=True, eq=False)
class _Products:
    """Products over some rows: baseline BB (R, R), with candidates BC (R, P), with responses By (R, S), Cy (P, S), yy (S,),
    and those of each option's own columns, a (O, k, k) for each class."""

    BB: Array
    BC: Array
    By: Array
    Cy: Array
    yy: Array
    CC: tuple[Array, ...]

    def __sub__(self, other: _Products) -> _Products:
        return _Products(
            self.BB - other.BB, self.BC - other.BC, self.By - other.By, self.Cy - other.Cy,
            self.yy - other.yy, tuple(a - b for a, b in zip(self.CC, other.CC, strict=True)),
        )  # fmt: skip


def _folds(
    products: BaselineProducts,
    columns: NDArray[np.intp],
    options: Sequence[NDArray[np.intp]],
    weights: Array,
    responses: Array | ResponseProducts | None,
) -> list[list[_Products]]:
    """The products of each joint's rows over each fold."""
    if responses is None:
        By, Cy, yy = products.By[..., None], products.Cy(columns)[..., None], products.yy[..., None]
    else:
        given = responses if isinstance(responses, ResponseProducts) else response_products(products, responses, columns)
        By, Cy, yy = given.By, given.Cy, given.yy
    BB, BC, CC = products.BB, products.BC(columns), [products.CC(one) for one in options]
    return [
        [
            _Products(
                w2 * BB[f, j], w2 * BC[f, j], w2 * By[f, j], w2 * Cy[f, j], w2 * yy[f, j], tuple(w2 * one[f, j] for one in CC)
            )
            for j, w2 in enumerate(weights**2)
        ]
        for f in products.own.inside
    ]


def _total(products: Sequence[_Products]) -> _Products:
    return _Products(
        *(np.sum([getattr(one, name) for one in products], axis=0) for name in ("BB", "BC", "By", "Cy", "yy")),
        tuple(np.sum(parts, axis=0) for parts in zip(*(one.CC for one in products), strict=True)),
    )


def _left_out(
    data: SearchData,
    groups: Sequence[NDArray[np.intp]],
    train: _Products,
    test: Sequence[_Products],
    prior: Array,
) -> tuple[Array, Array, Array]:
    """Costs (n, S) of the baseline on one fold by joint, gains (candidates, n, S) of what the other folds decide, and by how much
    (candidates, S) their baseline contradicts its prior less with each candidate."""
    inverse = pseudo_inverse(train.BB + np.diag(prior))
    Z, x = inverse @ train.BC, inverse @ train.By
    slope = train.Cy - train.BC.T @ x
    moved, through = [], []
    for part in test:
        moved.append(part.Cy - part.BC.T @ x - Z.T @ (part.By - part.BB @ x))
        through.append(0.5 * (part.BB @ Z) - part.BC)
    n, S = len(test), slope.shape[1]
    before = np.array([part.yy - 2 * np.sum(x * part.By, axis=0) + np.sum(x * (part.BB @ x), axis=0) for part in test])
    result, relief = np.zeros((len(data.candidates), n, S)), np.zeros((len(data.candidates), S))
    contradicted = prior[:, None] * x
    best = np.full((len(data.candidates), S), -np.inf)
    every = np.arange(S)
    for k, (group, c) in enumerate(zip(data.groups, groups, strict=True)):
        Zc = np.moveaxis(Z[:, c], 0, 2)  # (O, k, R)
        cross = Zc @ np.moveaxis(train.BC[:, c], 0, 1)
        root = whitening(train.CC[k], train.CC[k] - cross + group.prior_normal)
        theta = root @ (root.transpose(0, 2, 1) @ slope[c])
        seen = np.einsum("oks,oks->os", theta, slope[c])
        gain = np.empty((n, *seen.shape))
        for j, part in enumerate(test):
            half = Zc @ np.moveaxis(through[j][:, c], 0, 1)
            apart = part.CC[k] + half + half.transpose(0, 2, 1)
            gain[j] = 2 * np.einsum("oks,oks->os", theta, moved[j][c]) - np.einsum("oks,oks->os", theta, apart @ theta)
        pulled = Zc @ contradicted  # (O, k, S)
        held = Zc @ (prior[:, None] * np.swapaxes(Zc, 1, 2))
        eased = 2 * np.einsum("oks,oks->os", theta, pulled) - np.einsum("oks,oks->os", theta, held @ theta)
        for candidate in np.unique(group.owner):
            mine = np.flatnonzero(group.owner == candidate)
            top = mine[np.argmax(seen[mine], axis=0)]
            better = seen[top, every] > best[candidate]
            best[candidate] = np.where(better, seen[top, every], best[candidate])
            result[candidate] = np.where(better, gain[:, top, every], result[candidate])
            relief[candidate] = np.where(better, eased[top, every], relief[candidate])
    return before, result, relief
