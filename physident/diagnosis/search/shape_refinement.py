"""The shape of an accepted effect between the points of its grid, by variable projection on all rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect, Candidate
from physident.diagnosis.problem.columns import Columns
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.normal_equations import pseudo_inverse, whitening
from physident.effects.effect import Effect
from physident.effects.kinds_of_values import AboutItsSize
from physident.identifiability.visibility import VISIBLE

Array = NDArray[np.float64]
REFINED = 1e-2  # relative width at which the search ends: the shape's own uncertainty is larger


def refine_shape(hypothesis: Hypothesis, candidate: Candidate) -> Effect:
    """The candidate's effect with the shape of the largest gain beside a hypothesis' baseline (Golub and Pereyra, 1973), as it is
    fitted once its size is known."""
    if candidate.key not in hypothesis.refined:
        best = _best_shape(hypothesis, candidate)
        if type(best).once_sized is not Effect.once_sized:
            best = best.once_sized(hypothesis.with_effect(candidate, best).effect_values[-1])
        hypothesis.refined[candidate.key] = best
    return hypothesis.refined[candidate.key]


def about_their_sizes(hypothesis: Hypothesis) -> tuple[AcceptedEffect, ...]:
    """The accepted effects, each whose torque is no line over its values about those that it has beside the others."""
    result = []
    for one, values in zip(hypothesis.accepted, hypothesis.effect_values, strict=True):
        sized = one.effect.once_sized(values) if isinstance(one.effect, AboutItsSize) else one.effect
        result.append(one if sized == one.effect else replace(one, effect=sized))
    return tuple(result)


def _best_shape(hypothesis: Hypothesis, candidate: Candidate) -> Effect:
    effects = [option.effect for option in candidate.options if option.effect is not None]
    if len(effects) == 1:
        return effects[0]
    evaluator = GainEvaluator(hypothesis)
    found = evaluator.gains([option.columns for option in candidate.options])
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
        # a power next to the first is viscous friction, already there: its size and power could be anything
        return -evaluator.gain(
            hypothesis.problem.columns(at_value(float(np.exp(logarithm))), hypothesis.model), VISIBLE
        )

    bounds = (np.log(low), np.log(high))
    answer = minimize_scalar(loss, bounds=bounds, method="bounded", options={"xatol": REFINED})
    return at_value(float(np.exp(answer.x))) if -answer.fun > found[top] else best


class GainEvaluator:
    """The gain of columns on all rows beside a hypothesis' baseline, refitted with ``weights`` (n,), its own unless given."""

    def __init__(self, hypothesis: Hypothesis, weights: Array | None = None) -> None:
        self.products = hypothesis.products
        self.squares = (hypothesis.fit.weights if weights is None else weights) ** 2
        equations = self.products.equations
        normal = np.tensordot(self.squares, equations.squares, 1) + np.diag(hypothesis.baseline.prior)
        self.inverse = pseudo_inverse(normal)
        self.x = self.inverse @ np.tensordot(self.squares, equations.slopes, 1)

    def gains(self, options: Sequence[tuple[int, ...]]) -> Array:
        """By how much the squared weighted residual falls with each of some options (O,) of the data's columns (O, k)."""
        at = np.array(options, dtype=np.intp)
        inner, cross, slope = (
            np.asarray(np.tensordot(self.squares, part.sum(axis=0), 1), dtype=float)
            for part in (self.products.CC(at), self.products.BC(at.ravel()), self.products.Cy(at.ravel()))
        )
        return self._of(inner, cross.reshape(len(self.x), *at.shape), slope.reshape(at.shape))

    def gain(self, columns: Columns, visible: float = 0.0) -> float:
        """By how much the squared weighted residual falls with columns (M, k) in each joint's rows; not at all, where a smaller share of
        their energy than a ``visible`` one is outside the baseline."""
        inner, cross, slope = (np.tensordot(self.squares, part, 1) for part in self.products.with_columns(columns))
        outside = np.trace(inner) - np.sum(cross * (self.inverse @ cross))
        if outside < visible * np.trace(inner):
            return 0.0
        return float(self._of(inner[None], cross[:, None], slope[None])[0])

    def _of(self, inner: Array, cross: Array, slope: Array) -> Array:
        """Gains (O,) from weighted products of options with themselves (O, k, k), the baseline (R, O, k) and the response (O, k)."""
        Z = np.tensordot(self.inverse, cross, 1)
        root = whitening(inner, inner - np.einsum("rok,rol->okl", cross, Z))
        left = slope - np.einsum("rok,r->ok", cross, self.x)
        return np.sum(np.einsum("okl,ok->ol", root, left) ** 2, axis=1)
