"""Recordings in the order of what each adds to those before it, by their motion alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import Regressor
from physident.errors import InputError, did_you_mean

Array = NDArray[np.float64]
CRITERIA = ("prediction", "d_optimal")
PRIOR = 1e-6  # of the pool's information: what is known beforehand, so that one recording alone has a finite error
INSIDE = 1e-9  # of the largest eigenvalue: a smaller one is rounding of directions that no recording shows


def rank_recordings(regressors: Sequence[Regressor], weights: Array, criterion: str = "prediction") -> tuple[int, ...]:
    """Indices of recordings in the order to use them, each the best after those before it.

    ``regressors`` are those of a model along each recording, whose torque is not looked at; ``weights`` (n,) [1/(N m)] those of
    the joints. "prediction" minimises the mean variance of the predicted torque along all of them (I-optimal: the A-optimal
    design for what a model is used for), "d_optimal" the volume of the parameters' confidence ellipsoid. Raises InputError for fewer
    than two recordings and for another criterion.
    """
    if criterion not in CRITERIA:
        raise InputError(
            f"criterion is {criterion!r}, expected one of {', '.join(CRITERIA)}{did_you_mean(criterion, CRITERIA)}"
        )
    if len(regressors) < 2:
        raise InputError(f"{len(regressors)} recordings to rank, expected two or more")
    grams = np.array([gram_of(one, weights) for one in regressors])
    return _ordered(_of_equal_worth(grams), criterion)


def gram_of(regressor: Regressor, weights: Array) -> Array:
    """Y^T W Y (p, p) of a regressor."""
    p = len(regressor.columns)
    gram = np.zeros((p, p))
    for rows, weight in zip(regressor.joints, weights, strict=True):
        values = rows.values * weight
        gram[np.ix_(rows.columns, rows.columns)] += values.T @ values
    return gram


def _of_equal_worth(grams: Array) -> Array:
    """The grams (R, r, r) in coordinates in which all recordings together know each of r directions alike."""
    total = grams.sum(axis=0)
    size = np.sqrt(np.diag(total))
    shown = size > 0
    size = size[shown]
    scaled = grams[:, shown][:, :, shown] / np.outer(size, size)
    values, vectors = np.linalg.eigh(scaled.sum(axis=0))
    kept = values > INSIDE * values[-1]
    root = vectors[:, kept] / np.sqrt(values[kept])
    return root.T @ scaled @ root


def _ordered(grams: Array, criterion: str) -> tuple[int, ...]:
    """The greedy order. In these coordinates the trace of the inverse is the mean variance of prediction along all recordings."""
    known = PRIOR * np.eye(grams.shape[1])
    order: list[int] = []
    while len(order) < len(grams):
        left = [i for i in range(len(grams)) if i not in order]
        tried = [known + grams[[*order, i]].sum(axis=0) for i in left]
        if criterion == "prediction":
            values = [float(np.trace(np.linalg.inv(G))) for G in tried]
        else:
            values = [-float(np.linalg.slogdet(G)[1]) for G in tried]
        order.append(left[int(np.argmin(values))])
    return tuple(order)
