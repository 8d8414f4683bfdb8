"""The fit of a baseline to all rows, and what it says about the size of the noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.search_data import Baseline, SearchData
from physident.diagnosis.statistics.normal_equations import pseudo_inverse

Array = NDArray[np.float64]
SETTLED = (
    0.95  # of a residual's size from one round of weights to the next: weights set the power of a test, not its level
)
SMALLEST = 1e-9  # of the largest torque: a smaller residual is rounding


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """A baseline fitted to all rows.

    ``x`` (R,) are its values, ``residual`` (M, n) [N m|N] what it leaves and ``sigma`` (n,) the residual's size;
    ``weights`` (n,) those of the joints' rows; ``memory`` (n,): how many correlated rows are worth one; ``decided``: how
    many of the R values the data decided; ``normal`` (R, R) the normal matrix, prior included.
    """

    x: Array
    residual: Array
    sigma: Array
    weights: Array
    memory: Array
    decided: float
    normal: Array

    @property
    def deflation(self) -> Array:
        """By how much (n,) the residual is smaller than the noise, because the baseline was fitted to it."""
        independent = len(self.residual) / self.memory
        return np.sqrt(np.maximum(1 - self.decided / len(independent) / independent, 0.5))


def fit_baseline(data: SearchData, baseline: Baseline) -> Fit:
    """Weighted least squares of a baseline over all rows, each weighted by its joint's residual and memory.

    The weights follow the residual until it settles; each round only sharpens joints that fit better than they were
    trusted to.
    """
    y, counted = data.response, data.regressor.counted.sum(axis=0)
    floor = SMALLEST * max(1.0, float(np.abs(data.regressor.torque).max()))
    sigma = np.maximum(np.sqrt((y**2).sum(axis=0) / counted), floor)
    squares = [B.T @ B for B in baseline.joints]
    slopes = [B.T @ torque for B, torque in zip(baseline.joints, y.T, strict=True)]
    while True:
        weights = 1 / (sigma * np.sqrt(data.memory))
        information = np.tensordot(weights**2, squares, 1)
        normal = information + np.diag(baseline.prior)
        inverse = pseudo_inverse(normal)
        x = inverse @ np.tensordot(weights**2, slopes, 1)
        residual = y - np.column_stack([B @ x for B in baseline.joints])
        decided = float(np.sum(inverse * information))
        left = np.maximum(counted - decided / y.shape[1], counted / 2)
        after = np.maximum(np.sqrt((residual**2).sum(axis=0) / left), floor)
        if (after >= SETTLED * sigma).all():
            return Fit(
                x=x,
                residual=residual,
                sigma=after,
                weights=weights,
                memory=data.memory,
                decided=decided,
                normal=normal,
            )
        sigma = np.minimum(after, sigma)


def fit_with_all_candidates(data: SearchData, baseline: Baseline) -> Fit:
    """The fit of all candidates at once beside a baseline, each at the middle of its grid: what is left is noise.

    A missing effect is part of the baseline's own residual, whose memory is then the motion's and not the noise's.
    """
    middle = [c.options[len(c.options) // 2].columns for c in data.candidates if not c.placebo]
    return fit_baseline(data, baseline.joined(data.columns([column for columns in middle for column in columns])))
