"""A learned curve for people: where it is large, how sure that is, and which law of the catalogue comes nearest to it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect, prior_precision
from physident.diagnosis.result.findings import CurveBand, ParameterValue
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.intervals import Uncertainty
from physident.effects.learned.curve import LearnedCurve

Array = NDArray[np.float64]
OPEN = 0.5  # of the variance that the prior allows: rows that leave more of the level of a curve than they settle do not show it
VISITED = 400  # places, as often as rows have been near them
POINTS = 60  # of a curve in a file and in a picture: three for each piece of its splines


def curve_band(hypothesis: Hypothesis, accepted: AcceptedEffect, uncertainty: Uncertainty) -> CurveBand | None:
    """The curve of an accepted effect with its 95 % band; None for an effect that is no curve."""
    if not isinstance(accepted.effect, LearnedCurve):
        return None
    x, torque, std = _with_error(hypothesis, accepted, accepted.effect, uncertainty)
    at = np.linspace(0, len(x) - 1, POINTS).round().astype(int)
    half = uncertainty.half * std
    (joint,) = accepted.candidate.joints
    return CurveBand(
        joint=joint,
        quantity=accepted.effect.variable or "",
        unit=accepted.effect.unit_of_quantity(hypothesis.problem.model.robot, joint - 1),
        x=tuple(x[at].tolist()),
        torque=tuple(torque[at].tolist()),
        low=tuple((torque - half)[at].tolist()),
        high=tuple((torque + half)[at].tolist()),
    )


def largest_value(hypothesis: Hypothesis, accepted: AcceptedEffect, uncertainty: Uncertainty) -> ParameterValue:
    """The torque of a curve where it is surely largest, in the place of its many parameters: not at an end that hardly any row has seen. Where
    no torque is sure, because other parameters take a part of it, the largest one."""
    assert isinstance(accepted.effect, LearnedCurve)
    _, torque, std = _with_error(hypothesis, accepted, accepted.effect, uncertainty)
    sure = np.abs(torque) - uncertainty.half * std
    top = int(np.argmax(sure if sure.max() > 0 else np.abs(torque)))
    value, half = float(torque[top]), uncertainty.half * float(std[top])
    return ParameterValue(
        name="largest",
        joint=accepted.candidate.joints[0],
        value=value,
        change=value,
        std=float(std[top]),
        interval95=(value - half, value + half),
        unit=accepted.effect.unit,
    )


def level_is_open(hypothesis: Hypothesis, accepted: AcceptedEffect) -> bool:
    """Whether rows leave the mean of a curve where they are to its prior: an offset, or dry friction, takes any of it."""
    effect = accepted.effect
    if not isinstance(effect, LearnedCurve) or not effect.has_mean:
        return False
    mean = _mean_shape(hypothesis, accepted, effect)
    places = hypothesis.extension.places[hypothesis.accepted.index(accepted)]
    left = mean @ hypothesis.covariance[np.ix_(places, places)] @ mean
    return bool(left * prior_precision(effect) > OPEN * mean @ mean)


def _with_error(
    hypothesis: Hypothesis, accepted: AcceptedEffect, effect: LearnedCurve, uncertainty: Uncertainty
) -> tuple[Array, Array, Array]:
    """Points of the curve's range (S,), its torque there (S,) [N m|N], and the standard error (S,): of its shape, where its level is open."""
    places = hypothesis.extension.places[hypothesis.accepted.index(accepted)]
    x, torque, Phi = effect.curve(hypothesis.problem.model.robot, hypothesis.extension.model.theta[places])
    covariance = uncertainty.covariance[np.ix_(places, places)]
    if level_is_open(hypothesis, accepted):
        Phi = Phi - _mean_shape(hypothesis, accepted, effect)
    return x, torque, np.sqrt(np.maximum(np.einsum("si,ij,sj->s", Phi, covariance, Phi), 0.0))


def _mean_shape(hypothesis: Hypothesis, accepted: AcceptedEffect, effect: LearnedCurve) -> Array:
    """The mean (modes,) of a curve's modes over where recordings have been."""
    joint = accepted.candidate.joints[0] - 1
    found = [effect.quantity(one) for one in hypothesis.problem.referred(hypothesis.model)]
    x = np.concatenate([one[:, joint] for one in found if one is not None])
    return effect.shapes_at(hypothesis.problem.model.robot, np.quantile(x, np.linspace(0, 1, VISITED))).mean(axis=0)
