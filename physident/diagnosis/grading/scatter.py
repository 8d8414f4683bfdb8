"""How uncertain the size of an effect is: by its scatter over blocks of rows, and between recordings of one healthy arm."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.statistics.normal_equations import INSIDE, pseudo_inverse
from physident.dynamics.regressor import Regressor
from physident.estimation.uncertainty import block_labels, correlation_rows

Array = NDArray[np.float64]
BLOCK = 4.0  # times the memory of what rows add to a difference: blocks are then nearly independent
FEWEST = 8  # blocks, below which their scatter says little


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """The ``variance`` of an effect's size between recordings, beyond what noise makes of it, from ``count`` of them."""

    variance: float
    count: int


ALIKE = Scatter(variance=0.0, count=1)


def block_variances(push: Array, segment: NDArray[np.intp], parts: Sequence[Regressor]) -> Iterator[tuple[float, int]]:
    """The variance of a sum to which each row adds ``push`` (M,), and the number of blocks that it is of, for blocks of every length.

    Errors of a model last as long as a motion does, and noise as long as the filter: blocks from the latter's length up to an
    eighth of the rows, or whole segments, are tried. ``segment`` (M,) labels contiguous rows, ``parts`` have the rows in order.
    """
    ends = np.cumsum([0, *(len(part.segment) for part in parts)])
    memory = max(
        float(correlation_rows(one, push[a:b, None])[0]) for one, (a, b) in zip(parts, pairwise(ends), strict=True)
    )
    length, tried = max(1, round(BLOCK * memory)), 0
    while True:
        labels = block_labels(segment, length)
        blocks = int(labels.max()) + 1
        # blocks do not cross segments: of many recordings there are never fewer than these
        if tried and (blocks < FEWEST or (blocks == tried and length > len(segment))):
            return
        tried = blocks
        yield float(np.sum(np.bincount(labels, push) ** 2)) * blocks / max(blocks - 1, 1), blocks
        length *= 2


def scatter_between(
    rows: Regressor, columns: Sequence[Array], torque: Sequence[Array], effect: Sequence[Array]
) -> Scatter:
    """By how much the size of an effect differs between the recordings of some ``rows``, beyond what noise makes of it.

    Each recording is held against the others: all parameters, whose ``columns`` (M, p) of each joint are in units of its noise,
    as the ``torque`` (M,), are common, and the size of the ``effect`` (M,) may differ. What is left where every recording has a
    size of its own is noise. Source: the moment estimator of a random effect, DerSimonian and Laird, "Meta-analysis in clinical
    trials" (1986).
    """
    masks = [rows.recording == recording for recording in np.unique(rows.recording)]
    own = [[c * mask for mask in masks] for c in effect]
    inverse, left = _fitted(columns, torque)
    noise = _fitted([np.column_stack([A, *parts]) for A, parts in zip(columns, own, strict=True)], torque)[1]
    found = []
    for parts in zip(*own, strict=True):
        moved = inverse @ np.sum([A.T @ c for A, c in zip(columns, parts, strict=True)], axis=0)
        apart = [c - A @ moved for A, c in zip(columns, parts, strict=True)]
        size = sum(float(c @ c) for c in apart)
        if size <= INSIDE * sum(float(c @ c) for c in parts):
            continue  # this recording does not show the effect apart from all else
        difference = sum(float(c @ r) for c, r in zip(apart, left, strict=True)) / size
        push = np.sum([c * r for c, r in zip(apart, noise, strict=True)], axis=0) / size
        found.append((difference, max(variance for variance, _ in block_variances(push, rows.segment, [rows]))))
    if len(found) < 2:
        return ALIKE
    differences, variances = np.array(found).T
    weights = 1 / np.maximum(variances, 1e-300)
    beyond = float(np.sum(weights * differences**2 - 1)) / float(weights.sum())
    # a recording differs from the others by its own deviation and by theirs
    return Scatter(variance=max(0.0, beyond) * (len(found) - 1) / len(found), count=len(found))


def _fitted(columns: Sequence[Array], torque: Sequence[Array]) -> tuple[Array, list[Array]]:
    """The inverse of the normal matrix of all joints' columns, and what they leave (M,) of each joint's torque."""
    inverse = pseudo_inverse(np.sum([A.T @ A for A in columns], axis=0))
    x = inverse @ np.sum([A.T @ y for A, y in zip(columns, torque, strict=True)], axis=0)
    return inverse, [y - A @ x for A, y in zip(columns, torque, strict=True)]
