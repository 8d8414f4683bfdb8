"""What every limit of the workspace provides: a constraint for the search, and a margin for the check afterwards."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physident.recordings.signals import Signals

Array = NDArray[np.float64]
RESERVE = (
    0.03  # share of a torque or speed limit that the search keeps free: it looks at some instants of a period only
)
DISTANCE_RESERVE = 0.01  # m, for the same reason
LENGTH_UNIT = 0.3  # m: distances are divided by it, so that the solver sees numbers of the size of one
ACTIVE_SHARE = 0.05  # of a limit: a smaller margin means that the limit shaped the motion
ACTIVE_DISTANCE = 0.02  # m, the same for distances


@dataclass(frozen=True, kw_only=True)
class Margin:
    """The distance of a motion from one limit.

    ``limit`` is its name and ``where`` the joint, link or pair of links; ``reached`` and ``allowed`` are values in
    ``unit``, and ``margin`` the difference, negative beyond the limit. ``active``: the limit shaped the motion.
    """

    limit: str
    where: str
    reached: float
    allowed: float
    margin: float
    unit: str
    active: bool

    @staticmethod
    def of(
        limit: str, where: str, unit: str, *, reached: float, allowed: float, margin: float, active_below: float
    ) -> Margin:
        """The margin, active where it is smaller than ``active_below``."""
        return Margin(
            limit=limit,
            where=where,
            reached=float(reached),
            allowed=float(allowed),
            margin=float(margin),
            unit=unit,
            active=bool(margin < active_below),
        )


class WorkspaceLimit(ABC):
    """One limit of the workspace, as constraints ``lower`` <= g <= ``upper`` in units of the limit."""

    lower: ClassVar[float]
    upper: ClassVar[float]

    @property
    @abstractmethod
    def count(self) -> int:
        """Number R of constraints at each instant."""

    @abstractmethod
    def constraint(self, values: Array) -> Array:
        """g (N, R) from values (N, n + 1 + 3 P) of the arm's state functions."""

    @abstractmethod
    def gradient(self, values: Array, jacobian: Array) -> Array:
        """Derivatives of g (N, R, 3 n) by the state, from those values and their Jacobian (N, n + 1 + 3 P, 3 n)."""

    @abstractmethod
    def margins(self, states: Signals) -> list[Margin]:
        """Margins along the states of a motion, computed without anything that the search uses where possible."""
