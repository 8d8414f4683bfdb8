"""Constraints on the free numbers of a motion, with sparse Jacobians."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Constraints:
    """C constraints lower <= g(y) <= upper on free numbers y (m,), in units of the limit.

    ``value`` returns g (C,). ``jacobian`` returns the non-zeros (E,) of its Jacobian in the order of ``pattern`` (E, 2),
    which lists constraint and free number.
    """

    lower: Array
    upper: Array
    pattern: NDArray[np.intp]
    value: Callable[[Array], Array]
    jacobian: Callable[[Array], Array]

    def slack(self, y: Array) -> Array:
        """Distance (C,) of each constraint from its nearer bound, negative where it is violated."""
        value = self.value(y)
        return np.minimum(value - self.lower, self.upper - value)

    def violation(self, y: Array) -> float:
        """Largest violation in units of the limit; zero where all constraints hold."""
        return max(0.0, -float(self.slack(y).min()))

    def penalty(self, y: Array, reserve: float) -> tuple[float, Array]:
        """Sum of squared violations of limits tightened by ``reserve`` [units of the limit], and its gradient (m,)."""
        value = self.value(y)
        below, above = np.maximum(self.lower + reserve - value, 0.0), np.maximum(value - self.upper + reserve, 0.0)
        slope = 2 * (above - below)
        if not slope.any():
            return 0.0, np.zeros(y.size)
        weighted = self.jacobian(y) * slope[self.pattern[:, 0]]
        gradient = np.zeros(y.size)
        np.add.at(gradient, self.pattern[:, 1], weighted)
        return float(below @ below + above @ above), gradient

    def select(self, chosen: NDArray[np.bool_]) -> Constraints:
        """The constraints that a mask (C,) chooses."""
        kept = chosen[self.pattern[:, 0]]
        number = np.cumsum(chosen) - 1
        pattern = np.column_stack([number[self.pattern[kept, 0]], self.pattern[kept, 1]])
        return Constraints(
            self.lower[chosen], self.upper[chosen], pattern,
            lambda y: self.value(y)[chosen], lambda y: self.jacobian(y)[kept],
        )  # fmt: skip


def join(first: Constraints, second: Constraints) -> Constraints:
    """Two sets of constraints as one."""
    shifted = second.pattern + np.array([len(first.lower), 0])
    return Constraints(
        np.concatenate([first.lower, second.lower]),
        np.concatenate([first.upper, second.upper]),
        np.concatenate([first.pattern, shifted]),
        lambda y: np.concatenate([first.value(y), second.value(y)]),
        lambda y: np.concatenate([first.jacobian(y), second.jacobian(y)]),
    )
