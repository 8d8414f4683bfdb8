"""Priors of effects that have one, such as learned curves: how many rows they count for, and how large they let a curve be.

The amplitude of a curve is the one with which rows that were left out are predicted best: too small, and the curve cannot follow what
is there; too large, and it follows the noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor
from physident.effects.effect import Effect
from physident.effects.learned.curve import LearnedCurve
from physident.estimation.quick_fit import quick_fit
from physident.estimation.uncertainty import block_labels, correlation_rows
from physident.identifiability.base_parameters import BaseParameters, find_base_parameters
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
# times what is left without curves: finer steps change no prediction
AMPLITUDES = (0.03, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
FOLDS = 8  # parts that are left out in turn
MEMORIES = 10  # correlation lengths in a block: what leaks over its edge is then a tenth of it
SWEEPS = 2
SAME_RANGE = 0.01  # of a range: an end that moves by less moves no spline
ROUNDS = 3  # of noise and prior, each given the other


def placed(
    robot: Robot, effects: Sequence[Effect], signals: Sequence[Signals], model: Model | None = None
) -> tuple[Effect, ...]:
    """The effects with what they take from the motion of recordings, and the range of curves over a torque that a ``model`` predicts, by
    default the nominal one."""
    if any(is_placed_by_model(effect) for effect in effects):
        model = model or Model.nominal(robot)
        signals = [model.refer(one) for one in signals]
    return tuple(effect.placed(robot, signals) for effect in effects)


def is_placed_by_model(effect: Effect) -> bool:
    """Whether an effect is a curve over a torque that a model predicts, whose range nobody has given."""
    return isinstance(effect, LearnedCurve) and effect.needs_model and None in (effect.low, effect.high)


def are_near(one: Sequence[Effect], other: Sequence[Effect]) -> bool:
    """Whether the ranges of the same curves are nearly alike."""
    pairs = [
        (a, b) for a, b in zip(one, other, strict=True) if isinstance(a, LearnedCurve) and isinstance(b, LearnedCurve)
    ]
    ends = [np.array([[curve.low, curve.high] for curve in pair]) for pair in pairs]
    return all(bool((np.abs(a - b) <= SAME_RANGE * (b[1] - b[0])).all()) for a, b in ends)


def with_prior(robot: Robot, effects: Sequence[Effect], regressor: Regressor) -> Regressor:
    """The regressor with the rows that the effects' priors count for, given the size and the memory of the noise."""
    sizes = prior_sizes(robot, effects)
    if not np.isfinite(sizes).any():
        return regressor
    joints = np.array([column.joint - 1 for column in regressor.columns])
    sigma = np.sqrt((regressor.torque**2).mean(axis=0)) / 10  # at first: a fit leaves a tenth or less
    memory = np.ones(robot.n)
    for _ in range(ROUNDS):
        rows = (memory * sigma**2)[joints] / sizes**2
        held = replace(regressor, prior=rows)
        residual = regressor.residual(quick_fit(robot, tuple(effects), held))
        sigma, memory = np.sqrt((residual**2).mean(axis=0)), correlation_rows(regressor, residual)
    return replace(regressor, prior=(memory * sigma**2)[joints] / sizes**2)


def with_first_prior(robot: Robot, effects: Sequence[Effect], regressor: Regressor) -> Regressor:
    """The regressor as ``with_prior``, where a curve that has no amplitude yet may be as large as the torque of its joint: without any
    prior it would grow against gravity and the offset, beyond all measure where no row counts."""
    size = np.sqrt((regressor.torque**2).mean(axis=0))
    held = [
        replace(one, amplitude=tuple(float(size[j]) for j in one.active(robot)))
        if isinstance(one, LearnedCurve) and one.amplitude is None
        else one
        for one in effects
    ]
    return with_prior(robot, held, regressor)


def with_amplitudes(robot: Robot, effects: Sequence[Effect], regressor: Regressor) -> tuple[Effect, ...]:
    """The effects with the amplitude of each curve that has none, joint by joint, by left-out blocks."""
    curves = {i: one for i, one in enumerate(effects) if isinstance(one, LearnedCurve) and one.amplitude is None}
    if not curves:
        return tuple(effects)
    owner = np.array([i for i, effect in enumerate(effects) for _ in effect.columns(robot)])
    plain = [k for k, i in enumerate(owner) if i not in curves]
    rest = _Folds.of(robot, effects, regressor, plain)
    folds = _Folds.of(robot, effects, regressor, list(range(len(owner))), rest)
    joints = np.array([column.joint for column in regressor.columns])
    places = {
        (i, int(j)): np.flatnonzero((owner == i) & (joints == j)) for i in curves for j in np.unique(joints[owner == i])
    }
    given = np.where(np.isfinite(sizes := prior_sizes(robot, effects, missing=np.inf)), sizes, np.inf)
    curves = {i: one.beside([float(rest.sigma[j]) for j in one.active(robot)]) for i, one in curves.items()}
    parts = {(i, j): curves[i].of_joint(robot, curves[i].active(robot).index(j - 1)) for i, j in places}
    chosen = {place: float(rest.sigma[place[1] - 1]) for place in places}
    for _ in range(SWEEPS):
        before = dict(chosen)
        for place in places:
            tried = [factor * float(rest.sigma[place[1] - 1]) for factor in AMPLITUDES]
            errors = [folds.error(_filled(given, places, parts, {**chosen, place: s}), joints) for s in tried]
            chosen[place] = tried[int(np.argmin(errors))]
        if chosen == before or len(places) == 1:
            break
    result = list(effects)
    for i, curve in curves.items():
        result[i] = replace(curve, amplitude=tuple(chosen[i, j + 1] for j in curve.active(robot)))
    return tuple(result)


def _filled(
    given: Array,
    places: dict[tuple[int, int], NDArray[np.intp]],
    parts: dict[tuple[int, int], LearnedCurve],
    chosen: dict[tuple[int, int], float],
) -> Array:
    sizes = given.copy()
    for place, at in places.items():
        sizes[at] = replace(parts[place], amplitude=(chosen[place],)).prior_sizes_of_one()
    return sizes


def prior_sizes(robot: Robot, effects: Sequence[Effect], missing: float | None = None) -> Array:
    """Standard deviations (p,) of the priors, infinite where there is none."""
    parts = []
    for effect in effects:
        open_curve = missing is not None and getattr(effect, "amplitude", 0) is None
        sizes = None if open_curve else effect.prior_sizes(robot)
        parts.append(np.full(len(effect.columns(robot)), np.inf) if sizes is None else sizes)
    return np.concatenate(parts)


@dataclass(frozen=True, eq=False)
class _Folds:
    """Normal equations of each fold in units of the noise: ``H`` (F, r, r), ``g`` (F, r) of the ``columns`` (r,) that are
    independent, ``size`` (F,) of the torque; ``sigma``, ``memory`` (n,) of what the fit of some columns leaves."""

    H: Array
    g: Array
    size: Array
    columns: NDArray[np.intp]
    sigma: Array
    memory: Array

    @staticmethod
    def of(
        robot: Robot, effects: Sequence[Effect], regressor: Regressor, wanted: list[int], noise: _Folds | None = None
    ) -> _Folds:
        base: BaseParameters = find_base_parameters(robot, effects)
        columns = np.array([c for c in base.independent if c in set(wanted)], dtype=np.intp)
        Y = regressor.Y[:, :, columns]
        if noise is None:
            residual = regressor.torque
            sigma = np.sqrt((residual**2).mean(axis=0))
            for _ in range(ROUNDS):
                A = (Y / sigma[:, None]).reshape(regressor.torque.size, len(columns))
                x = np.linalg.lstsq(A, (regressor.torque / sigma).ravel(), rcond=1e-9)[0]
                residual = regressor.torque - Y @ x
                sigma = np.maximum(np.sqrt((residual**2).mean(axis=0)), 1e-12)
            memory = correlation_rows(regressor, residual)
        else:
            sigma, memory = noise.sigma, noise.memory
        weights = 1 / (sigma * np.sqrt(memory))
        A, y = Y * weights[:, None], regressor.torque * weights
        labels = _labels(regressor, float(memory.max()))
        parts = [labels == label for label in np.unique(labels)]
        return _Folds(
            np.array([np.einsum("mjr,mjs->rs", A[rows], A[rows], optimize=True) for rows in parts]),
            np.array([np.einsum("mjr,mj->r", A[rows], y[rows]) for rows in parts]),
            np.array([float(np.sum(y[rows] ** 2)) for rows in parts]),
            columns,
            sigma,
            memory,
        )

    def error(self, sizes: Array, joints: NDArray[np.intp]) -> float:
        """Squared error on left-out folds with prior ``sizes`` (p,)."""
        prior = np.diag(1 / sizes[self.columns] ** 2)
        H, g = self.H.sum(axis=0), self.g.sum(axis=0)
        scale = np.sqrt(np.maximum(np.diag(H), 1e-300))
        total = 0.0
        for H_out, g_out, size in zip(self.H, self.g, self.size, strict=True):
            A = (H - H_out + prior) / np.outer(scale, scale)
            x = np.linalg.solve(A + 1e-12 * np.eye(len(A)), (g - g_out) / scale) / scale
            total += float(x @ H_out @ x - 2 * g_out @ x + size)
        return total


def _labels(regressor: Regressor, memory: float) -> NDArray[np.intp]:
    """Which rows are left out together: blocks dealt in turn. A whole recording may show what no other does, and no curve could
    predict it."""
    length = min(int(np.ceil(MEMORIES * memory)), max(1, len(regressor.segment) // FOLDS))
    return block_labels(regressor.segment, length) % FOLDS
