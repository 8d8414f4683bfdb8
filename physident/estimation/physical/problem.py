"""The convex problem of a physical fit as data: objective, prior and constraints, and the proof of a solution.

    minimise |R K T u - z|^2 / (2 rows) + strength * divergence(u)   over the physical cones

No solver is needed here: ``semidefinite_program`` solves the problem, and ``PhysicalProblem.optimality`` checks the solver.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.estimation.physical.certificate import Multipliers, Optimality, check_optimality
from physident.estimation.physical.cones import Cones
from physident.estimation.physical.coordinates import SQUARES, TRACES, UNITS, Coordinates
from physident.estimation.physical.prior import TIE_BREAK_OTHERS, Entropic, Prior
from physident.estimation.weighting import Compressed

Array = NDArray[np.float64]
NOISE_OBJECTIVE = 0.5  # the data term where residuals are as large as their noise


@dataclass(frozen=True, eq=False)
class Answer:
    """Coordinates ``u`` (p,) of the optimum, its multipliers, its proof, and the strength of the prior it was solved with."""

    u: Array
    strength: float
    multipliers: Multipliers
    optimality: Optimality


@dataclass(frozen=True, eq=False)
class PhysicalProblem:
    """Grouping ``K`` (r, p) of parameters to base parameters, coordinates u of the parameters, constraints and prior."""

    K: Array
    coordinates: Coordinates
    cones: Cones
    prior: Prior

    @cached_property
    def KT(self) -> Array:
        """Base parameters (r, p) of coordinates u."""
        return self.K @ self.coordinates.T

    @cached_property
    def rows(self) -> tuple[Array, Array]:
        """A (m, p), b (m,) with A u + b >= 0."""
        return self.coordinates.rows(self.cones)

    @cached_property
    def equalities(self) -> tuple[Array, Array]:
        """E (k, p), t (k,) with E u = t."""
        return self.cones.equal @ self.coordinates.T, self.cones.targets

    @cached_property
    def matrices(self) -> list[tuple[Array, Array]]:
        """All M (d, d, p), B (d, d) with M u + B positive semidefinite."""
        return self.coordinates.matrices(self.cones)

    @property
    def entropic(self) -> bool:
        """Whether the prior is the entropic divergence of some link; otherwise it is a squared distance."""
        return isinstance(self.prior, Entropic) and len(self.coordinates.links) > 0

    @property
    def explicit_matrices(self) -> list[tuple[Array, Array]]:
        """The ``matrices`` that must be stated as constraints: an entropic prior already keeps its links positive definite."""
        return [pair for pair, implied in zip(self.matrices, self._implied, strict=True) if not implied]

    @property
    def _implied(self) -> list[bool]:
        return [m.link is not None and self.entropic for m in self.cones.matrices]

    @property
    def other_coordinates(self) -> NDArray[np.bool_]:
        """Which coordinates (p,) belong to no link."""
        others = np.ones(len(self.coordinates.nominal), dtype=bool)
        for _, link in self.coordinates.links:
            others[link] = False
        return others

    def optimality(self, u: Array, multipliers: Multipliers, data: Compressed, strength: float) -> Optimality:
        """Residuals of the optimality conditions at ``u`` (p,), computed from the data and the cones alone."""
        A = data.R @ self.KT / np.sqrt(data.rows)
        residual = A @ u - data.z / np.sqrt(data.rows)
        square = residual @ residual + data.rest / data.rows
        gradient = A.T @ residual
        # noise-free data: residuals count as at least as large as the noise they are given
        sizes = np.linalg.norm(A, axis=0) * np.sqrt(max(square, 2 * NOISE_OBJECTIVE))
        objective = 0.5 * square
        away = u - self.coordinates.nominal
        for _, link in self.coordinates.links:
            if self.entropic:
                X = self.coordinates.link(u, link)
                inverse = np.linalg.inv(X)
                largest = np.eye(4) + np.sqrt(np.outer(np.diag(inverse), np.diag(inverse)))
                gradient[link] += strength * np.einsum("ij,kij->k", np.eye(4) - inverse, UNITS)
                sizes[link] += strength * np.einsum("ij,kij->k", largest, UNITS)
                objective += strength * float(np.trace(X) - np.linalg.slogdet(X)[1] - 4)
            else:
                gradient[link] += strength * SQUARES * away[link]
                sizes[link] += strength * SQUARES * (np.abs(u[link]) + TRACES)
                objective += 0.5 * strength * float(SQUARES @ away[link] ** 2)
        others = self.other_coordinates
        gradient[others] += TIE_BREAK_OTHERS * away[others]
        sizes[others] += TIE_BREAK_OTHERS * (np.abs(u) + np.abs(self.coordinates.nominal))[others]
        implied = [
            (M, np.zeros_like(B)) for (M, B), is_implied in zip(self.matrices, self._implied, strict=True) if is_implied
        ]
        all_multipliers = replace(multipliers, matrices=(*multipliers.matrices, *(np.zeros((4, 4)) for _ in implied)))
        return check_optimality(
            u=u,
            multipliers=all_multipliers,
            gradient=gradient,
            gradient_sizes=sizes,
            objective=max(objective, strength, NOISE_OBJECTIVE),
            rows=self.rows,
            matrices=[*self.explicit_matrices, *implied],
            equalities=self.equalities,
        )

    def prior_curvature(self, u: Array, strength: float) -> Array:
        """Second derivative (p, p) of the prior and its tie-break at coordinates u."""
        H = np.eye(len(u)) * TIE_BREAK_OTHERS
        for _, link in self.coordinates.links:
            if self.entropic:
                scaled = np.linalg.inv(self.coordinates.link(u, link)) @ UNITS
                H[link, link] = strength * np.einsum("kij,lji->kl", scaled, scaled)
            else:
                H[link, link] = strength * np.diag(SQUARES)
        return H
