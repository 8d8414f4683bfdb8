"""What a candidate column adds to a baseline that is refitted with it: its part outside the baseline, and its gain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from physident.dynamics.regressor import Regressor
from physident.identifiability.base_parameters import select_base

Array = NDArray[np.float64]
INSIDE = 1e-8  # share of a candidate's energy outside the baseline below which rounding decides


@dataclass(frozen=True, eq=False)
class Baseline:
    """A fitted baseline, ready to judge candidates: its independent columns' factor R (r, r) after the joints'
    ``weights`` (n,) [1/(N m)], and the weighted residual (M, n) that no refit of it can lower."""

    regressor: Regressor
    independent: NDArray[np.intp]
    weights: Array
    R: Array
    residual: Array

    @property
    def cost(self) -> float:
        """Squared weighted residual."""
        return float(np.sum(self.residual**2))

    @staticmethod
    def of(regressor: Regressor, weights: Array) -> Baseline:
        """The baseline of a regressor's columns, least squares with the given weights."""
        R, z, _ = regressor.compressed(weights)
        independent = select_base(R, regressor.columns).independent
        factor = np.asarray(np.linalg.qr(np.column_stack([R[:, independent], z]), mode="r"))
        r = len(independent)
        theta = np.zeros(R.shape[1])
        theta[independent] = solve_triangular(factor[:r, :r], factor[:r, r])
        residual = (regressor.torque - regressor.predict(theta)) * weights
        return Baseline(regressor, independent, weights, factor[:r, :r], residual)

    def judge(self, candidate: Regressor) -> Judged:
        """What a candidate's columns (k) on the same rows would add, all of them together."""
        k = len(candidate.columns)
        inner, outer = np.zeros((k, k)), np.zeros((len(self.independent), k))
        slope = np.zeros(k)
        place = np.full(len(self.regressor.columns), -1)
        place[self.independent] = np.arange(len(self.independent))
        for j, (rows, own) in enumerate(zip(candidate.joints, self.regressor.joints, strict=True)):
            if not len(rows.columns):
                continue
            C = rows.values * self.weights[j]
            inner[np.ix_(rows.columns, rows.columns)] += C.T @ C
            slope[rows.columns] += C.T @ self.residual[:, j]
            mine = np.flatnonzero(place[own.columns] >= 0)
            cross = (own.values[:, mine] * self.weights[j]).T @ C
            outer[np.ix_(place[own.columns[mine]], rows.columns)] += cross
        inside = solve_triangular(self.R, outer, trans=1) if len(self.R) else outer
        return Judged(inner, inner - inside.T @ inside, slope)


@dataclass(frozen=True, eq=False)
class Judged:
    """A candidate's columns against a baseline: ``inner`` (k, k) their products, ``outside`` (k, k) those of their parts
    outside the baseline, ``slope`` (k,) their product with the residual."""

    inner: Array
    outside: Array
    slope: Array

    @property
    def share(self) -> float:
        """Share of the columns' energy that the baseline cannot imitate, 0 where they are zero."""
        size = float(np.trace(self.inner))
        return max(0.0, float(np.trace(self.outside)) / size) if size > 0 else 0.0

    @property
    def gain(self) -> float:
        """By how much the squared weighted residual falls when the columns join the baseline."""
        return float(self.slope @ self.values)

    @property
    def values(self) -> Array:
        """The columns' parameters (k,) when they join; zero along directions inside the baseline."""
        scale = np.sqrt(np.maximum(np.diag(self.inner), 1e-300))
        size, vectors = np.linalg.eigh(self.outside / np.outer(scale, scale))
        kept = size > INSIDE
        directions = vectors[:, kept] / scale[:, None]
        return directions @ ((directions.T @ self.slope) / size[kept])
