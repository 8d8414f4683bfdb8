"""What candidate columns add to a baseline that is refitted with them: their part outside the baseline, and their gain."""

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
    """A fitted baseline onto which candidates are projected.

    ``R`` (r, r) is the QR factor of its ``independent`` (r,) columns after the joints' ``weights`` (n,) [1/(N m)],
    ``residual`` (M, n) the weighted residual after the fit.
    """

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
        shown = bool(R.any())  # beside a fixed model the only columns are a rival's, which no motion may show
        independent = select_base(R, regressor.columns).independent if shown else np.zeros(0, dtype=np.intp)
        factor = np.asarray(np.linalg.qr(np.column_stack([R[:, independent], z]), mode="r"))
        r = len(independent)
        theta = np.zeros(R.shape[1])
        theta[independent] = solve_triangular(factor[:r, :r], factor[:r, r])
        residual = regressor.residual(theta) * weights
        return Baseline(regressor, independent, weights, factor[:r, :r], residual)

    def project(self, candidate: Regressor) -> Projection:
        """The projection of a candidate's columns (k), all of them together, on the same rows."""
        k = len(candidate.columns)
        gram, cross = np.zeros((k, k)), np.zeros((len(self.independent), k))
        slope = np.zeros(k)
        place = np.full(len(self.regressor.columns), -1)
        place[self.independent] = np.arange(len(self.independent))
        for j, (rows, baseline_rows) in enumerate(zip(candidate.joints, self.regressor.joints, strict=True)):
            if not len(rows.columns):
                continue
            C = rows.values * self.weights[j]
            gram[np.ix_(rows.columns, rows.columns)] += C.T @ C
            slope[rows.columns] += C.T @ self.residual[:, j]
            used = np.flatnonzero(place[baseline_rows.columns] >= 0)
            products = (baseline_rows.values[:, used] * self.weights[j]).T @ C
            cross[np.ix_(place[baseline_rows.columns[used]], rows.columns)] += products
        inside = solve_triangular(self.R, cross, trans=1) if len(self.R) else cross
        return Projection(gram, gram - inside.T @ inside, slope)


@dataclass(frozen=True, eq=False)
class Projection:
    """A candidate's columns relative to a baseline.

    ``gram`` (k, k) their inner products, ``outside_gram`` (k, k) those of their parts outside the baseline, ``slope`` (k,)
    their inner products with the residual.
    """

    gram: Array
    outside_gram: Array
    slope: Array

    @property
    def share(self) -> float:
        """Share of the columns' energy that the baseline cannot reproduce, 0 where they are zero."""
        energy = float(np.trace(self.gram))
        return max(0.0, float(np.trace(self.outside_gram)) / energy) if energy > 0 else 0.0

    @property
    def gain(self) -> float:
        """Decrease of the squared weighted residual when the columns join the baseline."""
        return float(self.slope @ self.values)

    @property
    def values(self) -> Array:
        """The columns' parameters (k,) when they join the baseline; zero along directions inside it."""
        scale = np.sqrt(np.maximum(np.diag(self.gram), 1e-300))
        energy, vectors = np.linalg.eigh(self.outside_gram / np.outer(scale, scale))
        kept = energy > INSIDE
        directions = vectors[:, kept] / scale[:, None]
        return directions @ ((directions.T @ self.slope) / energy[kept])
