"""Options of all candidates gathered by their number of columns, so that each number is one array operation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import Candidate


@dataclass(frozen=True, eq=False)
class OptionGroup:
    """Options with k columns each: ``columns`` (O, k), their candidate's index ``owner`` (O,) and own index ``place``;
    ``prior`` (O, k): prior precision of their values."""

    columns: NDArray[np.intp]
    owner: NDArray[np.intp]
    place: NDArray[np.intp]
    prior: NDArray[np.float64]

    @staticmethod
    def of(candidates: Sequence[Candidate], k: int) -> OptionGroup:
        """The options with k columns."""
        found = [
            (option.columns, i, o, option.prior)
            for i, c in enumerate(candidates)
            for o, option in enumerate(c.options)
            if len(option.columns) == k
        ]
        columns = np.array([f[0] for f in found], dtype=np.intp)
        owner, place, prior = (np.array([f[at] for f in found]) for at in (1, 2, 3))
        return OptionGroup(columns, owner, place, prior)

    @property
    def prior_normal(self) -> NDArray[np.float64]:
        """What the prior adds to the normal matrix (O, k, k) of each option."""
        return self.prior[:, :, None] * np.eye(self.columns.shape[1])
