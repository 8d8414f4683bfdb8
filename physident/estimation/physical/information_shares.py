"""Which share of the information about the parameters came from the data, and which from the prior."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.estimation.physical.problem import Answer, PhysicalProblem
from physident.estimation.weighting import Compressed

Array = NDArray[np.float64]
BY_DATA = 0.9  # from this share on, the data determine a parameter
BY_PRIOR = 0.1  # up to this share, the prior determines it
MIN_MULTIPLIER = 1e-7  # of a constraint that is active
MAX_SLACK = 1e-6  # distance of an active constraint from its boundary, relative to its row


@dataclass(frozen=True, eq=False)
class InformationShares:
    """Shares of the information that came from the data, from 0 (all from the prior) to 1 (all from the data).

    ``directions`` (p,) in falling order, for independent directions of the parameters; ``base`` (r,) for each base
    parameter: the part of its variance that comes from the data's noise rather than from the uncertainty of the nominal
    values. ``information`` (r, r) of data and prior about the base parameters; ``response`` (r, r) of the base parameters
    to a gradient, along the active constraints.
    """

    directions: Array
    base: Array
    information: Array
    response: Array

    @property
    def base_by_data(self) -> int:
        """Number of base parameters that the data determine."""
        return int(np.count_nonzero(self.base >= BY_DATA))


def information_shares(problem: PhysicalProblem, data: Compressed, answer: Answer) -> InformationShares:
    """Compares the curvature of the data term and of the prior at the answer, along the active constraints."""
    A = data.R @ problem.KT / np.sqrt(data.rows)
    from_data, from_prior = A.T @ A, problem.prior_curvature(answer.u, answer.strength)
    free = _free_directions(problem, answer)
    L = np.linalg.cholesky(from_prior)
    whitened = np.linalg.solve(L, np.linalg.solve(L, from_data).T)
    ratio = np.maximum(np.linalg.eigvalsh((whitened + whitened.T) / 2)[::-1], 0.0)
    both = from_data + from_prior
    weights = np.linalg.solve(both, problem.KT.T)
    covariance, from_noise = problem.KT @ weights, weights.T @ from_data @ weights
    response = problem.KT @ free @ np.linalg.solve(free.T @ both @ free, free.T @ problem.KT.T)
    return InformationShares(
        directions=ratio / (1 + ratio),
        base=np.clip(np.diag(from_noise) / np.diag(covariance), 0.0, 1.0),
        information=np.linalg.inv(covariance) * data.rows,
        response=response / data.rows,
    )


def _free_directions(problem: PhysicalProblem, answer: Answer) -> Array:
    """Orthonormal directions (p, f) along every active constraint."""
    rows, offsets = problem.rows
    active = answer.multipliers.rows > MIN_MULTIPLIER if len(rows) else np.zeros(0, dtype=bool)
    active &= np.abs(rows @ answer.u + offsets) < MAX_SLACK
    fixed = np.concatenate([rows[active], problem.equalities[0]])
    if not len(fixed):
        return np.eye(len(answer.u))
    _, singular, Vt = np.linalg.svd(fixed)
    return Vt[np.count_nonzero(singular > 1e-10 * singular[0]) :].T
