"""Intervals of a diagnosis: a jackknife over blocks for values and shapes, a bootstrap over blocks for gains."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.columns import Columns
from physident.diagnosis.search.hypothesis import AcceptedEffect, Hypothesis
from physident.diagnosis.statistics.baseline_products import BaselineProducts
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
    products, squares = BaselineProducts(hypothesis.data, baseline), hypothesis.fit.weights**2
    own, R = products.own, len(hypothesis.fit.x)
    G, every = len(own.blocks), len(baseline.prior)
    normals, scores = np.zeros((G, every, every)), np.zeros((G, every))
    for joint, square in zip(products.units, squares, strict=True):
        part = square * joint.products[own.blocks]
        normals[:, joint.places[:, None], joint.places] += part[:, :-1, :-1]
        known = joint.places < R
        scores[:, joint.places] += (
            part[:, :-1, -1] - part[:, :-1, :-1][:, :, known] @ hypothesis.fit.x[joint.places[known]]
        )
    prior = np.diag(baseline.prior)
    H = normals.sum(axis=0) + prior
    moved = np.array([pseudo_inverse(H - normal) @ score for normal, score in zip(normals, scores, strict=True)])
    inverse = pseudo_inverse(H)
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


def _slope(hypothesis: Hypothesis, accepted: AcceptedEffect, values: Array) -> Columns | None:
    """How the effect's torque (M, 1) in each joint's rows moves with the logarithm of its shape."""
    field = _field(accepted)
    if field is None:
        return None
    value = getattr(accepted.effect, field)[0]
    up, down = [
        hypothesis.problem.fresh_columns(replace(accepted.effect, **{field: (value * factor,)}), hypothesis.model)
        for factor in (1 + STEP, 1 / (1 + STEP))
    ]
    slope = (up.torque(values) - down.torque(values)) / (2 * np.log(1 + STEP))
    return Columns.of([column[:, None] for column in slope.T])
