"""A learned curve for people: where it is large, how sure that is, and which law of the catalogue comes nearest to it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.result.findings import CurveBand, ParameterValue
from physident.diagnosis.search.hypothesis import Hypothesis, state_hypothesis
from physident.diagnosis.statistics.intervals import Uncertainty
from physident.diagnosis.statistics.left_out_gains import left_out_gains
from physident.effects.classification import Detection
from physident.effects.learned.curve import LearnedCurve

Array = NDArray[np.float64]
POINTS = 60  # of a curve in a file and in a picture: three for each piece of its splines
LEAST = 0.05  # of a curve: a law that takes less is not near it


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
        unit=accepted.effect.quantity_unit,
        x=tuple(x[at].tolist()),
        torque=tuple(torque[at].tolist()),
        low=tuple((torque - half)[at].tolist()),
        high=tuple((torque + half)[at].tolist()),
    )


def largest_value(hypothesis: Hypothesis, accepted: AcceptedEffect, uncertainty: Uncertainty) -> ParameterValue:
    """The torque of a curve where it is largest, in the place of its many parameters."""
    assert isinstance(accepted.effect, LearnedCurve)
    _, torque, std = _with_error(hypothesis, accepted, accepted.effect, uncertainty)
    top = int(np.argmax(np.abs(torque)))
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


def nearest_law(hypothesis: Hypothesis, accepted: AcceptedEffect) -> str:
    """A sentence on the law of the same joint that takes most of what a curve takes on left-out rows; empty for another effect."""
    if not isinstance(accepted.effect, LearnedCurve):
        return ""
    others = [one for one in hypothesis.accepted if one is not accepted]
    rest = state_hypothesis(hypothesis.problem, others, hypothesis.model, hypothesis.data)
    laws = [
        c
        for c in rest.data.candidates
        if c.joints == accepted.candidate.joints
        and (effect := c.options[0].effect) is not None
        and effect.detection is Detection.BY_PLACE
        and not hypothesis.problem.is_friction_of_resting_joint(c)
    ]
    data = replace(rest.data, candidates=(accepted.candidate, *laws))
    taken = left_out_gains(data, rest.baseline, rest.fit, data.response[:, :, None]).gain.sum(axis=(1, 2))[:, 0]
    shares = taken[1:] / max(float(taken[0]), 1e-300)
    said = "no effect of the catalogue has this shape"
    if not len(shares) or shares.max() < LEAST:
        return f"{said}, and none takes {100 * LEAST:.0f} % of it."
    best = int(np.argmax(shares))
    return f"{said}; nearest: {laws[best].name}, {100 * min(float(shares[best]), 1.0):.0f} % of it."


def _with_error(
    hypothesis: Hypothesis, accepted: AcceptedEffect, effect: LearnedCurve, uncertainty: Uncertainty
) -> tuple[Array, Array, Array]:
    """Points of the curve's range (S,), its torque there (S,) [N m|N], and the standard error (S,)."""
    places = hypothesis.extension.places[hypothesis.accepted.index(accepted)]
    x, torque, Phi = effect.curve(hypothesis.problem.model.robot, hypothesis.extension.model.theta[places])
    covariance = uncertainty.covariance[np.ix_(places, places)]
    return x, torque, np.sqrt(np.maximum(np.einsum("si,ij,sj->s", Phi, covariance, Phi), 0.0))
