"""A scale of all joints, held against what its joints have in common: one that most of them share stands beside the fault of another.

A joint with a fault of its own takes part of it up as its share of a scale. The scale then seems to have nothing in common, and the
fault less to explain than it does. So the share is taken from the joints that agree, and the others are held at it: what is their
own is found beside it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, norm

from physident.diagnosis.problem.candidates import AcceptedEffect
from physident.diagnosis.search.hypothesis import Hypothesis, state_hypothesis
from physident.diagnosis.search.physical_signs import SIGN_STANDARD_ERRORS
from physident.effects.shared_scale import UNEVEN, SharedScale

Array = NDArray[np.float64]
FREE = 1000.0  # per cent: a prior that holds no joint's share
TIMES = 20  # that a share and the scatter about it, which is a part of it, are found from each other: they settle within a few


def uneven_scales(hypothesis: Hypothesis) -> list[AcceptedEffect]:
    """The accepted scales of all joints whose joints differ by more than their prior lets them, chi squared, or hold a joint on which
    nothing was found: no scale of all."""
    model, robot, result = hypothesis.extension.model, hypothesis.problem.model.robot, []
    found = {joint for one in hypothesis.accepted for joint in one.candidate.joints}
    for one, places in zip(hypothesis.accepted, hypothesis.extension.places, strict=True):
        effect = one.effect
        sizes = effect.prior_sizes(robot) if isinstance(effect, SharedScale) else None
        if sizes is None or not isinstance(effect, SharedScale):
            continue
        apart = (model.theta[places] / sizes)[1:]
        if not set(effect.held) <= found or float(np.sum(apart**2)) > _limit(len(apart)):
            result.append(one)
    return result


def at_share_of_most(hypothesis: Hypothesis, scale: AcceptedEffect) -> SharedScale | None:
    """An uneven scale at the share that most joints have in common, the others held at it; None where they have none."""
    assert isinstance(scale.effect, SharedScale)
    share = _share_of_most(*_joint_by_joint(hypothesis, scale))
    if share is None:
        return None
    return replace(scale.effect, uneven_percent=UNEVEN * abs(share.percent), held=share.others)


@dataclass(frozen=True, kw_only=True)
class _Share:
    """A share in ``percent`` with its standard ``error``, how far joints are apart by ``chi_squared``, and the ``others`` (from 1), which
    have another one."""

    percent: float
    error: float
    chi_squared: float
    others: tuple[int, ...]


def _joint_by_joint(hypothesis: Hypothesis, scale: AcceptedEffect) -> tuple[Array, Array]:
    """The share (n,) [%] of each joint, held by no prior, beside all else that was accepted, and their covariance (n, n)."""
    assert isinstance(scale.effect, SharedScale)
    free, robot = replace(scale.effect, uneven_percent=FREE, held=()), hypothesis.problem.model.robot
    accepted = [replace(one, effect=free) if one is scale else one for one in hypothesis.accepted]
    fitted = state_hypothesis(hypothesis.problem, accepted, hypothesis.model, hypothesis.data)
    places, percent = fitted.extension.places[hypothesis.accepted.index(scale)], free.percent(robot)
    return percent @ fitted.extension.model.theta[places], percent @ fitted.covariance[
        np.ix_(places, places)
    ] @ percent.T


def _share_of_most(shares: Array, covariance: Array) -> _Share | None:
    """The share that the most joints have in common; None where half of them have another, or where it may be none."""
    joints = np.arange(len(shares))
    now = _share_of(shares, covariance, joints)
    while now.chi_squared > _limit(len(joints) - 1):
        fewer = [np.delete(joints, k) for k in range(len(joints))]
        tried = [_share_of(shares, covariance, some) for some in fewer]
        best = int(np.argmin([one.chi_squared for one in tried]))
        joints, now = fewer[best], tried[best]
        if 2 * len(joints) <= len(shares):
            return None
    return now if abs(now.percent) > SIGN_STANDARD_ERRORS * now.error else None


def _share_of(shares: Array, covariance: Array, joints: NDArray[np.intp]) -> _Share:
    """What some joints (from 0) have in common, where the share of each scatters about it by a third of it and by its own error."""
    own, noise = shares[joints], covariance[np.ix_(joints, joints)]
    common, weights = float(np.median(own)), np.zeros_like(noise)
    for _ in range(TIMES):
        weights = np.linalg.inv(noise + (UNEVEN * common) ** 2 * np.eye(len(own)))
        common = float(weights.sum(axis=0) @ own / weights.sum())
    left = own - common
    others = np.setdiff1d(np.arange(len(shares)), joints) + 1
    return _Share(
        percent=common,
        error=float(weights.sum() ** -0.5),
        chi_squared=float(left @ weights @ left),
        others=tuple(others.tolist()),
    )


def _limit(count: int) -> float:
    """What chi squared of so many numbers exceeds by noise once in 700 times."""
    return float(chi2.isf(norm.sf(SIGN_STANDARD_ERRORS), count))
