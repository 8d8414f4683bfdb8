"""Weights that make rows of compared recordings and of others equally sure."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import Regressor
from physident.estimation.estimate import Estimate
from physident.estimation.uncertainty import correlation_rows

Array = NDArray[np.float64]


def evened(
    residual: Array, weights: Array, compared: NDArray[np.bool_], regressor: Regressor, given: Estimate | None
) -> Array:
    """What a regressor's rows (M, n) are multiplied by, so that those of ``compared`` recordings (M,) and the others are equally sure.

    A model errs along a new motion by more than the noise that a comparison leaves, and for longer at a time: without weights, what a
    comparison knows would be lost among what the others do not. The less sure rows count for less, and the surer ones as they are.
    ``residual`` (M, n) has the ``weights`` (M, n) given. Rows that are not compared err at least as the ``given`` model did on its own
    recordings, however much of it many candidates at once take up.
    """
    result = np.ones(residual.shape)
    if compared.all() or not compared.any():
        return result
    levels = []
    for rows in (compared, ~compared):
        own = residual * rows[:, None]
        size = np.sqrt((own**2).sum(axis=0) / np.maximum((weights[rows] ** 2).sum(axis=0), 1e-300))
        levels.append(size * np.sqrt(correlation_rows(regressor, own)))
    if given is not None:
        memory = regressor.kept_rate * sum(one.used for one in given.sources) / np.maximum(given.effective_samples, 1.0)
        levels[1] = np.maximum(levels[1], given.sigma * np.sqrt(np.maximum(memory, 1.0)))
    least = np.maximum(np.minimum(*levels), 1e-300)
    for rows, level in zip((compared, ~compared), levels, strict=True):
        result[rows] = least / np.maximum(level, least)
    return result
