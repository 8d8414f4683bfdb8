"""The search at the speeds over which dry friction turns beside what is found, not beside nothing.

``identify`` finds the speed over which each joint's dry friction turns. Where friction builds up over a distance, or a bump of friction
lies at low speed, that speed imitates it. So a turn that is wide gives way to friction that builds up and turns at a creep wherever that
predicts better; and once a bump is found, friction turns faster, or more slowly if it was taken for a sudden turn, and its reversals show what is left.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.problem import DiagnosisProblem, state_problem
from physident.diagnosis.search.forward_search import (
    SearchResult,
    of_problem,
    search_effects,
    settled_hypothesis,
)
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.search.shape_refinement import refine_shape
from physident.diagnosis.statistics.thresholds import MIN_REDUCTION_PERCENT
from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor
from physident.effects.classification import Family
from physident.effects.effect import Effect
from physident.effects.friction import CoulombFriction
from physident.estimation.dry_friction.row_weights import CREEP, turning_widths
from physident.estimation.dry_friction.transition_width import WIDTHS, with_transitions
from physident.estimation.estimate import Estimate
from physident.estimation.shapes.shape_parameters import settled_regressor
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

TURNED_AT_CREEP = 0.42  # of a creep: tanh of its inverse is 98 per cent
AGAIN = 2  # searches more, at most: speeds that still change differ by what no row shows


def search_with_turning_speeds(
    problem: DiagnosisProblem, progress: Callable[[str], None] = lambda _: None
) -> SearchResult:
    """The search of a problem, begun anew while the speeds at which friction turns beside what was found are others than the model's.

    Of a model that was fitted to these recordings; the speeds of any other model are part of what is asked about.
    """
    found, begun = search_effects(_with_sharp_turns(problem), progress), ()
    for _ in range(AGAIN):
        sharper = _with_speeds_beside(found)
        if sharper is None:
            break
        progress("friction turns at another speed beside what was found: searching again")
        found.last.hypothesis.problem.forget()
        # what was found beside friction that turned too slowly may imitate its turn; what was found anew does not
        found = search_effects(sharper, progress, begun)
        begun = found.accepted
    return found


def with_widths_anew(
    problem: DiagnosisProblem, model: Model, signals: Sequence[Signals], may_grow: bool = False
) -> tuple[tuple[Effect, ...], Regressor]:
    """The extended model's effects with the widths of dry friction that ``identify`` found found again, and their regressor: without
    the effects that were missing, a width imitates them. None grows, unless it ``may_grow`` beside other friction that was found."""
    opened = tuple(replace(e, smoothing=None) if _is_open(e) else e for e in model.effects)
    widest = _widest(model, may_grow)
    regressor = settled_regressor(model.robot, opened, signals, problem.filter, model.theta)
    return with_transitions(model.robot, opened, regressor, signals, problem.filter, widest)


def _is_open(effect: Effect) -> bool:
    """Whether an effect is Coulomb friction whose width ``identify`` found."""
    return isinstance(effect, CoulombFriction) and isinstance(effect.smoothing, tuple)


def _with_sharp_turns(problem: DiagnosisProblem) -> DiagnosisProblem:
    """The problem with friction that turns at a creep on the joints where friction that builds up over a distance leaves less beside that than
    beside a wide turn, by what is worth naming; where these are most joints, on all that are no worse, for the gears of an arm are alike.

    Both are judged on the rows that are certain where the sign turns at once: beside a wide turn those near a reversal hardly count.
    """
    creep = max(width for width in WIDTHS if width <= TURNED_AT_CREEP * CREEP) * problem.model.robot.radian
    wide = {j for e in filter(_is_open, problem.model.effects) for j in _wider(e, problem.model.robot, creep)}
    if problem.question != "missing" or not isinstance(problem.given, Estimate) or not wide:
        return problem
    sharp = _turning_at(problem, wide, creep)
    before, after = (_rms_with_bristles(settled_hypothesis(one, ()), sharp.weights, wide) for one in (problem, sharp))
    better = {j for j in wide if after[j] < (1 - MIN_REDUCTION_PERCENT / 100) * before[j]}
    if 2 * len(better) > len(wide):
        better |= {j for j in wide if after[j] <= before[j]}
    if better < wide:
        sharp.forget()
        return _turning_at(problem, better, creep) if better else problem
    problem.forget()
    return sharp


def _wider(effect: Effect, robot: Robot, creep: NDArray[np.float64]) -> list[int]:
    """The joints (from 0) on which friction turns over more than a ``creep`` (n,) [rad/s|m/s]."""
    widths = effect.transition(robot)
    return [] if widths is None else [j for j in effect.active(robot) if widths[j] > creep[j]]


def _turning_at(problem: DiagnosisProblem, joints: Collection[int], creep: NDArray[np.float64]) -> DiagnosisProblem:
    """The problem with friction that turns at a ``creep`` (n,) [rad/s|m/s] on some joints (from 0)."""
    robot, given, effects = problem.model.robot, problem.given, []
    assert isinstance(given, Estimate)
    for effect in given.model.effects:
        if _is_open(effect) and (widths := effect.transition(robot)) is not None:
            own = [float(min(widths[j], creep[j]) if j in joints else widths[j]) for j in effect.active(robot)]
            effect = replace(effect, smoothing=tuple(own))
        effects.append(effect)
    return _restated(problem, tuple(effects))


def _restated(problem: DiagnosisProblem, effects: tuple[Effect, ...]) -> DiagnosisProblem:
    """The same question of a model whose friction turns as that of these effects."""
    given = problem.given
    assert isinstance(given, Estimate)
    signals = [replace(one, transition=None) for one in problem.signals]
    other = replace(given, model=replace(given.model, effects=effects))
    return state_problem(problem.question, other, signals, problem.filter, problem.seed, problem.recording_offsets)


def _rms_with_bristles(
    hypothesis: Hypothesis, weights: NDArray[np.float64], joints: Collection[int]
) -> dict[int, float]:
    """The RMS [N m|N] of rows by some ``weights`` (M, n) that is left of each of some joints (from 0) where its friction may build up over a
    distance, each joint by itself."""
    left, size = {j: hypothesis.residual[:, j] for j in joints}, np.sum(weights**2, axis=0)
    for one in hypothesis.data.candidates:
        effect = one.options[0].effect
        bristles = effect is not None and effect.dry and not effect.pointwise
        if bristles and len(one.joints) == 1 and (j := one.joints[0] - 1) in left:
            left[j] = hypothesis.with_effect(one, refine_shape(hypothesis, one)).residual[:, j]
    # a joint that no row counts has none
    return {j: float(np.sqrt(np.sum((weights[:, j] * one) ** 2) / max(size[j], 1e-300))) for j, one in left.items()}


def _with_speeds_beside(found: SearchResult) -> DiagnosisProblem | None:
    """The problem with friction that turns as it does beside the accepted effects, or None where it turns as before."""
    problem, model = found.last.hypothesis.problem, found.last.hypothesis.extension.model
    given = problem.given
    rubs = any(one.effect.dry or one.effect.family is Family.FRICTION for one in found.accepted)
    turned = rubs and any(map(_is_open, problem.model.effects))
    if problem.question != "missing" or not isinstance(given, Estimate) or not turned:
        return None
    signals = [replace(one, transition=None) for one in problem.signals]
    for may_grow in (True, False):
        widths = [e for e in with_widths_anew(problem, model, signals, may_grow)[0] if isinstance(e, CoulombFriction)]
        kept = iter(widths)
        effects = tuple(next(kept) if isinstance(e, CoulombFriction) else e for e in given.model.effects)
        if effects == given.model.effects:
            return None
        other = _restated(problem, effects)
        if not may_grow or not _errs_more_where_it_grew(found, other):
            return other
        other.forget()
    return None


def _errs_more_where_it_grew(found: SearchResult, other: DiagnosisProblem) -> bool:
    """Whether a wider turn leaves more of all rows of a joint: those that it calls uncertain may be those that it describes worse."""
    now, then = (turning_widths(one.model) for one in (found.last.hypothesis.problem, other))
    grown = then > now
    if not grown.any():
        return False
    left = [
        np.sqrt(np.sum(one.residual**2, axis=0))
        for one in (found.last.hypothesis, settled_hypothesis(other, of_problem(other, found.accepted)))
    ]
    return bool(np.any(left[1][grown] > left[0][grown]))


def _widest(model: Model, may_grow: bool) -> NDArray[np.float64]:
    """The widths (n,) [rad/s|m/s] over which a model's dry friction turns, at most. Where it builds up over a distance, too, no wider than now:
    a wider turn calls the rows uncertain that alone tell the two apart. Where more than its level was found, such as that of a breakaway torque,
    it ``may_grow``, because a sudden turn may have stood for that."""
    widest, more = turning_widths(model), [e for e in model.effects if e.dry and not _is_open(e)]
    levels, bristles = (
        {j for e in more if e.pointwise == at_once for j in e.active(model.robot)} for at_once in (True, False)
    )
    if may_grow:
        widest[sorted(levels - bristles)] = np.inf
    return widest
