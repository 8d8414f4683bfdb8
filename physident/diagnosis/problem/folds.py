"""Which rows are left out together: folds by recording or by blocks, and the blocks that errors are counted by."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.baseline_fit import Fit
from physident.diagnosis.problem.search_data import OUTSIDE, Baseline, SearchData
from physident.diagnosis.statistics.normal_equations import pseudo_inverse
from physident.dynamics.regressor import Regressor
from physident.estimation.uncertainty import FEWEST_BLOCKS, block_labels
from physident.large_arrays import steps

MEMORIES = 10  # correlation lengths in a block: what leaks over its edge is then a tenth of it
MOST_BLOCKS = 256  # errors from more are no surer, and what is computed of each block takes memory
FOLDS = (4, 8)  # fewer leave too little to fit, more cost time and gain nothing


def split_into_folds(
    data: SearchData, baseline: Baseline, fit: Fit, memory: float, recordings: int, seed: int
) -> NDArray[np.intp]:
    """The fold (M,) of each row: by recording from four on, unless one shows what no other does; else by blocks."""
    regressor = data.regressor
    if recordings >= FOLDS[0]:
        result = regressor.recording % FOLDS[1]
        if not _extrapolates(data, baseline, fit, result):
            return result
    return _by_blocks(regressor, memory, seed)


def leaves_out_recordings(fold: NDArray[np.intp], recording: NDArray[np.intp]) -> bool:
    """Whether recordings (M,) are left out as a whole in the fold (M,) of each row, so that what holds there holds on unseen ones."""
    return all(len(np.unique(fold[recording == one])) == 1 for one in np.unique(recording)) and len(np.unique(fold)) > 1


def _by_blocks(regressor: Regressor, memory: float, seed: int) -> NDArray[np.intp]:
    """Blocks of ten memories with a gap of one between, dealt to the folds in turns whose order is drawn.

    Each fold then holds a bit of every part of the motion, and none in step with a motion that repeats.
    """
    total = len(regressor.segment)
    length = min(max(math.ceil(MEMORIES * memory), math.ceil(total / MOST_BLOCKS)), total // FOLDS[0])
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


def _extrapolates(data: SearchData, baseline: Baseline, fit: Fit, fold: NDArray[np.intp]) -> bool:
    """Whether in some fold the baseline's own uncertainty, without that fold, is larger than the noise it is judged by."""
    counted = data.regressor.counted
    for f in np.unique(fold):
        rows = fold == f
        H = np.zeros_like(fit.normal)
        for some in steps(len(fold)):
            mine = np.flatnonzero(rows[some]) + some.start
            for w, B in zip(fit.weights, baseline.joints, strict=True):
                H += w**2 * (B[mine].T @ B[mine])
        if np.sum(H * pseudo_inverse(fit.normal - H)) > np.sum(counted[rows].sum(axis=0) / data.memory):
            return True
    return False


def blocks(data: SearchData, memory: float) -> NDArray[np.intp]:
    """Labels (M,) of the blocks that errors are counted by, within folds; OUTSIDE in gaps."""
    fold, segment = data.fold, data.regressor.segment
    inside = fold != OUTSIDE
    total = int(inside.sum())
    wanted = max(math.ceil(MEMORIES * memory), math.ceil(total / MOST_BLOCKS))
    length = min(wanted, max(1, total // FEWEST_BLOCKS))
    runs = np.cumsum(np.append(False, (fold[1:] != fold[:-1]) | (segment[1:] != segment[:-1])))
    result = np.full(len(inside), OUTSIDE)
    result[inside] = block_labels(runs[inside], length)
    return result
