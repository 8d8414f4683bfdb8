"""The rows that a search works on: the columns of all candidates, the torque to explain, and the baseline beside them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidate_groups import OptionGroup
from physident.diagnosis.problem.candidates import Candidate
from physident.diagnosis.problem.columns import Baseline, Columns
from physident.dynamics.regressor import Regressor
from physident.effects.contact import tool_jacobian
from physident.large_arrays import empty, row_slices, steps
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
OUTSIDE = -1  # fold of a row in a gap between blocks

__all__ = ["OUTSIDE", "Baseline", "SearchData"]


def rows_of(recording: NDArray[np.intp], index: int) -> slice:
    """The rows of a recording: they follow each other."""
    return slice(int(np.searchsorted(recording, index)), int(np.searchsorted(recording, index, side="right")))


def tool_jacobians(robot: Robot, regressor: Regressor, signals: Sequence[Signals]) -> Array:
    """The Jacobian (M, 3, n) of the tool in each row of the regressor of some signals."""
    result = np.empty((len(regressor.time), 3, robot.n))
    for index, one in enumerate(signals):
        for some in row_slices([rows_of(regressor.recording, index)]):
            at = np.clip(np.searchsorted(one.time, regressor.time[some]), 0, len(one.time) - 1)
            result[some] = tool_jacobian(robot, one.q[at])
    return result


@dataclass(frozen=True, kw_only=True, eq=False)
class SearchData:
    """Candidates' columns and the torque to explain on common rows.

    ``response`` (M, n) [N m|N]: what the model as given leaves of the torque; ``fold`` (M,) of each row, OUTSIDE in gaps;
    ``memory`` (n,): how many correlated rows are worth one independent row. The first ``model_columns`` of the regressor are the
    model's own. What was computed of the rows is kept in ``kept``, which the same rows with other candidates share.
    """

    regressor: Regressor
    candidates: tuple[Candidate, ...]
    response: Array
    fold: NDArray[np.intp]
    memory: Array
    model_columns: int = 0
    kept: dict[str, Any] = field(default_factory=dict)

    @cached_property
    def groups(self) -> list[OptionGroup]:
        """The candidates' options gathered by their number of columns."""
        sizes = sorted({len(option.columns) for c in self.candidates for option in c.options})
        return [OptionGroup.of(self.candidates, k) for k in sizes]

    def joint_columns(self, joint: int, wanted: Sequence[int]) -> Array:
        """Values (M, k) of some columns in a joint's rows (index from 0), zero where they have none."""
        rows = self.regressor.joints[joint]
        place = {int(column): k for k, column in enumerate(rows.columns)}
        values = np.zeros((len(rows.values), len(wanted)))
        for k, column in enumerate(wanted):
            if column in place:
                values[:, k] = rows.values[:, place[column]]
        return values

    def columns(self, wanted: Sequence[int]) -> Columns:
        """Values (M, k) of some columns in each joint's rows."""
        joints = []
        for rows in self.regressor.joints:
            place = {int(column): k for k, column in enumerate(rows.columns)}
            present = [k for k, column in enumerate(wanted) if column in place]
            taken = [place[wanted[k]] for k in present]
            values = empty((len(taken), len(self.response))).T
            for some in steps(len(values)):
                values[some] = rows.some(some)[:, taken]
            joints.append((np.array(present, dtype=np.intp), values))
        return Columns(len(wanted), len(self.response), tuple(joints))
