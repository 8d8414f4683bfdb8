"""The search once more, where dry friction turns at other speeds beside what was found.

``identify`` finds the speed over which each joint's dry friction turns. Where friction builds up over a distance, or a bump of friction
lies at low speed, that speed imitates it; once part of this is found, friction turns faster, and its reversals show what is left.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.problem import DiagnosisProblem, state_problem
from physident.diagnosis.search.forward_search import SearchResult, search_effects
from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor
from physident.effects.classification import Family
from physident.effects.effect import Effect
from physident.effects.friction import CoulombFriction
from physident.estimation.dry_friction.row_weights import CREEP
from physident.estimation.dry_friction.transition_width import with_transitions
from physident.estimation.estimate import Estimate
from physident.estimation.shapes.shape_parameters import settled_regressor
from physident.recordings.signals import Signals

TURNED_AT_CREEP = 0.42  # of a creep: tanh of its inverse is 98 per cent
AGAIN = 2  # searches more, at most: speeds that still change differ by what no row shows


def search_with_turning_speeds(
    problem: DiagnosisProblem, progress: Callable[[str], None] = lambda _: None
) -> SearchResult:
    """The search of a problem, begun anew while the speeds at which friction turns beside what was found are others than the model's.

    Of a model that was fitted to these recordings; the speeds of any other model are part of what is asked about.
    """
    found, begun = search_effects(problem, progress), ()
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
    problem: DiagnosisProblem, model: Model, signals: Sequence[Signals]
) -> tuple[tuple[Effect, ...], Regressor]:
    """The extended model's effects with the widths of dry friction that ``identify`` found found again, and their regressor: without
    the effects that were missing, a width imitates them. So no width grows."""
    opened = tuple(replace(e, smoothing=None) if _is_open(e) else e for e in model.effects)
    widest = _widest(model)
    regressor = settled_regressor(model.robot, opened, signals, problem.filter, model.theta)
    return with_transitions(model.robot, opened, regressor, signals, problem.filter, widest)


def _is_open(effect: Effect) -> bool:
    """Whether an effect is Coulomb friction whose width ``identify`` found."""
    return isinstance(effect, CoulombFriction) and isinstance(effect.smoothing, tuple)


def _with_speeds_beside(found: SearchResult) -> DiagnosisProblem | None:
    """The problem with friction that turns as it does beside the accepted effects, or None where it turns as before."""
    problem, model = found.last.hypothesis.problem, found.last.hypothesis.extension.model
    given = problem.given
    rubs = any(one.effect.dry or one.effect.family is Family.FRICTION for one in found.accepted)
    turned = rubs and any(map(_is_open, problem.model.effects))
    if problem.question != "missing" or not isinstance(given, Estimate) or not turned:
        return None
    signals = [replace(one, transition=None) for one in problem.signals]
    widths = [e for e in with_widths_anew(problem, model, signals)[0] if isinstance(e, CoulombFriction)]
    kept = iter(widths)
    effects = tuple(next(kept) if isinstance(e, CoulombFriction) else e for e in given.model.effects)
    if effects == given.model.effects:
        return None
    sharper = replace(given, model=replace(given.model, effects=effects))
    return state_problem(problem.question, sharper, signals, problem.filter, problem.seed, problem.recording_offsets)


def _widest(model: Model) -> NDArray[np.float64]:
    """The widths (n,) [rad/s|m/s] over which a model's dry friction turns, at most. Where it builds up over a distance, too, its sign has turned
    at a creep: a wider turn calls the rows uncertain that alone tell the two apart."""
    widths = [own for effect in model.effects if (own := effect.transition(model.robot)) is not None]
    bristled = [j for e in model.effects if e.dry and not e.pointwise for j in e.active(model.robot)]
    widest = np.max([np.zeros(model.robot.n), *widths], axis=0)
    widest[bristled] = np.minimum(widest, TURNED_AT_CREEP * CREEP * model.robot.radian)[bristled]
    return widest
