"""The rows that a search works on: the columns of all candidates, the torque to explain, and the baseline beside them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidate_groups import OptionGroup
from physident.diagnosis.problem.candidates import Candidate
from physident.dynamics.regressor import Regressor

Array = NDArray[np.float64]
OUTSIDE = -1  # fold of a row in a gap between blocks


@dataclass(frozen=True, eq=False)
class Baseline:
    """Columns that are refitted with every candidate, (M, R) in each joint's rows, in units of the noise.

    ``prior`` (R,) is the prior precision of their values, zero where only the data decide.
    """

    joints: tuple[Array, ...]
    prior: Array

    def joined(self, columns: Sequence[Array], precision: float = 0.0) -> Baseline:
        """The baseline with more columns, (M, k) in each joint's rows, whose values have a prior ``precision``."""
        joints = tuple(np.column_stack([before, more]) for before, more in zip(self.joints, columns, strict=True))
        return Baseline(joints, np.concatenate([self.prior, np.full(columns[0].shape[1], precision)]))


@dataclass(frozen=True, kw_only=True, eq=False)
class SearchData:
    """Candidates' columns and the torque to explain on common rows.

    ``response`` (M, n) [N m|N]: what the model as given leaves of the torque; ``fold`` (M,) of each row, OUTSIDE in gaps;
    ``memory`` (n,): how many correlated rows are worth one independent row.
    """

    regressor: Regressor
    candidates: tuple[Candidate, ...]
    response: Array
    fold: NDArray[np.intp]
    memory: Array

    @cached_property
    def groups(self) -> list[OptionGroup]:
        """The candidates' options gathered by their number of columns."""
        sizes = sorted({len(option.columns) for c in self.candidates for option in c.options})
        return [OptionGroup.of(self.regressor, self.candidates, k) for k in sizes]

    def joint_columns(self, joint: int, wanted: Sequence[int]) -> Array:
        """Values (M, k) of some columns in a joint's rows (index from 0), zero where they have none."""
        rows = self.regressor.joints[joint]
        place = {int(column): k for k, column in enumerate(rows.columns)}
        values = np.zeros((len(rows.values), len(wanted)))
        for k, column in enumerate(wanted):
            if column in place:
                values[:, k] = rows.values[:, place[column]]
        return values

    def columns(self, wanted: Sequence[int]) -> list[Array]:
        """Values (M, k) of some columns in each joint's rows."""
        return [self.joint_columns(j, wanted) for j in range(len(self.regressor.joints))]
