"""The speed over which each joint's dry friction turns, where a model leaves it open: zero where the joint sticks.

It is chosen joint by joint: the smallest that does as well as any, after all other columns of the joint are refitted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.dry_sign import WIDEST
from physident.dynamics.model import Model
from physident.dynamics.regressor import JointRows, Regressor, build_regressor
from physident.effects.effect import Effect
from physident.effects.friction import CoulombFriction
from physident.effects.learned.curve import LearnedCurve
from physident.estimation.dry_friction.row_weights import row_weights
from physident.estimation.quick_fit import quick_fit
from physident.estimation.weighting import weight_rows
from physident.identifiability.base_parameters import find_base_parameters
from physident.large_arrays import blocks, triangle
from physident.recordings.signals import Filter, Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
TOLD_APART = 3.84  # 95 % of the squares by which one parameter fits noise better, in units of its variance
WIDTHS = (0.0, 0.0005, 0.001, 0.002, 0.004, 0.008, 0.016, 0.032, WIDEST)  # rad/s


def with_transitions(
    robot: Robot,
    effects: tuple[Effect, ...],
    regressor: Regressor,
    signals: Sequence[Signals],
    filter: Filter,
    widest: Array | None = None,
) -> tuple[tuple[Effect, ...], Regressor]:
    """The effects with every width of Coulomb friction set, at most the ``widest`` (n,) [rad/s|m/s], and their regressor."""
    places = [i for i, e in enumerate(effects) if isinstance(e, CoulombFriction) and e.smoothing is None]
    if not places:
        return effects, regressor
    if regressor.counted.sum() < len(regressor.columns):  # rows that fit anything show no width
        dry = [replace(e, smoothing=0.0) if i in places else e for i, e in enumerate(effects)]
        return tuple(dry), regressor
    weights = row_weights(robot, effects, regressor, signals, filter)
    found = list(effects)
    for place in places:
        effect = effects[place]
        active = effect.active(robot)
        every = [replace(effect, smoothing=tuple(width * robot.radian[active])) for width in WIDTHS]
        tried = [build_regressor(robot, [one], signals, filter).joints for one in every]
        levels = _levels(robot, effects)
        independent = [i for i in find_base_parameters(robot, effects).independent if i not in levels]
        widths = [
            robot.radian[j]
            * _best_width(regressor, tried[: _count(robot, widest, j)], weights, j, k, independent, filter.cutoff)
            for k, j in enumerate(active)
        ]
        found[place] = replace(effect, smoothing=tuple(map(float, widths)))
    dry = [effect for effect in found if effect.dry]
    owner = [effect for effect in found for _ in effect.columns(robot)]
    columns = np.array([i for i, effect in enumerate(owner) if effect.dry], dtype=np.intp)
    theta = quick_fit(robot, effects, weight_rows(regressor, weights))
    fresh = build_regressor(robot, dry, signals, filter, model=Model(robot, tuple(found), theta))
    return tuple(found), regressor.with_columns(fresh, columns)


def model_with_transitions(model: Model, signals: Sequence[Signals], filter: Filter) -> Model:
    """A model with every width of Coulomb friction that it leaves open found in recordings; its values stay as they are."""
    if not any(isinstance(e, CoulombFriction) and e.smoothing is None for e in model.effects):
        return model
    regressor = build_regressor(model.robot, model.effects, signals, filter, model=model)
    effects, _ = with_transitions(model.robot, model.effects, regressor, signals, filter)
    return replace(model, effects=effects)


def _levels(robot: Robot, effects: Sequence[Effect]) -> set[int]:
    """The columns that are the constants of curves of dry friction: with one of them, nothing of Coulomb friction is left to be seen."""
    owner = [(effect, k) for effect in effects for k in range(len(effect.columns(robot)))]
    return {
        i
        for i, (effect, k) in enumerate(owner)
        if isinstance(effect, LearnedCurve)
        and effect.dry
        and effect.has_mean
        and k % (len(effect.columns(robot)) // len(effect.active(robot))) == 0
    }


def _count(robot: Robot, widest: Array | None, j: int) -> int:
    """How many widths are tried for joint j (index)."""
    own = np.array(WIDTHS) * robot.radian[j]
    return len(WIDTHS) if widest is None else int(np.searchsorted(own, widest[j], side="right"))


def _best_width(
    regressor: Regressor,
    tried: list[tuple[JointRows, ...]],
    weights: Array,
    j: int,
    k: int,
    independent: Sequence[int],
    cutoff: float,
) -> float:
    """The smallest of the widths that the rows of joint j (index) do not tell from the one with which they leave least;
    ``k`` is its column in the tried ones."""
    rows, w = regressor.joints[j], weights[:, j, None]
    signs = [one[j].plain[:, list(one[j].columns).index(k)] for one in tried]
    own = f"coulomb_friction_{j + 1}"
    others = [i for i, c in enumerate(rows.columns) if c in independent and regressor.columns[c].name != own]
    stacked = (
        np.column_stack([rows.some(b)[:, others], *(sign[b] for sign in signs), regressor.torque[b, j]]) * w[b]
        for b in blocks(len(w))
    )
    R = triangle(stacked)[len(others) :, len(others) :]
    S, y = R[:, :-1], R[:, -1]
    gains = (S.T @ y) ** 2 / np.maximum((S**2).sum(axis=0), 1e-300)
    # rows of a filtered torque are worth as many independent ones as its band holds
    variance = (y @ y - gains.max()) / max(1, len(w) - len(others) - 1)
    told_apart = TOLD_APART * variance * max(1.0, regressor.kept_rate / (2 * cutoff))
    return float(WIDTHS[int(np.argmax(gains >= gains.max() - told_apart))])
