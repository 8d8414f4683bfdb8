"""What recordings say for each candidate: the gain on rows that were left out while everything else was refitted.

The residual of the baseline is a linear model of the baseline's own columns, which move with every candidate, and of the
candidate's. Everything a split needs are products of these columns over a fold, so that hundreds of surrogate residuals
are judged at the price of one matrix product.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.candidates import Candidate
from physident.estimation.uncertainty import FEWEST_BLOCKS, block_labels, correlation_rows
from physident.regressor import Regressor

Array = NDArray[np.float64]
SETTLED = (
    0.95  # of a residual's size from one round of weights to the next: they set the power of the test, not its level
)
INSIDE = 1e-6  # share of a candidate direction outside the baseline below which its value is rounding and noise
RANK = 1e-10  # of the largest eigenvalue of the scaled normal matrix, the square of a singular value: below, rounding decides
ZERO = 1e-9  # of the largest column: a smaller one is rounding
OUTSIDE = -1  # fold of a row in a gap between blocks
MEMORIES = 10  # correlation lengths in a block: what leaks over its edge is then a tenth of it
FOLDS = (4, 8)  # fewer leave too little to fit, more cost time and gain nothing


@dataclass(frozen=True, eq=False)
class Baseline:
    """Columns that are refitted with every candidate: for each joint (M, R), and their prior precision (R,), zero where
    nothing but these data decides; in units of the noise."""

    joints: tuple[Array, ...]
    prior: Array

    def joined(self, columns: Sequence[Array]) -> Baseline:
        """The baseline with more columns, (M, k) for each joint, that only these data decide."""
        joints = tuple(np.column_stack([own, more]) for own, more in zip(self.joints, columns, strict=True))
        return Baseline(joints, np.concatenate([self.prior, np.zeros(columns[0].shape[1])]))


@dataclass(frozen=True, eq=False)
class Fit:
    """A baseline fitted to all rows: values ``x`` (R,), ``residual`` (M, n) [N m|N], ``sigma`` (n,) its size; ``weights``
    (n,) of the joints' rows in the fit; ``memory`` (n,) of the noise in rows; ``freedom``: how many of the R values the
    data decided; ``normal`` (R, R), prior included."""

    x: Array
    residual: Array
    sigma: Array
    weights: Array
    memory: Array
    freedom: float
    normal: Array

    @property
    def deflation(self) -> Array:
        """By how much (n,) the residual is smaller than the noise, because the baseline was fitted to it."""
        worth = len(self.residual) / self.memory
        return np.sqrt(np.maximum(1 - self.freedom / len(worth) / worth, 0.5))


@dataclass(frozen=True, eq=False)
class Evidence:
    """Candidates' columns and the torque to explain, ``response`` (M, n) [N m|N], on common rows; ``fold`` (M,) of each row;
    ``memory`` (n,) of the noise, in rows: so many count as one."""

    regressor: Regressor
    candidates: tuple[Candidate, ...]
    response: Array
    fold: NDArray[np.intp]
    memory: Array

    @cached_property
    def classes(self) -> list[_Class]:
        """Options gathered by their number of columns."""
        sizes = sorted({len(option.columns) for c in self.candidates for option in c.options})
        return [_Class.of(self, k) for k in sizes]

    def columns(self, joint: int, wanted: Sequence[int]) -> Array:
        """Values (M, k) of some columns in a joint's rows (index from 0), zero where they have none."""
        rows = self.regressor.joints[joint]
        at = {int(c): k for k, c in enumerate(rows.columns)}
        values = np.zeros((len(rows.values), len(wanted)))
        for k, c in enumerate(wanted):
            if c in at:
                values[:, k] = rows.values[:, at[c]]
        return values

    def everywhere(self, wanted: Sequence[int]) -> list[Array]:
        """Values (M, k) of some columns in each joint's rows."""
        return [self.columns(j, wanted) for j in range(len(self.regressor.joints))]


def fit(evidence: Evidence, baseline: Baseline) -> Fit:
    """Weighted least squares of a baseline over all rows: a row counts as one over its joint's residual and memory."""
    y, counted = evidence.response, evidence.regressor.counted.sum(axis=0)
    floor = 1e-9 * max(1.0, float(np.abs(evidence.regressor.torque).max()))
    sigma = np.maximum(np.sqrt((y**2).sum(axis=0) / counted), floor)
    squares = [B.T @ B for B in baseline.joints]
    slopes = [B.T @ own for B, own in zip(baseline.joints, y.T, strict=True)]
    while True:
        weights = 1 / (sigma * np.sqrt(evidence.memory))
        data = np.tensordot(weights**2, squares, 1)
        normal = data + np.diag(baseline.prior)
        inverse = inverted(normal)
        x = inverse @ np.tensordot(weights**2, slopes, 1)
        residual = y - np.column_stack([B @ x for B in baseline.joints])
        freedom = float(np.sum(inverse * data))
        left = np.maximum(counted - freedom / y.shape[1], counted / 2)
        after = np.maximum(np.sqrt((residual**2).sum(axis=0) / left), floor)
        if (
            after >= SETTLED * sigma
        ).all():  # each round only sharpens the joints that fit better than they were trusted
            return Fit(x, residual, after, weights, evidence.memory, freedom, normal)
        sigma = np.minimum(after, sigma)


def noise_memory(evidence: Evidence, baseline: Baseline) -> Array:
    """Memory (n,) in rows of what no candidate explains: the residual beside all of them at once, each at the middle of
    its grid. A missing effect is part of the baseline's own residual, whose memory is the motion's."""
    middle = [c.options[len(c.options) // 2].columns for c in evidence.candidates if not c.placebo]
    every = baseline.joined(evidence.everywhere([column for columns in middle for column in columns]))
    return correlation_rows(evidence.regressor, fit(evidence, every).residual)


def folds(regressor: Regressor, memory: float, recordings: int) -> NDArray[np.intp]:
    """The fold (M,) of each row: recordings from four on, else contiguous blocks with a gap of one memory between."""
    if recordings >= FOLDS[0]:
        return regressor.recording % FOLDS[1]
    total = len(regressor.segment)
    length = max(math.ceil(MEMORIES * memory), math.ceil(total / FOLDS[1]))
    length = min(length, total // FOLDS[0])
    labels = block_labels(regressor.segment, length)
    gap = math.ceil(min(memory, length / MEMORIES))
    result = labels.copy()
    for label in np.unique(labels)[1:]:
        rows = np.flatnonzero(labels == label)
        if rows[0] and regressor.segment[rows[0] - 1] == regressor.segment[rows[0]]:
            result[rows[:gap]] = OUTSIDE
    return result


def blocks(evidence: Evidence, memory: float) -> NDArray[np.intp]:
    """Labels (M,) of the blocks that errors are counted by, within folds; OUTSIDE in gaps."""
    inside = evidence.fold != OUTSIDE
    length = min(math.ceil(MEMORIES * memory), max(1, int(inside.sum()) // FEWEST_BLOCKS))
    pieces = evidence.fold + (evidence.fold.max() + 2) * evidence.regressor.segment
    result = np.full(len(inside), OUTSIDE)
    result[inside] = block_labels(pieces[inside], length)
    return result


@dataclass(frozen=True, eq=False)
class LeftOut:
    """Squared weighted residuals in units of the noise, on rows that were left out: of the baseline, ``before`` (folds, n, S),
    and by how much each candidate lowers them, ``gain`` (candidates, folds, n, S); ``worth`` (n,) independent samples."""

    before: Array
    gain: Array
    worth: Array

    @property
    def evidence(self) -> Array:
        """Evidence (candidates, S) for each candidate over all folds."""
        return evidence_of(self.before.sum(axis=0), self.gain.sum(axis=1), self.worth)

    @property
    def least(self) -> Array:
        """Evidence (candidates, S) without the fold that speaks most for a candidate."""
        before, gain = self.before.sum(axis=0), self.gain.sum(axis=1)
        every = [
            evidence_of(before - self.before[f], gain - self.gain[:, f], self.worth) for f in range(len(self.before))
        ]
        return np.min(every, axis=0)


def evidence_of(before: Array, gain: Array, worth: Array) -> Array:
    """Sum over joints (the last axis but one) of N log(before / after), N independent samples: a log likelihood ratio.

    A logarithm, because the residual that the noise is sized by holds the effect itself: what removes nearly all of it
    must count for more than what removes half.
    """
    after = np.maximum(before - gain, 1e-12 * np.maximum(before, 1e-300))
    return np.sum(worth[:, None] * np.log(np.maximum(before, 1e-300) / after), axis=-2)


def gains(evidence: Evidence, baseline: Baseline, now: Fit, responses: Array) -> LeftOut:
    """What each candidate gains on left-out rows for responses (M, n, S).

    Outside a fold the baseline is fitted with and without the candidate, whose shape is the one of the largest gain there;
    the gain is by how much the squared weighted residual inside the fold is smaller with it.
    """
    labels = [int(f) for f in np.unique(evidence.fold) if f != OUTSIDE]
    products = [_products(evidence, baseline, now.weights, responses, evidence.fold == f) for f in labels]
    sums = [_total(own) for own in products]
    whole = _total(sums)
    S, n = responses.shape[2], len(now.weights)
    before = np.zeros((len(labels), n, S))
    gain = np.zeros((len(evidence.candidates), len(labels), n, S))
    for at, (own, left_out) in enumerate(zip(products, sums, strict=True)):
        before[at], gain[:, at] = _left_out(evidence, whole - left_out, own, baseline.prior)
    rows = evidence.regressor.counted[evidence.fold != OUTSIDE].sum(axis=0)
    return LeftOut(before, gain, rows / now.memory)


def shares(evidence: Evidence, baseline: Baseline, weights: Array) -> Array:
    """For each candidate, the largest share over its shapes of its columns' energy outside the baseline; 0 where none."""
    every = np.ones(len(evidence.fold), dtype=bool)
    products = _total(_products(evidence, baseline, weights, np.zeros((*evidence.response.shape, 1)), every))
    Z = inverted(products.BB + np.diag(baseline.prior)) @ products.BC
    result = np.zeros(len(evidence.candidates))
    for cls, inner in zip(evidence.classes, products.CC, strict=True):
        size = np.trace(inner, axis1=1, axis2=2)
        outside = size - np.einsum("rok,rok->o", products.BC[:, cls.columns], Z[:, cls.columns])
        np.maximum.at(result, cls.owner, np.where(size > 0, outside / np.where(size > 0, size, 1.0), 0.0))
    return result


@dataclass(frozen=True, eq=False)
class _Class:
    """Options with k columns each: ``columns`` (O, k), their candidate's index ``owner`` (O,) and own index ``place``;
    for each joint, which of them have rows there and at which place among the joint's columns."""

    columns: NDArray[np.intp]
    owner: NDArray[np.intp]
    place: NDArray[np.intp]
    joints: tuple[tuple[NDArray[np.intp], NDArray[np.intp]], ...]

    @staticmethod
    def of(evidence: Evidence, k: int) -> _Class:
        found = [
            (option.columns, i, o)
            for i, c in enumerate(evidence.candidates)
            for o, option in enumerate(c.options)
            if len(option.columns) == k
        ]
        columns = np.array([f[0] for f in found], dtype=np.intp)
        joints = []
        for rows in evidence.regressor.joints:
            at = np.full(len(evidence.regressor.columns), len(rows.columns))
            at[rows.columns] = np.arange(len(rows.columns))
            own = np.flatnonzero((at[columns] < len(rows.columns)).any(axis=1))
            joints.append((own, at[columns[own]]))
        return _Class(columns, np.array([f[1] for f in found]), np.array([f[2] for f in found]), tuple(joints))


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
    evidence: Evidence, baseline: Baseline, weights: Array, responses: Array, rows: NDArray[np.bool_]
) -> list[_Products]:
    """The products of each joint's rows."""
    R, P, S = len(baseline.prior), len(evidence.regressor.columns), responses.shape[2]
    result = []
    for j, (own, w) in enumerate(zip(evidence.regressor.joints, weights, strict=True)):
        B, C, y = w * baseline.joints[j][rows], w * own.values[rows], w * responses[rows, j]
        BC, Cy = np.zeros((R, P)), np.zeros((P, S))
        BC[:, own.columns], Cy[own.columns] = B.T @ C, C.T @ y
        padded = np.column_stack([C, np.zeros(len(C))]).T
        CC = []
        for cls in evidence.classes:
            options, at = cls.joints[j]
            inner = np.zeros((len(cls.owner), cls.columns.shape[1], cls.columns.shape[1]))
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


def _left_out(evidence: Evidence, train: _Products, test: Sequence[_Products], prior: Array) -> tuple[Array, Array]:
    """Costs (n, S) of the baseline on one fold by joint, and gains (candidates, n, S) of what the other folds decide."""
    inverse = inverted(train.BB + np.diag(prior))
    Z, x = inverse @ train.BC, inverse @ train.By
    slope = train.Cy - train.BC.T @ x
    moved, through = [], []
    for own in test:
        moved.append(own.Cy - own.BC.T @ x - Z.T @ (own.By - own.BB @ x))
        through.append(0.5 * (own.BB @ Z) - own.BC)
    n, S = len(test), slope.shape[1]
    before = np.array([own.yy - 2 * np.sum(x * own.By, axis=0) + np.sum(x * (own.BB @ x), axis=0) for own in test])
    result = np.zeros((len(evidence.candidates), n, S))
    best = np.full((len(evidence.candidates), S), -np.inf)
    every = np.arange(S)
    for k, cls in enumerate(evidence.classes):
        c = cls.columns
        Zc = np.moveaxis(Z[:, c], 0, 2)  # (O, k, R)
        cross = Zc @ np.moveaxis(train.BC[:, c], 0, 1)
        root = whitening(train.CC[k], train.CC[k] - cross)
        theta = root @ (root.transpose(0, 2, 1) @ slope[c])
        seen = np.einsum("oks,oks->os", theta, slope[c])
        gain = np.empty((n, *seen.shape))
        for j, own in enumerate(test):
            half = Zc @ np.moveaxis(through[j][:, c], 0, 1)
            apart = own.CC[k] + half + half.transpose(0, 2, 1)
            gain[j] = 2 * np.einsum("oks,oks->os", theta, moved[j][c]) - np.einsum("oks,oks->os", theta, apart @ theta)
        for candidate in np.unique(cls.owner):
            mine = np.flatnonzero(cls.owner == candidate)
            top = mine[np.argmax(seen[mine], axis=0)]
            better = seen[top, every] > best[candidate]
            best[candidate] = np.where(better, seen[top, every], best[candidate])
            result[candidate] = np.where(better, gain[:, top, every], result[candidate])
    return before, result


def whitening(inner: Array, outside: Array) -> Array:
    """Roots (O, k, k) of the inverse of ``outside`` (O, k, k), zero along directions inside the baseline."""
    size = np.sqrt(np.diagonal(inner, axis1=1, axis2=2))
    size = np.where(size > ZERO * np.maximum(size.max(axis=1, keepdims=True), 1e-300), size, np.inf)
    values, vectors = np.linalg.eigh(outside / (size[:, :, None] * size[:, None, :]))
    scale = np.where(values > INSIDE, 1 / np.sqrt(np.maximum(values, INSIDE)), 0.0)
    return vectors * scale[:, None, :] / size[:, :, None]


def inverted(H: Array) -> Array:
    """Inverse of a normal matrix (R, R), zero along directions that nothing decides."""
    if not len(H):
        return H
    size = np.sqrt(np.diag(H))
    size = np.where(size > ZERO * size.max(), size, np.inf)
    values, vectors = np.linalg.eigh(H / np.outer(size, size))
    kept = values > RANK * values[-1]
    root = vectors[:, kept] / np.sqrt(values[kept]) / size[:, None]
    return root @ root.T


def without(evidence: Evidence, keys: set[tuple[str, tuple[int, ...]]]) -> Evidence:
    """The evidence with some candidates fewer."""
    return replace(evidence, candidates=tuple(c for c in evidence.candidates if c.key not in keys))
