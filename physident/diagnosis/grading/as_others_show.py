"""What effects are worth in each new recording by the values that the other ones give them.

The values of a curve or of a payload are chosen so that they take most of the rows that they are fitted to. By these values the new
recordings would always show the whole of the effect and those from before little of it, were the curve nothing but what a motion
makes of a model's errors. What the other recordings show has no such advantage.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import prior_precision
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.normal_equations import pseudo_inverse
from physident.dynamics.regressor import Regressor
from physident.identifiability.base_parameters import find_base_parameters

Array = NDArray[np.float64]
SHOWN = 0.1  # of the power of an effect's torque: where the other recordings have less of it, they do not show it


@dataclass(frozen=True, kw_only=True, eq=False)
class AsOthersShow:
    """Of k effects the ``values`` (p, k) among an extended model's parameters, and the ``values_without`` each new recording."""

    values: Array
    values_without: Mapping[int, Array]

    def torque(self, columns: Array, recording: NDArray[np.intp]) -> Array:
        """What each effect makes (M, k) of the columns (M, p) of one joint in new recordings (M,)."""
        result = columns @ self.values
        for one, values in self.values_without.items():
            rows = recording == one
            result[rows] = columns[rows] @ values
        return result


def as_others_show(hypothesis: Hypothesis, tested: Sequence[int], before: Regressor, after: Regressor) -> AsOthersShow:
    """The values of some accepted effects (their indices), and those without each of the new recordings ``after``, where there are
    several; the model's parameters are fitted to the recordings ``before`` and to these together, beside all accepted effects.

    An effect of one number keeps it: there is nothing to choose. So does one that the other recordings do not show, as of a joint that
    moves in one of them.
    """
    places = [hypothesis.extension.places[i] for i in tested]
    values = np.zeros((len(hypothesis.extension.model.theta), len(tested)))
    for k, (i, at) in enumerate(zip(tested, places, strict=True)):
        values[at, k] = hypothesis.effect_values[i]
    several, recordings = [k for k, at in enumerate(places) if len(at) > 1], np.unique(after.recording)
    if not several or len(recordings) < 2:
        return AsOthersShow(values=values, values_without={})
    known = find_base_parameters(hypothesis.problem.model.robot, hypothesis.problem.model.effects).independent
    effects = hypothesis.extension.places
    columns, weights = np.concatenate([known, *effects]), hypothesis.fit.weights
    prior = [prior_precision(one.effect, len(at)) for one, at in zip(hypothesis.accepted, effects, strict=True)]
    precision = np.concatenate([np.zeros(len(known)), *prior])
    of_before = _products(before, np.ones(len(before.time), dtype=bool), columns, len(known), weights)
    each = [_products(after, after.recording == one, columns, len(columns), weights) for one in recordings]
    H, g = (np.sum(one, axis=0) for one in zip(of_before, *each, strict=True))
    ends = len(known) + np.cumsum([0, *(len(at) for at in effects)])
    without = {}
    for one, (own, slope) in zip(recordings, each, strict=True):
        x = pseudo_inverse(H - own + np.diag(precision)) @ (g - slope)
        without[int(one)] = values.copy()
        for k in several:
            at = slice(ends[tested[k]], ends[tested[k] + 1])
            v = values[places[k], k]
            of_all, of_this = float(v @ H[at, at] @ v), float(v @ own[at, at] @ v)
            if of_all - of_this > SHOWN * of_all:
                without[int(one)][places[k], k] = x[at]
    return AsOthersShow(values=values, values_without=without)


def dense(rows: Regressor, j: int) -> Array:
    """The columns (M, p) of all parameters in the rows of one joint (index)."""
    result = np.zeros((len(rows.time), len(rows.columns)))
    result[:, rows.joints[j].columns] = rows.joints[j].values
    return result


def _products(
    rows: Regressor, mine: NDArray[np.bool_], columns: NDArray[np.intp], shown: int, weights: Array
) -> tuple[Array, Array]:
    """The normal matrix and slope of some columns in some rows, of which only the first so many are ``shown``."""
    H, g = np.zeros((len(columns), len(columns))), np.zeros(len(columns))
    for j, weight in enumerate(weights):
        A = dense(rows, j)[mine][:, columns] * weight
        A[:, shown:] = 0.0
        H += A.T @ A
        g += A.T @ (rows.torque[mine, j] * weight)
    return H, g
