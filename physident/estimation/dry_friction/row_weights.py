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
from physident.estimation.uncertainty import correlation_rows
from physident.estimation.weighting import weight_rows
from physident.large_arrays import blocks, computed, empty
from physident.recordings.signals import Filter, Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
CREEP = 0.01  # rad/s: there a dry sign has turned, and viscous friction is a few per cent of the dry one
TURNED = 3.0  # widths of a smooth sign: tanh(3) is one to half a per cent
KNOWN = 0.03  # standard deviation of a sign, below which it counts as known: its friction then errs by three per cent
ROUNDS = 3  # of weights and residual's size, each from the other; the second changes weights by a few per cent


def spread_rows(robot: Robot, effects: Sequence[Effect], signals: Sequence[Signals], filter: Filter) -> Array:
    """Standard deviation (M, n) of the filtered sign of each joint's velocity, in each row of the effects' regressor."""
    signals = [with_transition(robot, effects, one) for one in signals]
    return build_regressor(robot, [_SignSpread()], signals, filter).predict(np.ones(robot.n))


def creep(model: Model) -> Array:
    """The speed (n,) [rad/s|m/s] of each joint at which its dry friction has turned, however wide its sign is."""
    return np.maximum(CREEP * model.robot.radian, TURNED * turning_widths(model))


def turning_widths(model: Model) -> Array:
    """The widths (n,) [rad/s|m/s] over which a model's dry friction turns, zero where there is none or it turns at once."""
    stated = [widths for effect in model.effects if (widths := effect.transition(model.robot)) is not None]
    return np.max([np.zeros(model.robot.n), *stated], axis=0)


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


def rest_weights(spread: Array, level: Array, residual: Array, regressor: Regressor) -> Array:
    """Weights (M, n) of a regressor's rows, at most one: those of the noise's variance in its sum with the dry friction's.

    ``spread`` (M, n) is that of ``spread_rows``, ``level`` (n,) [N m|N] the dry friction, ``residual`` (M, n) [N m|N] what
    a model leaves, whose size apart from dry friction is taken from the rows themselves. The friction that a row does not know is
    the same in its whole rest, which therefore counts as one sample of it, however long it lasts; unless the model predicts
    rests better than by chance, as one with bristles does.
    """
    weights = known_rows(spread)
    memory = correlation_rows(regressor, computed(spread.shape, lambda some, w=weights: w[some] * residual[some]))
    common = _samples_in_common(spread, level, residual * regressor.counted, regressor.segment, memory)
    for _ in range(ROUNDS):
        size, total = np.zeros(len(level)), np.zeros(len(level))
        for some in blocks(len(weights)):
            trusted = weights[some] ** 2 * regressor.counted[some]
            size += (trusted * (weights[some] * residual[some]) ** 2).sum(axis=0)
            total += trusted.sum(axis=0)
        variance = np.maximum(size / np.maximum(total, 1e-300), 1e-300)
        weights = computed(
            spread.shape, lambda some, v=variance: 1 / np.sqrt(1 + common[some] * (level * spread[some]) ** 2 / v)
        )
    return weights


def _samples_in_common(spread: Array, level: Array, residual: Array, segment: NDArray[np.intp], memory: Array) -> Array:
    """In how many independent samples (M, n) of the noise the doubt about a row's friction is one and the same, at least one.

    A rest has as many as it lasts, by the share of its friction's variance that a model misses. ``segment`` (M,) labels contiguous
    rows, ``memory`` (n,) says how many rows of noise are worth one.
    """
    common = empty(spread.shape)
    for j in range(len(memory)):
        edges = _runs(spread[:, j], segment)
        samples, missed, chance = np.diff(edges) / memory[j], np.zeros(len(edges) - 1), np.zeros(len(edges) - 1)
        for some in blocks(len(spread)):
            run, unknown = _places(edges, some), spread[some, j] > KNOWN
            missed += np.bincount(run, unknown * residual[some, j], len(missed))
            chance += np.bincount(run, unknown * (level[j] * spread[some, j]) ** 2, len(chance))
        long = samples > 1  # what is shorter is a reversal
        share = float((missed**2 / np.diff(edges))[long].sum() / max(chance[long].sum(), 1e-300))
        for some in blocks(len(spread)):
            inside = spread[some, j] > KNOWN
            common[some, j] = np.where(inside, np.maximum(1.0, min(share, 1.0) * samples[_places(edges, some)]), 1.0)
    return common


def _places(edges: NDArray[np.intp], some: slice) -> NDArray[np.intp]:
    """Of which run (m,) some rows are."""
    return np.searchsorted(edges, np.arange(some.start, some.stop), "right") - 1


def _runs(spread: Array, segment: NDArray[np.intp]) -> NDArray[np.intp]:
    """Where runs of rows begin that all know the sign, or all do not; and the number of rows."""
    found = [np.zeros(1, dtype=np.intp)]
    for some in blocks(len(spread)):
        before = slice(max(some.start - 1, 0), some.stop)
        unknown = spread[before] > KNOWN
        found.append(before.start + 1 + np.flatnonzero((unknown[1:] != unknown[:-1]) | (np.diff(segment[before]) != 0)))
    return np.concatenate([*found, [len(spread)]])


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
    return rest_weights(spread, dry_level(Model(robot, effects, theta)), residual, regressor)


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
