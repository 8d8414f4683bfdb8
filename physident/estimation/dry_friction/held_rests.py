"""Rests at the edge of what friction can hold: there, and only there, a joint at rest shows its gravity and its friction.

While a joint rests, its dry friction is a latent torque f with |f| <= F. For given parameters its best value is the one inside
the band that is nearest to the measured torque: where that is the band's edge, the rest is one more equation; elsewhere it
says nothing. Least squares and the choice of edges follow each other until no rest changes sides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor, build_regressor, with_transition
from physident.effects.effect import Effect
from physident.estimation.dry_friction.rest import dry_friction
from physident.estimation.dry_friction.row_weights import row_weights
from physident.estimation.quick_fit import quick_fit
from physident.estimation.weighting import weight_rows
from physident.large_arrays import release
from physident.recordings.rests import Rests
from physident.recordings.signals import Filter, Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
ROUNDS = 10  # a rest that still changes sides lies at its band's edge, where both sides say the same
PIECE = 0.2  # s: over so long a joint at rest counts as held by one torque, however much that changes
ALIKE = 4.0  # standard deviations, of which a few pieces give a rough idea: a rest whose pieces differ by less is held by one torque
STEP = 1.15 * np.sqrt(2)  # what three of four differences of two values stay below, in their standard deviations


def settle_rests(
    robot: Robot, effects: tuple[Effect, ...], regressor: Regressor, signals: Sequence[Signals], filter: Filter
) -> tuple[list[Signals], Regressor]:
    """The signals with their rests held where least squares finds the band exhausted, and the regressor of these."""
    signals = list(signals)
    for _ in range(ROUNDS):
        weights = row_weights(robot, effects, regressor, signals, filter)
        model = Model(robot, effects, quick_fit(robot, effects, weight_rows(regressor, weights)))
        held = hold_rests(model, signals)
        if same_sides(signals, held):
            break
        signals, regressor = held, with_dry_columns(model, regressor, held, filter)
    return signals, regressor


def with_dry_columns(model: Model, regressor: Regressor, signals: Sequence[Signals], filter: Filter) -> Regressor:
    """The regressor of a model's effects with the columns that follow the sign of velocity evaluated anew."""
    dry = [effect for effect in model.effects if effect.dry]
    if not dry:
        return regressor
    owner = [effect for effect in model.effects for _ in effect.columns(model.robot)]
    places = np.array([i for i, effect in enumerate(owner) if effect.dry], dtype=np.intp)
    signals = [with_transition(model.robot, model.effects, one) for one in signals]
    return regressor.with_columns(build_regressor(model.robot, dry, signals, filter, model=model), places)


def hold_rests(model: Model, signals: Sequence[Signals]) -> list[Signals]:
    """The signals with every rest in pieces, and for each piece the side on which a model's friction is exhausted."""
    return [_held(model, one) for one in signals]


def same_sides(before: Sequence[Signals], after: Sequence[Signals]) -> bool:
    """Whether no rest has changed sides."""
    pairs = [
        (a.held, b.held)
        for one, other in zip(before, after, strict=True)
        for a, b in zip(one.rests or (), other.rests or (), strict=True)
    ]
    return all(a is not None and b is not None and np.array_equal(a, b, equal_nan=True) for a, b in pairs)


def _held(model: Model, signals: Signals) -> Signals:
    if signals.rests is None or signals.torque is None:
        return signals
    pieces = [_pieces(rests, max(3, round(PIECE * signals.rate))) for rests in signals.rests]
    free = replace(signals, rests=tuple(pieces))
    sums = [np.zeros((2, len(rests.start))) for rests in pieces]
    pointwise = all(effect.pointwise for effect in model.effects)
    for samples in free.blocks(pointwise=pointwise):
        part = free.part(samples)
        looked_at = np.any([rests.mask(len(part.time)) for rests in part.rests or ()], axis=0) | (not pointwise)
        wanted, level = np.zeros(part.q.shape), np.zeros(part.q.shape)
        if looked_at.any():
            wanted[looked_at], level[looked_at] = _wanted(model, part.at(looked_at) if pointwise else part)
        for j, (rests, total) in enumerate(zip(pieces, sums, strict=True)):
            _add(total, rests, samples, wanted[:, j], np.abs(level[:, j]))
        release()
    held = [_sides(rests, *total) for rests, total in zip(pieces, sums, strict=True)]
    return replace(free, rests=tuple(replace(r, held=h) for r, h in zip(pieces, held, strict=True)))


def _wanted(model: Model, signals: Signals) -> tuple[Array, Array]:
    """The dry friction (N, n) [N m|N] that would explain the measured torque at each sample, and its level there."""
    assert signals.torque is not None
    referred = model.refer(signals)
    now, level = dry_friction(model, referred)
    return now + signals.torque - model.measured_torque(referred), level


def _sides(rests: Rests, wanted: Array, most: Array) -> Array:
    """The sign (K,) of the friction that holds each piece of rests, NaN within the band, of its sums of wanted and of most friction.

    Neighbours that differ by no more than noise are one rest and held alike. Held one by one, of a rest at its band's edge those
    pieces would count whose noise points outward.
    """
    lasts = rests.stop - rests.start
    follows = rests.start == np.append(-1, rests.stop)[: len(lasts)]
    steps = np.abs(np.diff(wanted / lasts, prepend=np.nan))[follows]
    noise = float(np.quantile(steps, 0.75)) / STEP if len(steps) else 0.0
    held, first = np.full(len(lasts), np.nan), 0
    for k in range(1, len(lasts) + 1):
        group = slice(first, k)
        mean = wanted[group].sum() / lasts[group].sum()
        if k < len(lasts) and follows[k] and abs(wanted[k] / lasts[k] - mean) <= ALIKE * noise:
            continue
        if abs(wanted[group].sum()) > most[group].sum():
            held[group] = np.sign(mean)
        first = k
    return held


def _add(total: Array, rests: Rests, samples: slice, *values: Array) -> None:
    """Add the sums of values (N,) of some samples over each rest to ``total`` (len(values), K)."""
    chosen = np.flatnonzero((rests.stop > samples.start) & (rests.start < samples.stop))
    first = np.maximum(rests.start[chosen], samples.start) - samples.start
    last = np.minimum(rests.stop[chosen], samples.stop) - samples.start
    for k, value in enumerate(values):
        sums = np.concatenate([[0.0], np.cumsum(value)])
        total[k, chosen] += sums[last] - sums[first]


def _pieces(rests: Rests, longest: int) -> Rests:
    """The rests in pieces of about ``longest`` samples, held by nothing; those that were held are in pieces."""
    if rests.held is not None or not len(rests.start):
        return replace(rests, held=None)
    start, stop, owner = [], [], []
    for k, (first, last) in enumerate(zip(rests.start, rests.stop, strict=True)):
        edges = np.linspace(first, last, max(1, round((last - first) / longest)) + 1).round().astype(np.intp)
        start.append(edges[:-1])
        stop.append(edges[1:])
        owner.append(np.full(len(edges) - 1, k))
    which = np.concatenate(owner)
    return Rests(
        start=np.concatenate(start), stop=np.concatenate(stop), before=rests.before[which], after=rests.after[which]
    )
