"""Candidates' columns beside a baseline on common rows: fitted, split into folds, counted by blocks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidate_groups import OptionClass
from physident.diagnosis.problem.candidates import Candidate
from physident.diagnosis.statistics.normal_equations import inverted
from physident.dynamics.regressor import Regressor
from physident.estimation.uncertainty import FEWEST_BLOCKS, block_labels

Array = NDArray[np.float64]
SETTLED = (
    0.95  # of a residual's size from one round of weights to the next: they set the power of the test, not its level
)
OUTSIDE = -1  # fold of a row in a gap between blocks
MEMORIES = 10  # correlation lengths in a block: what leaks over its edge is then a tenth of it
FOLDS = (4, 8)  # fewer leave too little to fit, more cost time and gain nothing


@dataclass(frozen=True, eq=False)
class Baseline:
    """Columns that are refitted with every candidate: for each joint (M, R), and their prior precision (R,), zero where
    nothing but these data decides; in units of the noise."""

    joints: tuple[Array, ...]
    prior: Array

    def joined(self, columns: Sequence[Array], precision: float = 0.0) -> Baseline:
        """The baseline with more columns, (M, k) for each joint, that only these data decide unless a ``precision`` is given."""
        joints = tuple(np.column_stack([own, more]) for own, more in zip(self.joints, columns, strict=True))
        return Baseline(joints, np.concatenate([self.prior, np.full(columns[0].shape[1], precision)]))


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
    def classes(self) -> list[OptionClass]:
        """Options gathered by their number of columns."""
        sizes = sorted({len(option.columns) for c in self.candidates for option in c.options})
        return [OptionClass.of(self.regressor, self.candidates, k) for k in sizes]

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


def noise(evidence: Evidence, baseline: Baseline) -> Fit:
    """What no candidate explains: the fit of all of them at once beside a baseline, each at the middle of its grid. A missing
    effect is part of the baseline's own residual, whose memory is the motion's."""
    middle = [c.options[len(c.options) // 2].columns for c in evidence.candidates if not c.placebo]
    every = baseline.joined(evidence.everywhere([column for columns in middle for column in columns]))
    return fit(evidence, every)


def folds(
    evidence: Evidence, baseline: Baseline, now: Fit, memory: float, recordings: int, seed: int
) -> NDArray[np.intp]:
    """The fold (M,) of each row: by recording from four on, unless one shows what no other does; else by blocks."""
    regressor = evidence.regressor
    if recordings >= FOLDS[0]:
        result = regressor.recording % FOLDS[1]
        if not _extrapolates(evidence, baseline, now, result):
            return result
    return _by_blocks(regressor, memory, seed)


def _by_blocks(regressor: Regressor, memory: float, seed: int) -> NDArray[np.intp]:
    """Blocks of ten memories with a gap of one between, dealt to the folds in turns whose order is drawn.

    Each fold then holds a bit of every part of the motion, and none in step with a motion that repeats.
    """
    length = min(math.ceil(MEMORIES * memory), len(regressor.segment) // FOLDS[0])
    labels = block_labels(regressor.segment, length)
    count = labels[-1] + 1
    k = min(FOLDS[1], count)
    rng = np.random.default_rng([seed, 23])
    dealt = np.concatenate([rng.permutation(k) for _ in range(math.ceil(count / k))])
    result = dealt[labels]
    gap = math.ceil(min(memory, length / MEMORIES))
    for label in range(1, count):
        rows = np.flatnonzero(labels == label)
        if regressor.segment[rows[0] - 1] == regressor.segment[rows[0]]:
            result[rows[:gap]] = OUTSIDE
    return result


def _extrapolates(evidence: Evidence, baseline: Baseline, now: Fit, fold: NDArray[np.intp]) -> bool:
    """Whether in some fold the baseline's own uncertainty, without that fold, is larger than the noise it is judged by."""
    counted = evidence.regressor.counted
    for f in np.unique(fold):
        rows = fold == f
        parts = [w * B[rows] for w, B in zip(now.weights, baseline.joints, strict=True)]
        H = np.sum([B.T @ B for B in parts], axis=0)
        if np.sum(H * inverted(now.normal - H)) > np.sum(counted[rows].sum(axis=0) / evidence.memory):
            return True
    return False


def blocks(evidence: Evidence, memory: float) -> NDArray[np.intp]:
    """Labels (M,) of the blocks that errors are counted by, within folds; OUTSIDE in gaps."""
    fold, segment = evidence.fold, evidence.regressor.segment
    inside = fold != OUTSIDE
    length = min(math.ceil(MEMORIES * memory), max(1, int(inside.sum()) // FEWEST_BLOCKS))
    runs = np.cumsum(np.append(False, (fold[1:] != fold[:-1]) | (segment[1:] != segment[:-1])))
    result = np.full(len(inside), OUTSIDE)
    result[inside] = block_labels(runs[inside], length)
    return result
