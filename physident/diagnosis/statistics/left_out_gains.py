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


def left_out_gains(data: SearchData, baseline: Baseline, fit: Fit, responses: Array) -> LeftOutGains:
    """What each candidate gains on left-out rows for responses (M, n, S).

    Outside a fold the baseline is fitted with and without the candidate, whose shape is the one of the largest gain there;
    the gain is by how much the squared weighted residual inside the fold is smaller with it.
    """
    labels = [int(f) for f in np.unique(data.fold) if f != OUTSIDE]
    products = [_products(data, baseline, fit.weights, responses, data.fold == f) for f in labels]
    sums = [_total(part) for part in products]
    whole = _total(sums)
    S, n = responses.shape[2], len(fit.weights)
    before = np.zeros((len(labels), n, S))
    gain = np.zeros((len(data.candidates), len(labels), n, S))
    relief = np.zeros((len(data.candidates), len(labels), S))
    for at, (part, left_out) in enumerate(zip(products, sums, strict=True)):
        before[at], gain[:, at], relief[:, at] = _left_out(data, whole - left_out, part, baseline.prior)
    rows = data.regressor.counted[data.fold != OUTSIDE].sum(axis=0)
    return LeftOutGains(before, gain, relief, rows / fit.memory, _visible_shares(data, baseline, whole))


def _visible_shares(data: SearchData, baseline: Baseline, products: _Products) -> Array:
    """For each candidate, the largest share over its shapes of its columns' energy outside the baseline; 0 where none."""
    Z = pseudo_inverse(products.BB + np.diag(baseline.prior)) @ products.BC
    result = np.zeros(len(data.candidates))
    for group, inner in zip(data.groups, products.CC, strict=True):
        size = np.trace(inner, axis1=1, axis2=2)
        outside = size - np.einsum("rok,rok->o", products.BC[:, group.columns], Z[:, group.columns])
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

    def __add__(self, other: _Products) -> _Products:
        return self._with(other, 1.0)

    def __sub__(self, other: _Products) -> _Products:
        return self._with(other, -1.0)

    def _with(self, other: _Products, sign: float) -> _Products:
        return _Products(
            self.BB + sign * other.BB, self.BC + sign * other.BC, self.By + sign * other.By, self.Cy + sign * other.Cy,
            self.yy + sign * other.yy, tuple(a + sign * b for a, b in zip(self.CC, other.CC, strict=True)),
        )  # fmt: skip


def _products(
    data: SearchData, baseline: Baseline, weights: Array, responses: Array, rows: NDArray[np.bool_]
) -> list[_Products]:
    """The products of each joint's rows."""
    R, P, S = len(baseline.prior), len(data.regressor.columns), responses.shape[2]
    result = []
    for j, (part, w) in enumerate(zip(data.regressor.joints, weights, strict=True)):
        B, C, y = w * baseline.joints[j][rows], w * part.values[rows], w * responses[rows, j]
        BC, Cy = np.zeros((R, P)), np.zeros((P, S))
        BC[:, part.columns], Cy[part.columns] = B.T @ C, C.T @ y
        padded = np.column_stack([C, np.zeros(len(C))]).T
        CC = []
        for group in data.groups:
            options, at = group.joints[j]
            inner = np.zeros((len(group.owner), group.columns.shape[1], group.columns.shape[1]))
            values = padded[at]  # (O, k, M)
            inner[options] = values @ values.transpose(0, 2, 1)
            CC.append(inner)
        result.append(_Products(B.T @ B, BC, B.T @ y, Cy, np.einsum("ms,ms->s", y, y), tuple(CC)))
    return result


def _total(products: Sequence[_Products]) -> _Products:
    whole = products[0]
    for one in products[1:]:
        whole = whole + one
    return whole


def _left_out(
    data: SearchData, train: _Products, test: Sequence[_Products], prior: Array
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
    for k, group in enumerate(data.groups):
        c = group.columns
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
