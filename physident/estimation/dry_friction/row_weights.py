"""How uncertain dry friction leaves each row: near standstill its sign is not known, at rest it is any value in between."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.dry_sign import sign_spread
from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor, build_regressor, with_transition
from physident.effects.effect import Effect
from physident.estimation.quick_fit import quick_fit
from physident.estimation.weighting import weight_rows
from physident.large_arrays import blocks, computed
from physident.recordings.signals import Filter, Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
CREEP = 0.01  # rad/s|m/s: there a dry sign has turned, and viscous friction is a few per cent of the dry one
TURNED = 3.0  # widths of a smooth sign: tanh(3) is one to half a per cent
KNOWN = 0.03  # standard deviation of a sign, below which it counts as known: its friction then errs by three per cent
ROUNDS = 3  # of weights and residual's size, each from the other; the second changes weights by a few per cent


def spread_rows(robot: Robot, effects: Sequence[Effect], signals: Sequence[Signals], filter: Filter) -> Array:
    """Standard deviation (M, n) of the filtered sign of each joint's velocity, in each row of the effects' regressor."""
    signals = [with_transition(robot, effects, one) for one in signals]
    return build_regressor(robot, [_SignSpread()], signals, filter).predict(np.ones(robot.n))


def creep(model: Model) -> Array:
    """The speed (n,) [rad/s|m/s] of each joint at which its dry friction has turned, however wide its sign is."""
    stated = [widths for effect in model.effects if (widths := effect.transition(model.robot)) is not None]
    return np.maximum(CREEP, TURNED * np.max([np.zeros(model.robot.n), *stated], axis=0))


def dry_level(model: Model) -> Array:
    """The dry friction (n,) [N m|N] of each joint of a model, at a slow creep; what depends on its load is left out."""
    level, speeds = np.zeros(model.robot.n), creep(model)
    for effect, theta in model.effect_parameters():
        if not effect.dry:
            continue
        friction = effect.friction(model.robot, speeds)
        for k, (column, value) in enumerate(zip(effect.columns(model.robot), theta, strict=True)):
            level[column.joint - 1] += friction[k, column.joint - 1] * value
    return np.maximum(level, 0.0)


def rest_weights(spread: Array, level: Array, residual: Array, counted: NDArray[np.bool_]) -> Array:
    """Weights (M, n) of rows, at most one: those of the noise's variance in its sum with the dry friction's.

    ``spread`` (M, n) is that of ``spread_rows``, ``level`` (n,) [N m|N] the dry friction, ``residual`` (M, n) [N m|N] what
    a model leaves, whose size apart from dry friction is taken from the rows themselves.
    """
    weights = known_rows(spread)
    for _ in range(ROUNDS):
        size, total = np.zeros(len(level)), np.zeros(len(level))
        for some in blocks(len(weights)):
            trusted = weights[some] ** 2 * counted[some]
            size += (trusted * (weights[some] * residual[some]) ** 2).sum(axis=0)
            total += trusted.sum(axis=0)
        variance = np.maximum(size / np.maximum(total, 1e-300), 1e-300)
        weights = computed(spread.shape, lambda some, v=variance: 1 / np.sqrt(1 + (level * spread[some]) ** 2 / v))
    return weights


def row_weights(
    robot: Robot,
    effects: tuple[Effect, ...],
    regressor: Regressor,
    signals: Sequence[Signals],
    filter: Filter,
) -> Array:
    """Weights (M, n) of the regressor's rows: see ``rest_weights``.

    The size of dry friction and of the noise come from a first fit to the rows whose sign is known: an arm that mostly
    rests would else be fitted to its rests.
    """
    spread = spread_rows(robot, effects, signals, filter)
    theta = quick_fit(robot, effects, weight_rows(regressor, known_rows(spread)))
    residual = regressor.residual(theta)
    return rest_weights(spread, dry_level(Model(robot, effects, theta)), residual, regressor.counted)


def known_rows(spread: Array) -> Array:
    """Weights (M, n) of rows for a first fit, near one where the sign of velocity is known and near zero where it is not."""
    return computed(spread.shape, lambda some: 1 / (1 + (spread[some] / KNOWN) ** 2))


@dataclass(frozen=True)
class _SignSpread(Effect):
    """The standard deviation of the sign of each joint's velocity; never part of a model."""

    name: ClassVar[str] = "sign_spread"
    unit: ClassVar[str] = "1"

    def values(self, robot: Robot, signals: Signals) -> Array:
        return sign_spread(signals, range(robot.n))
