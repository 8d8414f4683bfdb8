"""The fit of a baseline to all rows, and what it says about the size of the noise."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.search_data import Baseline, SearchData
from physident.diagnosis.statistics.normal_equations import pseudo_inverse
from physident.large_arrays import empty, magnitude, steps

Array = NDArray[np.float64]
SETTLED = (
    0.95  # of a residual's size from one round of weights to the next: weights set the power of a test, not its level
)
ROUNDING = 1e-8  # of a squared response: a smaller squared residual is not known from products
SMALLEST = 1e-9  # of the largest torque: a smaller residual is rounding


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """Over all rows of each joint: the products of a baseline's columns ``squares`` (n, R, R), those with the response ``slopes``
    (n, R), and the squared response ``sizes`` (n,)."""

    squares: Array
    slopes: Array
    sizes: Array

    def left(self, x: Array) -> Array:
        """The squared residual (n,) of values x (R,), which holds where it is no rounding of the squared response."""
        return self.sizes - 2 * self.slopes @ x + np.einsum("r,jrs,s->j", x, self.squares, x, optimize=True)


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """A baseline fitted to all rows.

    ``x`` (R,) are its values and ``sigma`` (n,) the residual's size; ``weights`` (n,) those of the joints' ``rows``; ``memory`` (n,): how
    many correlated rows are worth one; ``decided``: how many of the R values the data decided; ``normal`` (R, R) the normal
    matrix, prior included. ``of`` are the data and the baseline, None for a fit of products alone.
    """

    x: Array
    sigma: Array
    weights: Array
    memory: Array
    decided: float
    normal: Array
    rows: int
    of: tuple[SearchData, Baseline] | None = None

    @cached_property
    def residual(self) -> Array:
        """What the fit leaves of the response (M, n) [N m|N]."""
        assert self.of is not None
        return residual_of(*self.of, self.x)

    @property
    def deflation(self) -> Array:
        """By how much (n,) the residual is smaller than the noise, because the baseline was fitted to it."""
        independent = self.rows / self.memory
        return np.sqrt(np.maximum(1 - self.decided / len(independent) / independent, 0.5))


def residual_of(data: SearchData, baseline: Baseline, x: Array) -> Array:
    """What values x (R,) of a baseline leave of the response (M, n) [N m|N]."""
    result = empty(data.response.shape)
    for some in steps(len(result)):
        result[some] = data.response[some] - baseline.some_torque(some, x)
    return result


def normal_equations(data: SearchData, baseline: Baseline) -> NormalEquations:
    """The normal equations of a baseline, gathered in blocks of rows."""
    n, R = len(baseline.joints), len(baseline.prior)
    squares, slopes = np.zeros((n, R, R)), np.zeros((n, R))
    for j in range(n):
        used, kept = _used(baseline, j)
        for some in steps(len(data.response)):
            B = np.column_stack([values[some][:, columns] for values, columns in kept])
            squares[j][np.ix_(used, used)] += B.T @ B
            slopes[j, used] += B.T @ data.response[some, j]
    return NormalEquations(squares, slopes, (data.response**2).sum(axis=0))


def _used(baseline: Baseline, j: int) -> tuple[NDArray[np.intp], list[tuple[Array, NDArray[np.intp]]]]:
    """Which of a baseline's R columns a joint has, and these in order: arrays and the columns that are taken of each."""
    own = baseline.joints[j]
    parts = [(own, np.arange(own.shape[1]))]
    places = [np.arange(own.shape[1])]
    for first, one in zip(baseline.starts, baseline.extra, strict=True):
        at, values = one.joints[j]
        places.append(first + at)
        parts.append((values, np.arange(len(at))))
    return np.concatenate(places).astype(np.intp), parts


def fit_baseline(data: SearchData, baseline: Baseline, equations: NormalEquations | None = None) -> Fit:
    """Weighted least squares of a baseline over all rows, each weighted by its joint's residual and memory.

    The weights follow the residual until it settles; each round only sharpens joints that fit better than they were
    trusted to. The normal ``equations`` are gathered from the rows where they are not known.
    """
    counted = data.regressor.counted.sum(axis=0)
    floor = SMALLEST * max(1.0, float(magnitude(data.regressor.torque).max()))
    equations = normal_equations(data, baseline) if equations is None else equations
    sigma = np.maximum(np.sqrt(equations.sizes / counted), floor)
    while True:
        weights = 1 / (sigma * np.sqrt(data.memory))
        information = np.tensordot(weights**2, equations.squares, 1)
        normal = information + np.diag(baseline.prior)
        inverse = pseudo_inverse(normal)
        x = inverse @ np.tensordot(weights**2, equations.slopes, 1)
        decided = float(np.sum(inverse * information))
        free = np.maximum(counted - decided / len(counted), counted / 2)
        left = equations.left(x)
        if (left < ROUNDING * equations.sizes).any():
            left = (residual_of(data, baseline, x) ** 2).sum(axis=0)
        after = np.maximum(np.sqrt(left / free), floor)
        if (after >= SETTLED * sigma).all():
            return Fit(
                x=x,
                sigma=after,
                weights=weights,
                memory=data.memory,
                decided=decided,
                normal=normal,
                rows=len(data.response),
                of=(data, baseline),
            )
        sigma = np.minimum(after, sigma)


def fit_with_all_candidates(data: SearchData, baseline: Baseline) -> Fit:
    """The fit of all candidates at once beside a baseline, each at the middle of its grid: what is left is noise.

    A missing effect is part of the baseline's own residual, whose memory is then the motion's and not the noise's.
    """
    middle = [c.options[len(c.options) // 2].columns for c in data.candidates if not c.placebo]
    return fit_baseline(data, baseline.joined(data.columns([column for columns in middle for column in columns])))
