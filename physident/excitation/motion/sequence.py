"""Several motions one after the other."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from physident.errors import InputError
from physident.excitation.motion.motion import Array, Extent, Motion
from physident.recordings.signals import Signals


@dataclass(frozen=True, eq=False)
class MotionSequence(Motion):
    """``parts`` one after the other, with a ``pause`` [s] after each; to be looked at, because a part need not start where the
    one before it ended. Raises InputError for no parts, or parts of different arms."""

    parts: tuple[Motion, ...]
    pause: float = 1.0

    kind: ClassVar[str] = "sequence"

    def __post_init__(self) -> None:
        if not self.parts or len({part.n for part in self.parts}) > 1:
            raise InputError(
                f"a sequence of {len(self.parts)} motions, expected one or more of the same number of joints"
            )

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.parts[0].n

    @property
    def duration(self) -> float:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Time of all parts and pauses [s]."""
        return float(self._starts[-1])

    def states(self, time: Array) -> Signals:
        """Position, velocity and acceleration at instants (N,) [s]; at standstill between the parts."""
        time = np.asarray(time, dtype=float)
        index = np.clip(np.searchsorted(self._starts, time, side="right") - 1, 0, len(self.parts) - 1)
        q, v, a = np.zeros((3, len(time), self.n))
        for k, part in enumerate(self.parts):
            rows = index == k
            own = part.states(time[rows] - self._starts[k])
            q[rows], v[rows], a[rows] = own.q, own.v, own.a
        return Signals(time, q, v, a, source="trajectory")

    def extent(self) -> Extent:
        """The largest positions, speeds and accelerations of any part."""
        every = [part.extent() for part in self.parts]
        return Extent(
            np.min([one.lower for one in every], axis=0),
            np.max([one.upper for one in every], axis=0),
            np.max([one.speed for one in every], axis=0),
            np.max([one.acceleration for one in every], axis=0),
        )

    def as_dict(self) -> dict[str, Any]:
        """The kind and the settings of the parts."""
        return {"kind": self.kind, "pause": self.pause, "parts": [part.as_dict() for part in self.parts]}

    @cached_property
    def _starts(self) -> Array:
        return np.concatenate([[0.0], np.cumsum([part.duration + self.pause for part in self.parts])])
