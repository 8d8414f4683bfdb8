"""Intervals of a diagnosis: a jackknife over blocks for values and shapes, a bootstrap over blocks for gains."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.folds import blocks
from physident.diagnosis.problem.search_data import OUTSIDE
from physident.diagnosis.search.hypothesis import AcceptedEffect, Hypothesis
from physident.diagnosis.statistics.normal_equations import pseudo_inverse
from physident.estimation.uncertainty import t_quantile

Array = NDArray[np.float64]
RESAMPLES = 1000  # the ends of a 95 % interval then wander by a few per cent of its width
STEP = 0.02  # relative, of a shape: its column's derivative is then right to a part in a thousand


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """``covariance`` (P, P) of the extended model's theta, ``shape_errors`` [the effect's key, standard error of its shape],
    and ``half``: how many standard errors a 95 % interval reaches."""

    covariance: Array
    shape_errors: dict[tuple[str, tuple[int, ...]], float]
    half: float


def uncertainty_of(hypothesis: Hypothesis) -> Uncertainty:
    """Errors of all values and shapes, from how far they move when one block is left out (CV3, see ``uncertainty``)."""
    baseline, shaped = hypothesis.baseline, []
    for a, values in zip(hypothesis.accepted, hypothesis.effect_values, strict=True):
        slopes = _slope(hypothesis, a, values)
        if slopes is not None:
            shaped.append(a.candidate.key)
            baseline = baseline.joined(slopes)
    weights, residual = hypothesis.fit.weights, hypothesis.fit.residual
    labels = blocks(hypothesis.data, float(hypothesis.fit.memory.max()))
    B = np.stack([w * columns for w, columns in zip(weights, baseline.joints, strict=True)], axis=1)
    r = residual * weights
    rows = [np.flatnonzero(labels == b) for b in np.unique(labels[labels != OUTSIDE])]
    normals = [np.einsum("mjr,mjs->rs", B[block], B[block], optimize=True) for block in rows]
    scores = [np.einsum("mjr,mj->r", B[block], r[block]) for block in rows]
    prior = np.diag(baseline.prior)
    H = np.sum(normals, axis=0) + prior
    moved = np.array([pseudo_inverse(H - normal) @ score for normal, score in zip(normals, scores, strict=True)])
    inverse = pseudo_inverse(H)
    G = len(rows)
    covariance = moved.T @ moved * (G - 1) / G + inverse @ prior @ inverse
    R = len(hypothesis.fit.x)
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))[R:]
    J = hypothesis.jacobian
    shapes = {
        key: float(error * getattr(a.effect, str(_field(a)))[0])
        for key, error in zip(shaped, errors, strict=True)
        for a in hypothesis.accepted
        if a.candidate.key == key
    }
    return Uncertainty(J @ covariance[:R, :R] @ J.T, shapes, t_quantile(G))


def resampled_reduction(before: Array, after: Array, seed: int) -> tuple[float, float]:
    """95 % interval of 100 (1 - RMS after / RMS before) from squared residuals (G,) of blocks."""
    draws = np.random.default_rng([seed, 13]).integers(0, len(before), (RESAMPLES, len(before)))
    ratio = np.sqrt(after[draws].sum(axis=1) / np.maximum(before[draws].sum(axis=1), 1e-300))
    low, high = np.quantile(100 * (1 - ratio), (0.025, 0.975))
    return float(low), float(high)


def _field(accepted: AcceptedEffect) -> str | None:
    """The field of the shape that was searched for, or None."""
    if len(accepted.candidate.options) == 1:
        return None
    for shape in accepted.effect.shape_parameters:
        if getattr(accepted.effect, shape.field) is not None and not shape.discrete:
            return shape.field
    return None


def _slope(hypothesis: Hypothesis, accepted: AcceptedEffect, values: Array) -> list[Array] | None:
    """How the effect's torque (M, 1) in each joint's rows moves with the logarithm of its shape."""
    field = _field(accepted)
    if field is None:
        return None
    value = getattr(accepted.effect, field)[0]
    sides = [
        hypothesis.problem.columns(replace(accepted.effect, **{field: (value * factor,)}), hypothesis.model)
        for factor in (1 + STEP, 1 / (1 + STEP))
    ]
    width = 2 * np.log(1 + STEP)
    return [((up - down) @ values / width)[:, None] for up, down in zip(*sides, strict=True)]
