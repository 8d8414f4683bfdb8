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
    parts: Sequence[Regressor],
    segment: NDArray[np.intp],
    columns: Sequence[Array],
    torque: Sequence[Array],
    effect: Sequence[Array],
) -> Scatter:
    """By how much the size of an effect differs between the recordings of one state of an arm, beyond what noise makes of it.

    ``parts`` have the rows of each state in order, M in all, whose contiguous ones ``segment`` (M,) labels. Each recording is held against
    the others of its part: all parameters, whose ``columns`` (M, p) of each joint are in units of its noise, as the ``torque`` (M,), are common
    but for one size of the ``effect`` (M,) in each part, and its size in this recording may differ. What is left where every recording has a
    size of its own is noise. Source: the moment estimator of a random effect, DerSimonian and Laird, "Meta-analysis in clinical
    trials" (1986), pooled over the parts as Student's two samples are.
    """
    recordings = [(k, one) for k, part in enumerate(parts) for one in np.unique(part.recording)]
    each = np.concatenate([part.recording for part in parts])
    place = np.concatenate([np.full(len(part.recording), k) for k, part in enumerate(parts)])
    masks = [(place == k) & (each == one) for k, one in recordings]
    own = [[c * mask for mask in masks] for c in effect]
    apart = [
        np.column_stack([A, *(c * (place == k) for k in range(len(parts)))])
        for A, c in zip(columns, effect, strict=True)
    ]
    inverse, left = _fitted(apart, torque)
    noise = _fitted([np.column_stack([A, *some]) for A, some in zip(columns, own, strict=True)], torque)[1]
    found = []
    for (k, _), some in zip(recordings, zip(*own, strict=True), strict=True):
        moved = inverse @ np.sum([A.T @ c for A, c in zip(apart, some, strict=True)], axis=0)
        beside = [c - A @ moved for A, c in zip(apart, some, strict=True)]
        size = sum(float(c @ c) for c in beside)
        if size <= INSIDE * sum(float(c @ c) for c in some):
            continue  # this recording does not show the effect apart from all else, or it is the only one of its part
        difference = sum(float(c @ r) for c, r in zip(beside, left, strict=True)) / size
        push = np.sum([c * r for c, r in zip(beside, noise, strict=True)], axis=0) / size
        found.append((difference, max(variance for variance, _ in block_variances(push, segment, parts)), k))
    if len(found) < 2:
        return ALIKE
    differences, variances, part_of = np.array(found).T
    _, which, shown = np.unique(part_of, return_inverse=True, return_counts=True)
    weights = 1 / np.maximum(variances, 1e-300)
    # a recording differs from the others of its part by its own deviation and by theirs
    beyond = weights * (differences**2 - variances) * (1 - 1 / shown[which])
    return Scatter(variance=max(0.0, float(beyond.sum() / weights.sum())), count=len(found) - len(shown) + 1)


def _fitted(columns: Sequence[Array], torque: Sequence[Array]) -> tuple[Array, list[Array]]:
    """The inverse of the normal matrix of all joints' columns, and what they leave (M,) of each joint's torque."""
    inverse = pseudo_inverse(np.sum([A.T @ A for A in columns], axis=0))
    x = inverse @ np.sum([A.T @ y for A, y in zip(columns, torque, strict=True)], axis=0)
    return inverse, [y - A @ x for A, y in zip(columns, torque, strict=True)]
