"""Physical signs of the model plus the change: what a candidate's values would make of the arm."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.search.hypothesis import Hypothesis, state_hypothesis
from physident.diagnosis.statistics.common_share import limit_of, share_of_most
from physident.effects.scales.shared_scale import UNEVEN, SharedScale

Array = NDArray[np.float64]
SPEEDS = 40  # of the grid on which a joint's friction must oppose its motion, up to the fastest that was recorded
SIGN_STANDARD_ERRORS = (
    3.0  # standard errors beyond the sign: what noise alone does once in 700 times is no contradiction
)
FREE = 1000.0  # per cent: a prior that holds no joint's share


def physical_contradiction(hypothesis: Hypothesis) -> str | None:
    """What the effect that was accepted last makes impossible, in words; None where the extended arm can exist.

    Its own cones, and the friction of its joints as a sum over all effects at speeds that were recorded. Of dry friction that turns at once
    beside such that builds up, only the sum is known so well that it tells.
    """
    model, robot = hypothesis.extension.model, hypothesis.problem.model.robot
    effect, places = hypothesis.accepted[-1].effect, hypothesis.extension.places[-1]
    cones = () if hypothesis.accepted[-1].candidate.key in hypothesis.built_up else effect.cones(robot)
    for cone in cones:
        rows = np.zeros((len(cone.map), len(model.theta)))
        rows[:, places] = cone.map
        new = places.min() >= len(hypothesis.problem.model.theta)  # what was not there cannot have fallen
        if _negative(hypothesis, rows, cone.offset, 0.0 if new else SIGN_STANDARD_ERRORS):
            return f"{effect.name} would be negative"
    names = [column.joint for column in effect.columns(robot)]
    for j in {joint - 1 for joint in names}:
        fastest = max(float(np.abs(one.v[:, j]).max()) for one in hypothesis.problem.signals)
        speeds = np.linspace(fastest / SPEEDS, fastest, SPEEDS)
        v = np.concatenate([-speeds[::-1], speeds])
        if not effect.friction(robot, v).any():
            continue
        rows = []
        for other in model.effects:
            mine = np.array([column.joint == j + 1 for column in other.columns(robot)])
            rows.append((other.friction(robot, v) * np.sign(v)) * mine[:, None])
        if _negative(hypothesis, np.concatenate(rows).T, np.zeros(len(v)), SIGN_STANDARD_ERRORS):
            return f"friction of joint {j + 1} would drive it"
    return None


def uneven_scales(hypothesis: Hypothesis) -> list[AcceptedEffect]:
    """The accepted scales of all joints whose joints differ by more than their prior lets them, chi squared, or that hold a joint on which
    nothing was found: no scale of all."""
    model, robot, result = hypothesis.extension.model, hypothesis.problem.model.robot, []
    found = {joint for one in hypothesis.accepted for joint in one.candidate.joints}
    for one, places in zip(hypothesis.accepted, hypothesis.extension.places, strict=True):
        if not isinstance(one.effect, SharedScale) or (sizes := one.effect.prior_sizes(robot)) is None:
            continue
        apart = (model.theta[places] / sizes)[1:]
        if not set(one.effect.held) <= found or apart @ apart > limit_of(len(apart), SIGN_STANDARD_ERRORS):
            result.append(one)
    return result


def at_share_of_most(hypothesis: Hypothesis, scale: AcceptedEffect) -> SharedScale | None:
    """An uneven scale at the share that most joints have in common, the others held at it; None where they have none.

    A joint with a fault of its own takes part of it up as its share of a scale: the scale then seems to have nothing in common, and the
    fault less to explain than it does.
    """
    assert isinstance(scale.effect, SharedScale)
    free, robot = replace(scale.effect, uneven_percent=FREE, held=()), hypothesis.problem.model.robot
    accepted = list(hypothesis.accepted)
    at = accepted.index(scale)
    accepted[at] = replace(scale, effect=free)
    fitted = state_hypothesis(hypothesis.problem, accepted, hypothesis.model, hypothesis.data)
    places, percent = fitted.extension.places[at], free.percent(robot)
    covariance = percent @ fitted.covariance[np.ix_(places, places)] @ percent.T
    share = share_of_most(percent @ fitted.extension.model.theta[places], covariance, UNEVEN, SIGN_STANDARD_ERRORS)
    if share is None:
        return None
    return replace(scale.effect, uneven_percent=UNEVEN * abs(share.percent), held=share.others)


def _negative(hypothesis: Hypothesis, rows: Array, offset: Array, doubt: float) -> bool:
    values = rows @ hypothesis.extension.model.theta + offset
    errors = np.sqrt(np.maximum(np.einsum("kp,pq,kq->k", rows, hypothesis.covariance, rows, optimize=True), 0.0))
    return bool((values < -doubt * errors - 1e-12).any())
