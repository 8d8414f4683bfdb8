"""How far chance moves a history: the limit that a history without any change exceeds at a stated rate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from physident.fleet.drift.conditions import REFERENCE, Explained

Array = NDArray[np.float64]
DRAWS, BATCH = 40_000, 2_000
FREEDOMS = (4.0, 5.0, 7.0, 10.0, 15.0, 30.0, 1e6)
MOST_MEMORY = 0.9
YEAR = 365.25  # days


@dataclass(frozen=True)
class Chance:
    """How the scatter of histories behaves: its ``memory``, the correlation from one recording to the next, and its ``freedom``,
    that of Student's t with tails as heavy."""

    memory: float
    freedom: float


def windows(count: int) -> list[int]:
    """Numbers of last recordings that a shift is looked for in: 1, 2, 3, 5, 8 ... up to ``count``."""
    found, after = [1], 2
    while after <= count:
        found, after = [*found, after], found[-1] + after
    return found


def shifts(z: Array, mean_error: Array) -> Array:
    """Shift (W, ..., N - R) of the last recordings of each window, in standard deviations, at each recording after the reference.

    ``z`` (..., N) is the rest over its standard deviation, ``mean_error`` (..., N) the error of the mean that was taken off, over
    the same. A window that reaches into the reference counts as no shift.
    """
    count = z.shape[-1] - REFERENCE
    sums = np.concatenate([np.zeros((*z.shape[:-1], 1)), np.cumsum(z, axis=-1)], axis=-1)
    errors = np.concatenate([np.zeros((*z.shape[:-1], 1)), np.cumsum(mean_error, axis=-1)], axis=-1)
    result = np.zeros((len(windows(count)), *z.shape[:-1], count))
    for k, m in enumerate(windows(count)):
        at = np.arange(REFERENCE + m, z.shape[-1] + 1)
        size = np.sqrt(1 + (errors[..., at] - errors[..., at - m]) ** 2 / m)
        result[k, ..., m - 1 :] = (sums[..., at] - sums[..., at - m]) / np.sqrt(m) / size
    return result


def chance_of(every: Sequence[Explained]) -> Chance:
    """The chance that the histories of a fleet have in common; medians and signs, which a few arms that change do not move.

    The tails are those of all arms and parameters together: arms and parameters that scatter more than others are part of them.
    """
    same = [np.sign(z[1:] * z[:-1]) for one in every if len(z := (one.rest - np.median(one.rest)) / one.size) > 1]
    memory = float(np.sin(np.pi / 2 * np.mean(np.concatenate(same))))
    z = np.abs(np.concatenate([one.rest / one.size for one in every]))
    tail = float(np.quantile(z, 0.95) / max(float(np.median(z)), 1e-12))
    return Chance(round(float(np.clip(memory, 0.0, MOST_MEMORY)), 2), min(FREEDOMS, key=lambda f: abs(_tail(f) - tail)))


def limit(count: int, chance: Chance, probability: float, seed: int = 0) -> float:
    """The largest shift, in standard deviations, that a history of ``count`` recordings exceeds with a ``probability`` by chance.

    Drawn: the histories have the scatter's memory and tails, and their mean is taken off as that of a real one.
    """
    largest = _largest(count, chance, seed)
    return float(np.quantile(largest, max(0.0, 1 - probability)))


@lru_cache(maxsize=64)
def _largest(count: int, chance: Chance, seed: int) -> Array:
    """The largest shift of each of many drawn histories, in order."""
    rng, found = np.random.default_rng(seed), []
    scale = np.sqrt((chance.freedom - 2) / chance.freedom)
    for _ in range(DRAWS // BATCH):
        steps = scale * rng.standard_t(chance.freedom, (BATCH, count))
        z = np.empty_like(steps)
        z[:, 0] = steps[:, 0]
        for i in range(1, count):
            z[:, i] = chance.memory * z[:, i - 1] + np.sqrt(1 - chance.memory**2) * steps[:, i]
        z = z - z[:, :REFERENCE].mean(axis=1, keepdims=True)
        error = np.full_like(z, REFERENCE**-0.5)
        found.append(np.abs(shifts(z, error)).max(axis=(0, 2)))
    return np.sort(np.concatenate(found))


def _tail(freedom: float) -> float:
    from scipy.stats import t

    return float(t.ppf(0.975, freedom) / t.ppf(0.75, freedom))
