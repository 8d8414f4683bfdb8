"""How well the recordings of a model agree on its parameters: a covariance that they contradict is too small.

What a model lacks moves its parameters from one motion to the next by more than noise does. A diagnosis that trusts them more than
the model's own recordings trust each other takes every new motion for a change.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.question import known_covariance
from physident.diagnosis.problem.search_data import rows_of
from physident.diagnosis.statistics.normal_equations import pseudo_inverse
from physident.dynamics.regressor import Regressor, build_regressor
from physident.estimation.dry_friction.row_weights import row_weights
from physident.estimation.estimate import Estimate
from physident.estimation.shapes.curve_priors import prior_sizes
from physident.estimation.weighting import SMALLEST, information_in, weight_rows
from physident.large_arrays import blocks
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
DECIDED = 1e-9  # of the best known direction: what a recording says less about, it says nothing about


@dataclass(frozen=True, eq=False)
class _Equations:
    """Of a recording: for each joint the normal matrix (n, r, r) and right side (n, r) of the base parameters' deviation from the
    estimate, in units of the noise."""

    normal: Array
    push: Array


def as_recordings_agree(estimate: Estimate, own: Sequence[Signals]) -> Estimate:
    """The estimate with its covariance as large as the scatter between its ``own`` recordings asks for, never smaller.

    Each recording is held against the parameters that the others give, joint by joint: what the rows of a joint add to the covariance
    grows by the square of how much more than expected this joint's rows disagree. Two recordings or more are needed; of one, the
    estimate stays as it is. Source: the ratio of R. T. Birge, "The calculation of errors by the method of least squares" (1932).
    """
    if len(own) < 2:
        return estimate
    rows = _rows(estimate, own)
    if estimate.information is None:
        estimate = replace(
            estimate, information=information_in(rows, estimate.base, estimate.sigma, estimate.effective_samples)
        )
    each, covariance = _equations(rows, estimate), known_covariance(estimate, rows)
    by_joint = np.sum([one.normal for one in each], axis=0)
    whole = by_joint.sum(axis=0) + _prior(rows, estimate)
    inverse = pseudo_inverse(whole)
    for normal, ratio in zip(by_joint, _ratios(each, whole), strict=True):
        covariance = covariance + max(0.0, ratio - 1) * inverse @ normal @ inverse
    return replace(estimate, covariance=covariance, information=pseudo_inverse(covariance))


def theta_without_each(estimate: Estimate, own: Sequence[Signals]) -> Array:
    """The model's parameters as all of its ``own`` k recordings but each one give them: (k, p)."""
    rows, known = _rows(estimate, own), estimate.base.independent
    each, prior = _equations(rows, estimate), _prior(rows, estimate)
    slope = np.sum([one.push for one in each], axis=(0, 1)) - prior @ estimate.theta[known]
    whole = np.sum([one.normal for one in each], axis=(0, 1)) + prior
    theta = np.tile(estimate.theta, (len(each), 1))
    for without, one in zip(theta, each, strict=True):
        without[known] += pseudo_inverse(whole - one.normal.sum(axis=0)) @ (slope - one.push.sum(axis=0))
    return theta


def _rows(estimate: Estimate, own: Sequence[Signals]) -> Regressor:
    """The model's rows of some recordings, as they count in a fit, and those that its prior, such as that of a curve's smoothness, counts for."""
    model = estimate.model
    rows = build_regressor(model.robot, model.effects, own, estimate.filter, model=model)
    noise = np.maximum(estimate.sigma[[column.joint - 1 for column in rows.columns]], SMALLEST)
    weighted = weight_rows(rows, row_weights(model.robot, model.effects, rows, own, estimate.filter))
    return replace(weighted, prior=(noise / prior_sizes(model.robot, model.effects)) ** 2)


def _equations(rows: Regressor, estimate: Estimate) -> list[_Equations]:
    left, r, n = rows.residual(estimate.theta), estimate.base.r, len(estimate.sigma)
    trust = estimate.effective_samples / len(left) / np.maximum(estimate.sigma, SMALLEST) ** 2
    place = np.full(len(rows.columns), -1)
    place[estimate.base.independent] = np.arange(r)
    found = []
    for recording in np.unique(rows.recording):
        mine = rows_of(rows.recording, int(recording))
        normal, push = np.zeros((n, r, r)), np.zeros((n, r))
        for j, joint in enumerate(rows.joints):
            chosen = place[joint.columns] >= 0
            at = place[joint.columns[chosen]]
            for some in blocks(mine.stop - mine.start):
                here = slice(mine.start + some.start, mine.start + some.stop)
                Y = joint.some(here)[:, chosen]
                normal[j][np.ix_(at, at)] += trust[j] * (Y.T @ Y)
                push[j, at] += trust[j] * (Y.T @ left[here, j])
        found.append(_Equations(normal, push))
    return found


def _prior(rows: Regressor, estimate: Estimate) -> Array:
    """The information (r, r) of the model's prior."""
    assert rows.prior is not None
    noise = np.maximum(estimate.sigma[[column.joint - 1 for column in rows.columns]], SMALLEST)
    return np.diag((rows.prior / noise**2)[estimate.base.independent])


def _ratios(each: Sequence[_Equations], whole: Array) -> list[float]:
    """The Birge ratio of each joint: how much larger the squares of its deviations from the other recordings are than noise makes them.

    Each direction of the parameters is counted by how much of its deviation is the other recordings' error.
    """
    slope = np.sum([one.push for one in each], axis=(0, 1))
    squares, count = np.zeros(len(each[0].push)), np.zeros(len(each[0].push))
    for one in each:
        inverse = pseudo_inverse(whole - one.normal.sum(axis=0))
        others = inverse @ (slope - one.push.sum(axis=0))
        values, vectors = np.linalg.eigh(inverse)
        root = vectors * np.sqrt(np.maximum(values, 0.0))
        for j, (normal, push) in enumerate(zip(one.normal, one.push, strict=True)):
            known, directions = np.linalg.eigh(root.T @ normal @ root)
            seen = known > DECIDED * max(known[-1], 1e-300)
            size = known[seen]  # the variance of what the others say, in units of this recording's noise
            trust = size / (1 + size)
            deviation = (root.T @ (push - normal @ others)) @ directions[:, seen]
            squares[j] += np.sum(trust * deviation**2 / (size * (1 + size)))
            count[j] += np.sum(trust)
    return (squares / np.maximum(count, 1e-300)).tolist()
