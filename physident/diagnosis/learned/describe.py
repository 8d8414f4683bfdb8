"""A learned curve for people: where it is large, how sure that is, and which law of the catalogue comes nearest to it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.result.findings import CurveBand, ParameterValue
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.intervals import Uncertainty
from physident.effects.learned.curve import LearnedCurve

Array = NDArray[np.float64]
OPEN = 2.0  # standard errors of the level of a curve: where these reach as far as all of its shape, nobody knows which way it pushes
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
    """Whether the mean of a curve where rows are is known worse than its shape is large: an offset, gravity or dry friction takes any of
    it."""
    effect = accepted.effect
    if not isinstance(effect, LearnedCurve) or not effect.has_mean:
        return False
    mean = _mean_shape(hypothesis, accepted, effect)
    places = hypothesis.extension.places[hypothesis.accepted.index(accepted)]
    left = mean @ hypothesis.covariance[np.ix_(places, places)] @ mean
    x = _visited(hypothesis, accepted, effect)
    shape = (effect.shapes_at(hypothesis.problem.model.robot, x) - mean) @ _theta(hypothesis, accepted)
    return bool(OPEN * np.sqrt(max(float(left), 0.0)) > np.abs(shape).max())


def curve_in_words(hypothesis: Hypothesis, accepted: AcceptedEffect, effect: LearnedCurve) -> str:
    """Where a curve is largest of the places where recordings have been, and between which of them it is at least half of that."""
    robot, x = hypothesis.problem.model.robot, _visited(hypothesis, accepted, effect)
    Phi, theta = _shown(hypothesis, accepted, effect, effect.shapes_at(robot, x)), _theta(hypothesis, accepted)
    words = effect.points_in_words(robot, 0, x, Phi @ theta)
    open_level = level_is_open(hypothesis, accepted)
    return f"{words}, but for a constant, which another parameter of the model holds" if open_level else words


def _with_error(
    hypothesis: Hypothesis, accepted: AcceptedEffect, effect: LearnedCurve, uncertainty: Uncertainty
) -> tuple[Array, Array, Array]:
    """Points of the curve's range (S,), its torque there (S,) [N m|N] and the standard error (S,): those of its shape, where its level is
    open."""
    places = hypothesis.extension.places[hypothesis.accepted.index(accepted)]
    theta = _theta(hypothesis, accepted)
    x, _, Phi = effect.curve(hypothesis.problem.model.robot, theta)
    covariance = uncertainty.covariance[np.ix_(places, places)]
    Phi = _shown(hypothesis, accepted, effect, Phi)
    return x, Phi @ theta, np.sqrt(np.maximum(np.einsum("si,ij,sj->s", Phi, covariance, Phi), 0.0))


def _theta(hypothesis: Hypothesis, accepted: AcceptedEffect) -> Array:
    return hypothesis.extension.model.theta[hypothesis.extension.places[hypothesis.accepted.index(accepted)]]


def _shown(hypothesis: Hypothesis, accepted: AcceptedEffect, effect: LearnedCurve, Phi: Array) -> Array:
    """The modes (S, modes) of what recordings show of a curve: less their mean, where they leave its level open."""
    return Phi - _mean_shape(hypothesis, accepted, effect) if level_is_open(hypothesis, accepted) else Phi


def _mean_shape(hypothesis: Hypothesis, accepted: AcceptedEffect, effect: LearnedCurve) -> Array:
    """The mean (modes,) of a curve's modes over where recordings have been."""
    robot = hypothesis.problem.model.robot
    return effect.shapes_at(robot, _visited(hypothesis, accepted, effect)).mean(axis=0)


def _visited(hypothesis: Hypothesis, accepted: AcceptedEffect, effect: LearnedCurve) -> Array:
    """Values (VISITED,) of a curve's quantity, ascending, as often as rows have been near them."""
    joint = accepted.candidate.joints[0] - 1
    found = [effect.quantity(one) for one in hypothesis.problem.referred(hypothesis.model)]
    x = np.concatenate([one[:, joint] for one in found if one is not None])
    return np.quantile(x, np.linspace(0, 1, VISITED))
