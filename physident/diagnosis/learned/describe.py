"""A learned curve for people: where it is large, how sure that is, and which law of the catalogue comes nearest to it."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.result.findings import CurveBand, ParameterValue
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.intervals import Uncertainty
from physident.effects.learned.curve import LearnedCurve

Array = NDArray[np.float64]
OPEN = 2.0  # standard errors of the level of a curve: where these reach as far as all of its shape, nobody knows which way it pushes
STANDSTILL = 0.02  # of the fastest speed: below, a curve that is smooth imitates no jump
HELD = (("dry", "the level"), ("viscous", "the straight line"))  # what a law of friction may hold of a curve
VISITED = 400  # places, as often as rows have been near them
POINTS = 100  # of a curve in a file and in a picture: three for each piece of its splines


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
    _, torque, std, top = _where_surest(hypothesis, accepted, accepted.effect, uncertainty)
    value, half = float(torque[top]), uncertainty.half * float(std[top])
    return ParameterValue(
        name="largest_from_mean" if _open_mean(hypothesis, accepted, accepted.effect).any() else "largest",
        joint=accepted.candidate.joints[0],
        value=value,
        change=value,
        std=float(std[top]),
        interval95=(value - half, value + half),
        change_interval95=(value - half, value + half),
        unit=hypothesis.problem.model.robot.joints[accepted.candidate.joints[0] - 1].unit(accepted.effect.unit),
    )


def _surest(torque: Array, half: Array) -> int:
    """Which of some torques (S,) is surely largest, by their half intervals (S,); where none is sure, the largest."""
    sure = np.abs(torque) - half
    return int(np.argmax(sure if sure.max() > 0 else np.abs(torque)))


def curve_in_words(
    hypothesis: Hypothesis, accepted: AcceptedEffect, effect: LearnedCurve, uncertainty: Uncertainty
) -> str:
    """Where a curve is surely largest of the places where recordings have been, and between which of them it is at least half of that."""
    x, torque, _, top = _where_surest(hypothesis, accepted, effect, uncertainty)
    words = effect.points_in_words(hypothesis.problem.model.robot, 0, x, torque, top)
    held = [words for law, words in HELD if law in _open_laws(hypothesis, accepted, effect)]
    words += f", beyond {' and '.join(held)} that other friction of the joint holds" if held else ""
    mean = _open_mean(hypothesis, accepted, effect).any()
    words += ", from its mean there, of which another parameter of the model may hold any part" if mean else ""
    return words


def _where_surest(
    hypothesis: Hypothesis, accepted: AcceptedEffect, effect: LearnedCurve, uncertainty: Uncertainty
) -> tuple[Array, Array, Array, int]:
    """Places (V,) where recordings have been, a curve's torque and its standard error (V,) [N m|N] there, from its mean and beyond other
    friction where these are open, and at which of them it is surely largest."""
    x, places = _visited(hypothesis, accepted, effect), _places(hypothesis, accepted)
    if "dry" in _open_laws(
        hypothesis, accepted, effect
    ):  # at standstill the level of dry friction jumps, and the curve does not
        x = x[np.abs(x) > STANDSTILL * np.abs(x).max()]
    Phi = _own_shapes(hypothesis, accepted, effect, x)
    torque, std = Phi @ _theta(hypothesis, accepted), _errors(Phi, uncertainty.theta.covariance[np.ix_(places, places)])
    return x, torque, std, _surest(torque, uncertainty.half * std)


def _with_error(
    hypothesis: Hypothesis, accepted: AcceptedEffect, effect: LearnedCurve, uncertainty: Uncertainty
) -> tuple[Array, Array, Array]:
    """Points of the curve's range (S,), its torque there (S,) [N m|N] and the standard error (S,): from its mean and beyond other friction,
    where these are open."""
    places, theta = _places(hypothesis, accepted), _theta(hypothesis, accepted)
    x = effect.curve(hypothesis.problem.model.robot, theta)[0]
    covariance = uncertainty.theta.covariance[np.ix_(places, places)]
    Phi = _own_shapes(hypothesis, accepted, effect, x)
    return x, Phi @ theta, _errors(Phi, covariance)


def _errors(Phi: Array, covariance: Array) -> Array:
    """Standard errors (S,) of what modes with a covariance make of some rows (S, modes)."""
    return np.sqrt(np.maximum(np.einsum("si,ij,sj->s", Phi, covariance, Phi), 0.0))


def _open_mean(hypothesis: Hypothesis, accepted: AcceptedEffect, effect: LearnedCurve) -> Array:
    """The mean (modes,) of a curve's modes over where recordings have been, if what it is there is known worse than the curve's shape is
    large: an offset, gravity or dry friction takes any of it. Zeros otherwise."""
    Phi = effect.shapes_at(hypothesis.problem.model.robot, _visited(hypothesis, accepted, effect))
    mean, places = Phi.mean(axis=0), _places(hypothesis, accepted)
    error = np.sqrt(max(float(mean @ hypothesis.covariance[np.ix_(places, places)] @ mean), 0.0))
    is_open = effect.has_mean and OPEN * error > np.abs((Phi - mean) @ _theta(hypothesis, accepted)).max()
    return mean if is_open else np.zeros_like(mean)


def _own_shapes(hypothesis: Hypothesis, accepted: AcceptedEffect, effect: LearnedCurve, x: Array) -> Array:
    """Values (S, modes) of a curve's modes at points x (S,), less their mean and what other friction of the joint may hold of them, where these
    are open. A line and a level are those nearest to the curve over its range, each way of motion apart from standstill."""
    robot, laws = hypothesis.problem.model.robot, _open_laws(hypothesis, accepted, effect)
    Phi = effect.shapes_at(robot, x) - _open_mean(hypothesis, accepted, effect)
    if not laws:
        return Phi
    seen = _visited(hypothesis, accepted, effect)
    seen = seen[np.abs(seen) > STANDSTILL * np.abs(seen).max()]
    held = np.linalg.lstsq(_laws_at(laws, seen), effect.shapes_at(robot, seen), rcond=None)[0]
    held[-1] = 0.0  # a mean of both ways is the curve's own
    return Phi - _laws_at(laws, x) @ held


def _laws_at(laws: Collection[str], x: Array) -> Array:
    """What some laws of friction are at velocities x (S,), and a constant (S, laws + 1)."""
    columns = {"dry": np.sign(x), "viscous": x}
    return np.column_stack([*(columns[law] for law in laws), np.ones_like(x)])


def _open_laws(hypothesis: Hypothesis, accepted: AcceptedEffect, effect: LearnedCurve) -> list[str]:
    """Which friction of the joint is fitted beside a curve over velocity, "viscous" or "dry": which of the two holds a straight line, or a level
    either way, is for the curve's prior to say, and no property of the arm."""
    problem, extended = hypothesis.problem, hypothesis.extension.model
    joint = accepted.candidate.joints[0]
    own = {one.effect.name for one in hypothesis.accepted if one.candidate.joints in ((joint,), ())}
    if problem.question == "missing":
        own |= {one.name for one in problem.model.effects}
    found = set[str]()
    for one, theta in extended.effect_parameters():
        for term in one.joint_terms(problem.model.robot, theta) or () if one.name in own else ():
            if joint - 1 in term.joints:
                found |= {"viscous"} if term.damping is not None else set()
                found |= {"dry"} if term.dry is not None else set()
    return [law for law, _ in HELD if law in found] if effect.variable == "velocity" else []


def _places(hypothesis: Hypothesis, accepted: AcceptedEffect) -> NDArray[np.intp]:
    """Where the numbers of an accepted effect stand in the extended model's theta."""
    return hypothesis.extension.places[hypothesis.accepted.index(accepted)]


def _theta(hypothesis: Hypothesis, accepted: AcceptedEffect) -> Array:
    return hypothesis.extension.model.theta[_places(hypothesis, accepted)]


def _visited(hypothesis: Hypothesis, accepted: AcceptedEffect, effect: LearnedCurve) -> Array:
    """Values (VISITED,) of a curve's quantity, ascending, as often as rows have been near them."""
    joint = accepted.candidate.joints[0] - 1
    found = [effect.quantity(one) for one in hypothesis.problem.referred(hypothesis.model)]
    x = np.concatenate([one[:, joint] for one in found if one is not None])
    return np.quantile(x, np.linspace(0, 1, VISITED))
