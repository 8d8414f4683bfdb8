"""The control of a change: the recordings that the model was fitted to, diagnosed in the same way.

A model that is wrong is wrong before and after. A finding is a change only where its coefficients differ between the control and
the new recordings by more than both leave open. Both are fitted at once: every parameter of the extended model is common, and
the findings' coefficients may differ in the new recordings.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.normal_equations import pseudo_inverse
from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor, build_regressor
from physident.errors import PhysidentError
from physident.estimation.dry_friction.row_weights import row_weights
from physident.estimation.estimate import Estimate
from physident.estimation.uncertainty import correlation_rows
from physident.estimation.weighting import weight_rows
from physident.identifiability.base_parameters import find_base_parameters
from physident.recordings.load import load_recording
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter, Signals

Array = NDArray[np.float64]
BLOCK = 4.0  # times the residual's memory: blocks are then nearly independent
CERTAIN = 0.01  # how often a coefficient that did not change is taken for a change


def control_recordings(estimate: Estimate) -> tuple[Recording, ...]:
    """The recordings that a model was fitted to, where all of them are still at hand, unchanged; else none."""
    found = []
    for source in estimate.sources:
        if not Path(source.path).is_file():
            return ()
        try:
            recording = load_recording(source.path, columns=estimate.layout)
        except PhysidentError:
            return ()
        if recording.sha256 != source.sha256:
            return ()
        found.append(recording.with_default_drive_gains(estimate.drive_gains))
    return tuple(found)


def changed_since(
    hypothesis: Hypothesis, control: Sequence[Signals], groups: Sequence[Sequence[int]]
) -> tuple[bool, ...]:
    """Whether each group of accepted effects (their indices) has other coefficients in the new recordings than in the control.

    The group whose difference is the least certain is taken for alike, and the others are judged again, until all that are left
    are certain: two effects that resemble each other would otherwise hide each other's change. Effects that the model did not
    have go first, because a value that changed is a shorter story than an effect that appeared.
    """
    problem, model = hypothesis.problem, hypothesis.extension.model
    before, after = (_rows(model, signals, problem.filter) for signals in (control, problem.signals))
    common = find_base_parameters(model.robot, model.effects).independent
    found = [[_direction(hypothesis, i) for i in group] for group in groups]
    free = np.column_stack([direction for group in found for direction in group])
    size = len(common) + free.shape[1]
    H, g, scores = np.zeros((size, size)), np.zeros(size), []
    for j in range(model.robot.n):
        parts = [_joint(rows, j, common, free, new) for rows, new in ((before, False), (after, True))]
        columns, torque = np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])
        sigma = _size(columns, torque)
        H += columns.T @ columns / sigma**2
        g += columns.T @ torque / sigma**2
        scores.append((columns / sigma, torque / sigma))
    labels, memory = _blocks(before, after, pseudo_inverse(H) @ g, scores)
    white = np.sum([m * columns.T @ columns for m, (columns, _) in zip(memory, scores, strict=True)], axis=0)
    known = set(range(len(problem.model.theta)))
    new = {
        k
        for k, group in enumerate(groups)
        if not any(known & {*hypothesis.extension.places[i].tolist()} for i in group)
    }
    places = dict(enumerate(_split(len(common), [len(group) for group in found])))
    while places:
        kept = np.concatenate([np.arange(len(common)), *places.values()])
        inverse = np.zeros_like(H)
        inverse[np.ix_(kept, kept)] = pseudo_inverse(H[np.ix_(kept, kept)])
        x = inverse @ g
        covariance = inverse @ (_meat(scores, x, labels) + white) @ inverse
        chance = {i: _chance(x, covariance, at, int(labels.max()) + 1) for i, at in places.items()}
        doubtful = [i for i in places if chance[i] >= CERTAIN]
        if not doubtful:
            break
        del places[max(doubtful, key=lambda i: (i in new, chance[i]))]
    return tuple(i in places for i in range(len(groups)))


def _direction(hypothesis: Hypothesis, i: int) -> Array:
    """The values of an accepted effect as a direction (p,) of the extended model's parameters.

    What is tested is by how much of itself an effect differs: one number, which a few blocks can decide where they leave the ten
    of a payload open.
    """
    direction = np.zeros(len(hypothesis.extension.model.theta))
    direction[hypothesis.extension.places[i]] = hypothesis.effect_values[i]
    return direction


def _rows(model: Model, signals: Sequence[Signals], filter: Filter) -> Regressor:
    """The regressor of the extended model, its rows weighted by what dry friction leaves open."""
    regressor = build_regressor(model.robot, model.effects, signals, filter, model=model)
    weights = row_weights(model.robot, model.effects, regressor, signals, filter)
    return weight_rows(regressor, weights)


def _joint(rows: Regressor, j: int, common: NDArray[np.intp], free: Array, new: bool) -> tuple[Array, Array]:
    """Columns (M, common + k) and torque (M,) of one joint; those of the directions ``free`` (p, k) count in the new
    recordings only."""
    dense = np.zeros((len(rows.time), len(rows.columns)))
    dense[:, rows.joints[j].columns] = rows.joints[j].values
    return np.column_stack([dense[:, common], dense @ free * new]), rows.torque[:, j]


def _size(columns: Array, torque: Array) -> float:
    """Standard deviation [N m|N] of what one joint's columns leave of its torque."""
    scale = np.linalg.norm(columns, axis=0)
    used = columns[:, scale > 0] / scale[scale > 0]
    residual = torque - used @ np.linalg.lstsq(used, torque, rcond=1e-9)[0]
    return max(float(np.sqrt(np.mean(residual**2))), 1e-9 * max(1.0, float(np.abs(torque).max())))


def _blocks(
    before: Regressor, after: Regressor, x: Array, scores: Sequence[tuple[Array, Array]]
) -> tuple[NDArray[np.intp], Array]:
    """The block of every row, in time, and how many correlated rows of each joint (n,) are worth one."""
    residual = np.column_stack([torque - columns @ x for columns, torque in scores])
    first = len(before.time)
    memory = np.max(
        [correlation_rows(rows, part) for rows, part in ((before, residual[:first]), (after, residual[first:]))], axis=0
    )
    length = max(1, round(BLOCK * float(memory.max())))
    labels, at = [], 0
    for rows in (before, after):
        for segment in np.unique(rows.segment):
            count = int(np.count_nonzero(rows.segment == segment))
            pieces = max(1, count // length)
            labels.append(at + np.minimum(np.arange(count) * pieces // count, pieces - 1))
            at += pieces
    return np.concatenate(labels), memory


def _meat(scores: Sequence[tuple[Array, Array]], x: Array, labels: NDArray[np.intp]) -> Array:
    """Sum over blocks of the outer product of each block's gradient: the noise as it really is, correlated and uneven."""
    blocks = int(labels.max()) + 1
    gradient = np.zeros((blocks, len(x)))
    for columns, torque in scores:
        np.add.at(gradient, labels, columns * (torque - columns @ x)[:, None])
    return gradient.T @ gradient * blocks / max(blocks - 1, 1)


def _split(first: int, sizes: Sequence[int]) -> list[NDArray[np.intp]]:
    ends = first + np.cumsum(sizes)
    return [np.arange(end - size, end) for end, size in zip(ends, sizes, strict=True)]


def _chance(x: Array, covariance: Array, at: NDArray[np.intp], blocks: int) -> float:
    """How often noise alone makes differences as large as those at some places of x, by Hotelling's test with as much freedom
    as there are blocks; always, where there are too few."""
    from scipy.stats import f

    k = len(at)
    if blocks <= k + 1:
        return 1.0
    T2 = float(x[at] @ pseudo_inverse(covariance[np.ix_(at, at)]) @ x[at])
    return float(f.sf(T2 * (blocks - k) / (k * (blocks - 1)), k, blocks - k))
