"""Joints at rest in a score: their dry friction takes the value inside its band that serves a model best."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.column_structure import kept_rows
from physident.dynamics.model import Model
from physident.effects.effect import Effect
from physident.estimation.dry_friction.row_weights import creep
from physident.large_arrays import empty, release
from physident.recordings.signals import Filter, Signals

Array = NDArray[np.float64]
DOUBT = 3.0  # standard deviations of the torque's noise


@dataclass(frozen=True, kw_only=True, eq=False)
class RestRows:
    """What rests mean for the M rows of a regressor.

    ``friction`` (M, n) [N m|N]: what the friction of joints at rest adds to a model's torque, at the best value inside its
    band; ``moving`` (M, n): rows whose whole filter window holds no rest of that joint; ``outside`` (n,): the share of the
    samples at rest that are beyond the band.
    """

    friction: Array
    moving: NDArray[np.bool_]
    outside: Array


def rest_rows(model: Model, signals: Sequence[Signals], filter: Filter) -> RestRows:
    """The rests of signals as a model explains them, in the rows that ``build_regressor`` keeps."""
    friction, moving = [], []
    beyond, resting = np.zeros(model.robot.n), np.zeros(model.robot.n)
    for one in signals:
        added, before = empty(one.q.shape), empty((len(one.q) + 1, model.robot.n), np.int32)
        before[0] = 0
        for samples in one.blocks(pointwise=all(effect.pointwise for effect in model.effects)):
            part = one.part(samples)
            at_rest = _at_rest(part)
            added[samples], out = _best_friction(model, part, at_rest, one.torque_noise)
            beyond, resting = beyond + out.sum(axis=0), resting + at_rest.sum(axis=0)
            before[samples.start + 1 : samples.stop + 1] = before[samples.start] + np.cumsum(at_rest, axis=0)
            release()
        length = len(filter.taps(one.rate))
        for piece in kept_rows(model.robot, one, filter, moving_only=True):
            friction.append(filter.apply(added[piece.samples].T, one.rate)[:, piece.rows].T)
            first = piece.samples.start + piece.rows * filter.decimation(one.rate)
            moving.append(before[first + length] == before[first])
    return RestRows(
        friction=np.concatenate(friction),
        moving=np.concatenate(moving),
        outside=beyond / np.maximum(resting, 1),
    )


def _at_rest(signals: Signals) -> NDArray[np.bool_]:
    """Which samples (N, n) of each joint are at rest."""
    if signals.rests is None:
        return np.zeros(signals.q.shape, dtype=bool)
    return np.column_stack([rests.mask(len(signals.time)) for rests in signals.rests])


def _best_friction(
    model: Model, signals: Signals, at_rest: NDArray[np.bool_], noise: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """The change (N, n) [N m|N] of friction at rest that serves a model best, and which samples lie beyond its band by more
    than the torque's ``noise`` (n,) [N m|N]."""
    if not at_rest.any():
        return np.zeros(at_rest.shape), at_rest
    assert signals.torque is not None
    referred = model.refer(signals)
    now, level = dry_friction(model, referred)
    wanted, level = now + signals.torque - model.measured_torque(referred), np.abs(level)
    beyond = at_rest & (np.abs(wanted) > level + DOUBT * noise)
    return np.where(at_rest, np.clip(wanted, -level, level) - now, 0.0), beyond


def dry_friction(model: Model, referred: Signals) -> tuple[Array, Array]:
    """The dry friction (N, n) [N m|N] that a model has at each sample, and its level there: that of a slow creep;
    ``referred`` are the signals of ``Model.refer``."""
    # at a slow creep every dry friction is at its level, whatever the recording says of the sign
    creeping = replace(
        referred, v=np.tile(creep(model), (len(referred.v), 1)), velocity_std=None, rests=None, transition=None
    )
    now, level = np.zeros(referred.q.shape), np.zeros(referred.q.shape)
    for effect, theta in model.effect_parameters():
        if effect.dry:
            now += _torque(model, effect, theta, referred)
            level += _torque(model, effect, theta, creeping)
    return now, level


def _torque(model: Model, effect: Effect, theta: Array, signals: Signals) -> Array:
    parts = [effect.regressor(model.robot, signals.part(samples)) @ theta for samples in signals.segments]
    return np.concatenate(parts)
