"""What temperature and load explain of a parameter, and how much the rest scatters from day to day.

Where no temperature was measured, the time that an arm had been at work on the day stands for it.
Arms of one kind depend on temperature alike: the slopes are those of all arms together, without the arms' means, by Huber's loss,
so that the few arms that change do not decide them. Fewer than ``ENOUGH`` arms show no common slope: each then has its own, from the
recordings of its reference period.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.fleet.drift.history import History
from physident.fleet.drift.warm_up import TIME_CONSTANTS

Array = NDArray[np.float64]
REFERENCE = 8  # recordings at the beginning of a history that say what is usual: a mean of them errs by a third of one's scatter
ENOUGH = 5  # arms: of fewer, a single one that changes could decide a common slope
ROUNDS = 30
BEND = 1.345  # standard deviations at which Huber's loss turns linear
MIDDLE = 0.4549  # median of the square of a normal number
LEAST = 0.1  # share of the standard errors: of fewer recordings than parameters, nothing would be left
SPREAD = 0.5  # degC: a temperature that varies less explains nothing
WARMER = 0.05  # of the way from cold to warm: as much


@dataclass(frozen=True, eq=False)
class Explained:
    """A history without what conditions explain: ``rest`` (N,) of the change, ``size`` (N,) the standard deviation that it has
    by chance, ``mean_error`` the standard error of the mean that was taken off, and ``slopes`` (k,) of the ``conditions``."""

    history: History
    rest: Array
    size: Array
    mean_error: float
    slopes: Array
    conditions: tuple[str, ...]
    noise: float


def explain(group: Sequence[History]) -> list[Explained]:
    """The histories of one parameter on all arms, without temperature and load; each needs more than ``REFERENCE`` recordings."""
    group = [one for one in group if len(one.day) > REFERENCE]
    if not group:
        return []
    names, designs = _conditions(group)
    # the jackknife's standard errors vary by a quarter; the information does not
    noise = float(np.median(np.concatenate([one.std * np.sqrt(one.information) for one in group])))
    errors = [noise / np.sqrt(one.information) for one in group]
    share, extra, found = 1.0, 0.0, list[Explained]()
    for _ in range(3):  # the scatter and the slopes, each from the other
        sizes = [np.hypot(share * error, extra) for error in errors]
        slopes, covariance = _slopes(group, designs, sizes)
        found = [
            _one(one, D, size, b, C, names, noise)
            for one, D, size, b, C in zip(group, designs, sizes, slopes, covariance, strict=True)
        ]
        share, extra = _scatter(np.concatenate([one.rest for one in found]), np.concatenate(errors))
    return found


def _conditions(group: Sequence[History]) -> tuple[tuple[str, ...], list[Array]]:
    """Names and columns (N, k) of what the changes may depend on, around the fleet's mean."""
    columns: dict[str, list[Array]] = {}
    temperature = np.concatenate([one.temperature for one in group])
    if np.isfinite(temperature).all() and temperature.std() > SPREAD:
        middle = temperature.mean()
        columns["temperature"] = [one.temperature - middle for one in group]
        if len(group) >= ENOUGH:
            columns["temperature squared"] = [(one.temperature - middle) ** 2 for one in group]
    if not np.isfinite(temperature).all():
        columns |= _warm_up(group)
    load = np.concatenate([one.load for one in group])
    if len(group) >= ENOUGH and np.isfinite(load).all() and load.std() > 0.02 * load.mean():
        columns["load"] = [(one.load - load.mean()) / load.mean() for one in group]
    designs = [
        np.column_stack([values[k] for values in columns.values()]) if columns else np.zeros((len(one.day), 0))
        for k, one in enumerate(group)
    ]
    return tuple(columns), designs


def _warm_up(group: Sequence[History]) -> dict[str, list[Array]]:
    """The columns (N,) of the warmth by each time constant, or by the longest alone where each arm has its own slopes."""
    kept = range(len(TIME_CONSTANTS)) if len(group) >= ENOUGH else [len(TIME_CONSTANTS) - 1]
    every = np.concatenate([one.warmth for one in group])
    return {
        f"warm-up in {TIME_CONSTANTS[k] / 60:.0f} min": [one.warmth[:, k] - every[:, k].mean() for one in group]
        for k in kept
        if every[:, k].std() > WARMER
    }


def _slopes(group: Sequence[History], designs: list[Array], sizes: list[Array]) -> tuple[list[Array], list[Array]]:
    """Slopes (k,) and their covariance (k, k) for each arm."""
    if len(group) >= ENOUGH:
        slope, covariance = _common(designs, [one.change for one in group], sizes)
        return [slope] * len(group), [covariance] * len(group)
    found = [
        _common([D[:REFERENCE]], [one.change[:REFERENCE]], [size[:REFERENCE]])
        for one, D, size in zip(group, designs, sizes, strict=True)
    ]
    return [slope for slope, _ in found], [covariance for _, covariance in found]


def _common(designs: list[Array], changes: list[Array], sizes: list[Array]) -> tuple[Array, Array]:
    """Slopes (k,) that histories have in common beside a mean of each, and their covariance (k, k)."""
    k = designs[0].shape[1]
    trust = [np.ones(len(x)) for x in changes]
    slope, covariance = np.zeros(k), np.zeros((k, k))
    for _ in range(ROUNDS if k else 0):
        H, g = np.zeros((k, k)), np.zeros(k)
        for D, x, size, w in zip(designs, changes, sizes, trust, strict=True):
            weight = w / size**2
            D, x = D - np.average(D, axis=0, weights=weight), x - np.average(x, weights=weight)
            H, g = H + (D.T * weight) @ D, g + (D.T * weight) @ x
        covariance = np.asarray(np.linalg.pinv(H), dtype=float)
        slope = np.asarray(covariance @ g)
        for i, (D, x, size) in enumerate(zip(designs, changes, sizes, strict=True)):
            rest = x - D @ slope
            z = np.abs(rest - np.median(rest)) / size
            trust[i] = np.minimum(1.0, BEND / np.maximum(z, 1e-12))
    return slope, covariance


def _one(
    history: History, D: Array, size: Array, slopes: Array, covariance: Array, names: tuple[str, ...], noise: float
) -> Explained:
    usual = slice(0, REFERENCE)
    weight = 1 / size[usual] ** 2
    rest = history.change - D @ slopes
    rest = rest - np.average(rest[usual], weights=weight)
    away = D - np.average(D[usual], axis=0, weights=weight) if D.shape[1] else D
    unsure = np.einsum("nk,kl,nl->n", away, covariance, away)
    return Explained(history, rest, np.sqrt(size**2 + unsure), float(weight.sum() ** -0.5), slopes, names, noise)


def _scatter(rest: Array, errors: Array) -> tuple[float, float]:
    """The share of the standard ``errors`` that scatters, and the scatter from day to day beside them: with both, half of the
    squares are as small as by chance.

    A share below one is that of a model whose errors return with every recording: they widen each interval and change nothing.
    """
    low, high = 0.0, 10 * float(np.abs(rest).max(initial=0.0))
    if (middle := float(np.median(rest**2 / errors**2))) <= MIDDLE:
        return max(LEAST, float(np.sqrt(middle / MIDDLE))), 0.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if np.median(rest**2 / (errors**2 + middle**2)) > MIDDLE else (low, middle)
    return 1.0, high
