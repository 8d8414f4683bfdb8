"""The shape of an accepted effect between the points of its grid, by variable projection on all rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import Candidate
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.normal_equations import pseudo_inverse, whitening
from physident.effects.effect import Effect

Array = NDArray[np.float64]
REFINED = 1e-2  # relative width at which the search ends: the shape's own uncertainty is larger


def refine_shape(hypothesis: Hypothesis, candidate: Candidate) -> Effect:
    """The candidate's effect with the shape of the largest gain beside a hypothesis' baseline (Golub and Pereyra, 1973)."""
    if candidate.key not in hypothesis.refined:
        hypothesis.refined[candidate.key] = _best_shape(hypothesis, candidate)
    return hypothesis.refined[candidate.key]


def _best_shape(hypothesis: Hypothesis, candidate: Candidate) -> Effect:
    effects = [option.effect for option in candidate.options if option.effect is not None]
    if len(effects) == 1:
        return effects[0]
    evaluator = GainEvaluator(hypothesis)
    found = [evaluator.gain(hypothesis.data.columns(option.columns)) for option in candidate.options]
    top = int(np.argmax(found))
    best = effects[top]
    shape = next((s for s in best.shape_parameters if getattr(best, s.field) is not None), None)
    if shape is None or shape.discrete:
        return best
    from scipy.optimize import minimize_scalar

    values = np.array([getattr(e, shape.field)[0] for e in effects if getattr(e, shape.field) is not None])
    at = int(np.flatnonzero(values == getattr(best, shape.field)[0])[0])
    low, high = values[max(0, at - 1)], values[min(len(values) - 1, at + 1)]

    def at_value(value: float) -> Effect:
        return replace(best, **{shape.field: (value,)})

    def loss(logarithm: float) -> float:
        return -evaluator.gain(hypothesis.problem.fresh_columns(at_value(float(np.exp(logarithm))), hypothesis.model))

    bounds = (np.log(low), np.log(high))
    answer = minimize_scalar(loss, bounds=bounds, method="bounded", options={"xatol": REFINED})
    return at_value(float(np.exp(answer.x))) if -answer.fun > found[top] else best


class GainEvaluator:
    """The gain of columns on all rows beside a hypothesis' baseline, refitted with ``weights`` (n,), its own unless given."""

    def __init__(self, hypothesis: Hypothesis, weights: Array | None = None) -> None:
        self.weights = hypothesis.fit.weights if weights is None else weights
        self.joints, response = hypothesis.baseline.joints, hypothesis.data.response
        squares = [B.T @ B for B in self.joints]
        slopes = [B.T @ y for B, y in zip(self.joints, response.T, strict=True)]
        self.inverse = pseudo_inverse(np.tensordot(self.weights**2, squares, 1) + np.diag(hypothesis.baseline.prior))
        x = self.inverse @ np.tensordot(self.weights**2, slopes, 1)
        self.residual = response - np.column_stack([B @ x for B in self.joints])

    def gain(self, columns: Sequence[Array]) -> float:
        """By how much the squared weighted residual falls with columns (M, k) in each joint's rows."""
        squares = self.weights**2
        inner = np.tensordot(squares, [c.T @ c for c in columns], 1)
        slope = np.tensordot(squares, [c.T @ r for c, r in zip(columns, self.residual.T, strict=True)], 1)
        cross = np.tensordot(squares, [B.T @ c for B, c in zip(self.joints, columns, strict=True)], 1)
        outside = inner - cross.T @ self.inverse @ cross
        root = whitening(np.asarray(inner)[None], np.asarray(outside)[None])[0]
        return float(np.sum((root.T @ slope) ** 2))
