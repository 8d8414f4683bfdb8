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
ROUNDS = 8  # of weights, which settle to a few per cent: they set the power of the test, not its level
INSIDE = 1e-6  # share of a candidate direction outside the baseline below which its value is rounding and noise
RANK = 1e-12  # of the largest eigenvalue of the scaled normal matrix: the square of a singular value
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
    """A baseline fitted to all rows: values ``x`` (R,), ``residual`` (M, n) [N m|N], ``sigma`` (n,), the residual's
    ``memory`` (n,) in rows, ``freedom``: how many of the R values the data decided; ``normal`` (R, R), prior included."""

    x: Array
    residual: Array
    sigma: Array
    memory: Array
    freedom: float
    normal: Array

    @property
    def weights(self) -> Array:
        """What a joint's rows (n,) are multiplied by: a row counts as one over its noise and the noise's memory."""
        return 1 / (self.sigma * np.sqrt(self.memory))

    @property
    def deflation(self) -> Array:
        """By how much (n,) the residual is smaller than the noise, because the baseline was fitted to it."""
        worth = len(self.residual) / self.memory
        return np.sqrt(np.maximum(1 - self.freedom / len(worth) / worth, 0.5))


@dataclass(frozen=True, eq=False)
class Evidence:
    """Candidates' columns and the torque to explain, ``response`` (M, n) [N m|N], on common rows; ``fold`` (M,)."""

    regressor: Regressor
    candidates: tuple[Candidate, ...]
    response: Array
    fold: NDArray[np.intp]

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
    """Weighted least squares of a baseline over all rows, each joint by its own residual's size and memory."""
    y, counted = evidence.response, evidence.regressor.counted.sum(axis=0)
    floor = 1e-9 * max(1.0, float(np.abs(evidence.regressor.torque).max()))
    sigma, memory = np.maximum(np.sqrt((y**2).sum(axis=0) / counted), floor), np.ones(y.shape[1])
    R = len(baseline.prior)
    x, residual, freedom, H = np.zeros(R), y, 0.0, np.zeros((R, R))
    for _ in range(ROUNDS):
        weights = 1 / (sigma * np.sqrt(memory))
        data, slope = np.zeros((R, R)), np.zeros(R)
        for B, own, w in zip(baseline.joints, y.T, weights, strict=True):
            data += w * w * (B.T @ B)
            slope += w * w * (B.T @ own)
        H = data + np.diag(baseline.prior)
        inverse = inverted(H)
        x = inverse @ slope
        freedom = float(np.sum(inverse * data))
        residual = y - np.column_stack([B @ x for B in baseline.joints])
        left = np.maximum(counted - freedom / y.shape[1], counted / 2)
        after = np.maximum(np.sqrt((residual**2).sum(axis=0) / left), floor)
        memory = correlation_rows(evidence.regressor, residual)
        settled = np.allclose(after, sigma, rtol=0.02)
        sigma = after
        if settled:
            break
    return Fit(x, residual, sigma, memory, freedom, H)


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


def gains(evidence: Evidence, baseline: Baseline, weights: Array, responses: Array) -> Array:
    """Left-out gain (candidates, folds, S) of each candidate for responses (M, n, S), in units of the noise.

    Outside a fold the baseline is fitted with and without the candidate, whose shape is the one of the largest gain there;
    the gain is by how much the squared weighted residual inside the fold is smaller with it.
    """
    labels = [int(f) for f in np.unique(evidence.fold) if f != OUTSIDE]
    products = [_Products.of(evidence, baseline, weights, responses, evidence.fold == f) for f in labels]
    whole = products[0]
    for one in products[1:]:
        whole = whole + one
    result = np.zeros((len(evidence.candidates), len(labels), responses.shape[2]))
    for at, left_out in enumerate(products):
        result[:, at] = _left_out(evidence, whole - left_out, left_out, baseline.prior)
    return result


def shares(evidence: Evidence, baseline: Baseline, weights: Array) -> Array:
    """For each candidate, the largest share over its shapes of its columns' energy outside the baseline; 0 where none."""
    every = np.ones(len(evidence.fold), dtype=bool)
    products = _Products.of(evidence, baseline, weights, np.zeros((*evidence.response.shape, 1)), every)
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
    """Products over some rows: baseline BB (R, R), with candidates BC (R, P), with responses By (R, S), Cy (P, S), and
    those of each option's own columns, a (O, k, k) for each class."""

    BB: Array
    BC: Array
    By: Array
    Cy: Array
    CC: tuple[Array, ...]

    @staticmethod
    def of(
        evidence: Evidence, baseline: Baseline, weights: Array, responses: Array, rows: NDArray[np.bool_]
    ) -> _Products:
        R, P, S = len(baseline.prior), len(evidence.regressor.columns), responses.shape[2]
        BB, BC, By, Cy = np.zeros((R, R)), np.zeros((R, P)), np.zeros((R, S)), np.zeros((P, S))
        CC = [np.zeros((len(c.owner), c.columns.shape[1], c.columns.shape[1])) for c in evidence.classes]
        for j, (own, w) in enumerate(zip(evidence.regressor.joints, weights, strict=True)):
            B, C, y = w * baseline.joints[j][rows], w * own.values[rows], w * responses[rows, j]
            BB += B.T @ B
            By += B.T @ y
            BC[:, own.columns] += B.T @ C
            Cy[own.columns] += C.T @ y
            padded = np.column_stack([C, np.zeros(len(C))]).T
            for cls, inner in zip(evidence.classes, CC, strict=True):
                options, at = cls.joints[j]
                values = padded[at]  # (O, k, M)
                inner[options] += values @ values.transpose(0, 2, 1)
        return _Products(BB, BC, By, Cy, tuple(CC))

    def __add__(self, other: _Products) -> _Products:
        return self._with(other, 1.0)

    def __sub__(self, other: _Products) -> _Products:
        return self._with(other, -1.0)

    def _with(self, other: _Products, sign: float) -> _Products:
        return _Products(
            self.BB + sign * other.BB, self.BC + sign * other.BC, self.By + sign * other.By, self.Cy + sign * other.Cy,
            tuple(a + sign * b for a, b in zip(self.CC, other.CC, strict=True)),
        )  # fmt: skip


def _left_out(evidence: Evidence, train: _Products, test: _Products, prior: Array) -> Array:
    """Gain (candidates, S) on one fold of what the other folds decide."""
    inverse = inverted(train.BB + np.diag(prior))
    Z, x = inverse @ train.BC, inverse @ train.By
    slope = train.Cy - train.BC.T @ x
    moved = test.Cy - test.BC.T @ x - Z.T @ (test.By - test.BB @ x)
    through = test.BB @ Z
    result = np.zeros((len(evidence.candidates), slope.shape[1]))
    best = np.full_like(result, -np.inf)
    for cls, inside, outside in zip(evidence.classes, train.CC, test.CC, strict=True):
        c = cls.columns
        cross = np.einsum("rok,rol->okl", train.BC[:, c], Z[:, c], optimize=True)
        root = whitening(inside, inside - cross)
        theta = root @ (root.transpose(0, 2, 1) @ slope[c])
        seen = np.einsum("oks,oks->os", theta, slope[c])
        mixed = np.einsum("rok,rol->okl", test.BC[:, c], Z[:, c], optimize=True)
        apart = outside - mixed - mixed.transpose(0, 2, 1)
        apart += np.einsum("rok,rol->okl", Z[:, c], through[:, c], optimize=True)
        gain = 2 * np.einsum("oks,oks->os", theta, moved[c]) - np.einsum("oks,oks->os", theta, apart @ theta)
        for candidate in np.unique(cls.owner):
            own = np.flatnonzero(cls.owner == candidate)
            top = np.argmax(seen[own], axis=0)
            every = np.arange(seen.shape[1])
            better = seen[own][top, every] > best[candidate]
            best[candidate] = np.where(better, seen[own][top, every], best[candidate])
            result[candidate] = np.where(better, gain[own][top, every], result[candidate])
    return result


def whitening(inner: Array, outside: Array) -> Array:
    """Roots (O, k, k) of the inverse of ``outside`` (O, k, k), zero along directions inside the baseline."""
    size = np.sqrt(np.maximum(np.diagonal(inner, axis1=1, axis2=2), 1e-300))
    values, vectors = np.linalg.eigh(outside / (size[:, :, None] * size[:, None, :]))
    scale = np.where(values > INSIDE, 1 / np.sqrt(np.maximum(values, INSIDE)), 0.0)
    return vectors * scale[:, None, :] / size[:, :, None]


def inverted(H: Array) -> Array:
    """Inverse of a normal matrix (R, R), zero along directions that nothing decides."""
    if not len(H):
        return H
    size = np.sqrt(np.where(np.diag(H) > 0, np.diag(H), 1.0))
    values, vectors = np.linalg.eigh(H / np.outer(size, size))
    kept = values > RANK * values[-1]
    root = vectors[:, kept] / np.sqrt(values[kept]) / size[:, None]
    return root @ root.T


def without(evidence: Evidence, keys: set[tuple[str, tuple[int, ...]]]) -> Evidence:
    """The evidence with some candidates fewer."""
    return replace(evidence, candidates=tuple(c for c in evidence.candidates if c.key not in keys))
