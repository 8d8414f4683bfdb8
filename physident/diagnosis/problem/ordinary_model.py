"""The model with the default effects that it lacks, fitted to the recordings: how wide and how strong their dry friction is.

The search begins with these effects, so the sign that their friction has, and how little the rows near standstill count,
must be known before it.
"""

from __future__ import annotations

from collections.abc import Sequence

from physident.dynamics.model import Model
from physident.dynamics.regressor import build_regressor
from physident.effects.catalogue import CATALOGUE, DEFAULT_EFFECTS
from physident.effects.classification import Scope
from physident.effects.effect import Effect
from physident.estimation.dry_friction.transition_width import model_with_transitions
from physident.estimation.quick_fit import quick_fit
from physident.recordings.signals import Filter, Signals


def ordinary_model(model: Model, signals: Sequence[Signals], filter: Filter) -> Model:
    """The model itself where every joint has dry friction; else fitted with the default effects that it lacks, their widths found."""
    robot = model.robot
    if len({joint for effect in model.effects if effect.dry for joint in effect.active(robot)}) == robot.n:
        return model
    effects = (*model.effects, *_missing(model))
    regressor = build_regressor(robot, effects, signals, filter)
    return model_with_transitions(Model(robot, effects, quick_fit(robot, effects, regressor)), signals, filter)


def _missing(model: Model) -> list[Effect]:
    present = {(effect.name, j + 1) for effect in model.effects for j in effect.active(model.robot)}
    found = []
    for name in DEFAULT_EFFECTS:
        joints = tuple(j for j in range(1, model.robot.n + 1) if (name, j) not in present)
        if CATALOGUE[name].scope is Scope.JOINT and joints:
            found.append(CATALOGUE[name](joints=joints))
    return found
