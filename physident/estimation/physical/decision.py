"""What the data decided and what the prior did: the two curvatures of a physical fit, compared direction by direction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from physident.estimation.physical.coordinates import SQUARES, UNITS
from physident.estimation.physical.prior import TIE_BREAK_OTHERS
from physident.estimation.weighting import Compressed

if TYPE_CHECKING:
    from physident.estimation.physical.program import Answer, Program

Array = NDArray[np.float64]
BY_DATA = 0.9  # share of the information from which on the data decided
BY_PRIOR = 0.1
ACTIVE = 1e-7  # multiplier above which a cone is pushed against
SLACK = 1e-6  # distance from a cone's boundary, relative to its row


@dataclass(frozen=True, eq=False)
class Decision:
    """Shares of the information that came from the data, 0 (the prior decided) to 1 (the data did).

    ``shares`` (p,) of independent directions, in falling order; ``base`` (r,) of each base parameter: the part of
    its variance that comes from the data's noise, the rest from not knowing how far nominal values are off.
    ``information`` (r, r) of data and prior about the base parameters; ``response`` (r, r) how far they follow a
    gradient, inside the cones the answer rests on.
    """

    shares: Array
    base: Array
    information: Array
    response: Array

    @property
    def base_by_data(self) -> int:
        """How many base parameters the data decided."""
        return int(np.count_nonzero(self.base >= BY_DATA))


def decide(program: Program, data: Compressed, answer: Answer) -> Decision:
    """Compares the curvature of data and prior at the answer, inside the cones it rests on."""
    A = data.R @ program.KT / np.sqrt(data.rows)
    by_data, by_prior = A.T @ A, _prior_curvature(program, answer.u, answer.strength)
    free = _free_directions(program, answer)
    L = np.linalg.cholesky(by_prior)
    whitened = np.linalg.solve(L, np.linalg.solve(L, by_data).T)
    ratio = np.maximum(np.linalg.eigvalsh((whitened + whitened.T) / 2)[::-1], 0.0)
    both = by_data + by_prior
    weights = np.linalg.solve(both, program.KT.T)
    covariance, by_noise = program.KT @ weights, weights.T @ by_data @ weights
    response = program.KT @ free @ np.linalg.solve(free.T @ both @ free, free.T @ program.KT.T)
    return Decision(
        ratio / (1 + ratio),
        np.clip(np.diag(by_noise) / np.diag(covariance), 0.0, 1.0),
        np.linalg.inv(covariance) * data.rows,
        response / data.rows,
    )


def _prior_curvature(program: Program, u: Array, strength: float) -> Array:
    """Second derivative (p, p) of prior and tie-break in coordinates u."""
    H = np.eye(len(u)) * TIE_BREAK_OTHERS
    for _, own in program.coordinates.links:
        if program.entropic:
            inverse = np.linalg.inv(program.coordinates.link(u, own))
            turned = inverse @ UNITS
            H[own, own] = strength * np.einsum("kij,lji->kl", turned, turned)
        else:
            H[own, own] = strength * np.diag(SQUARES)
    return H


def _free_directions(program: Program, answer: Answer) -> Array:
    """Orthonormal directions (p, f) that stay on every inequality the answer rests on."""
    rows, offsets = program.rows
    active = answer.multipliers.rows > ACTIVE if len(rows) else np.zeros(0, dtype=bool)
    active &= np.abs(rows @ answer.u + offsets) < SLACK
    fixed = np.concatenate([rows[active], program.equal[0]])
    if not len(fixed):
        return np.eye(len(answer.u))
    _, singular, Vt = np.linalg.svd(fixed)
    return Vt[np.count_nonzero(singular > 1e-10 * singular[0]) :].T
