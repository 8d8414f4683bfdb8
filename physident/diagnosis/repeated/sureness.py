"""Weights that make rows of other recordings as sure as those of compared ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import Regressor
from physident.estimation.uncertainty import correlation_rows

Array = NDArray[np.float64]


def as_sure_as(level: Array, residual: Array, weights: Array, regressor: Regressor) -> Array:
    """What the rows of each joint (n,) of some recordings are multiplied by, at most one, so that a row of them is as sure as one of
    ``level`` (n,) [N m|N]: the size of its noise times the root of how many correlated rows are worth one.

    ``residual`` (M, n) [N m|N] is what the model leaves of their rows, with the ``weights`` (M, n) given, and zero in all other rows of the
    ``regressor``. A model errs along a new motion by more than the noise of a comparison, and for longer at a time: without this, what a
    comparison knows would be lost among what the others do not.
    """
    own = (residual != 0).any(axis=1)
    size = np.sqrt((residual**2).sum(axis=0) / np.maximum((weights[own] ** 2).sum(axis=0), 1e-300))
    return np.minimum(1.0, level / np.maximum(size * np.sqrt(correlation_rows(regressor, residual)), 1e-300))
