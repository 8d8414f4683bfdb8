"""More of all the friction of a joint, as another story of what was found there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.rivals.refuted import costs_with, is_refuted
from physident.diagnosis.rivals.same_torque import Span, outside_of, random_motion, stacked
from physident.diagnosis.search.hypothesis import Hypothesis, state_hypothesis
from physident.diagnosis.statistics.stored_products import Key
from physident.dynamics.regressor import build_regressor
from physident.effects.classification import Family

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class WholeFriction:
    """By what ``share`` all friction of a joint would have to be larger to make nearly the torque of an effect, ``beside`` others of the joint
    (their names)."""

    share: float
    beside: tuple[str, ...] = ()


def whole_friction(hypothesis: Hypothesis) -> dict[Key, WholeFriction]:
    """The accepted effects of one joint that make nearly a multiple of all the friction that the model has there, on any motion.

    An effect that is no friction does so by itself: where nearly all torque of a wrist is friction, a motor that gives less is more friction of
    every kind. Laws of friction of the model do so together: dry and viscous friction of a joint that both are a third larger are one change.
    """
    problem, robot = hypothesis.problem, hypothesis.problem.model.robot
    p, groups, laws = len(problem.model.theta), list[list[int]](), dict[int, list[int]]()
    for i, one in enumerate(hypothesis.accepted):
        if len(one.candidate.joints) != 1 or len(one.effect.columns(robot)) != 1:
            continue
        if one.effect.family is not Family.FRICTION:
            groups.append([i])
        elif hypothesis.extension.places[i].max() < p:
            laws.setdefault(one.candidate.joints[0], []).append(i)
    groups += [several for several in laws.values() if len(several) > 1]
    if not groups:
        return {}
    signals, result, some = random_motion(problem), {}, [hypothesis.accepted[i] for group in groups for i in group]
    effects = [*problem.model.effects, *(one.effect for one in some)]
    regressor = build_regressor(robot, effects, [signals], problem.filter, model=hypothesis.model)
    owners = np.repeat([e.family is Family.FRICTION for e in effects], [len(e.columns(robot)) for e in effects])
    theta = np.zeros(len(owners))
    theta[:p] = problem.model.theta * owners[:p]
    every, at = stacked(regressor, hypothesis.fit.sigma), p
    friction, outside = (every @ theta).reshape(-1, robot.n), outside_of(every, problem)
    for group in groups:
        j = hypothesis.accepted[group[0]].candidate.joints[0] - 1
        mine = (friction * (np.arange(robot.n) == j)).reshape(-1, 1)
        torque = every[:, at : at + len(group)] @ np.concatenate([hypothesis.effect_values[i] for i in group])
        at += len(group)
        alike = mine.any() and Span.of(outside(mine)).makes(outside(torque), 1, robot.n)
        if alike and not _more_friction_is_refuted(hypothesis, group, j, np.flatnonzero(owners[:p]), theta):
            share = float(mine[:, 0] @ torque / (mine[:, 0] @ mine[:, 0]))
            for i in group:
                beside = tuple(hypothesis.accepted[k].candidate.name for k in group if k != i)
                result[hypothesis.accepted[i].candidate.key] = WholeFriction(share=share, beside=beside)
    return result


def _more_friction_is_refuted(
    hypothesis: Hypothesis, group: Sequence[int], joint: int, columns: NDArray[np.intp], theta: Array
) -> bool:
    """Whether these recordings refute that a ``joint`` (from 0) has more of all its friction, which the model's ``columns`` hold, instead of a
    group of accepted effects."""
    others = [one for i, one in enumerate(hypothesis.accepted) if i not in group]
    rest = state_hypothesis(hypothesis.problem, others, hypothesis.model, hypothesis.data)
    torque = hypothesis.data.columns(columns.tolist()).torque(theta[columns])
    torque[:, np.arange(torque.shape[1]) != joint] = 0.0
    weights = hypothesis.fit.weights
    return is_refuted(weights**2 * hypothesis.left_out_squares, costs_with(rest, torque, weights))
