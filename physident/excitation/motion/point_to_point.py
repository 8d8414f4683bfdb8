"""Point-to-point moves with a trapezoidal speed profile, as controllers of industrial arms generate them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from physident.errors import InputError
from physident.excitation.motion.motion import Array, Extent, Motion, checked
from physident.recordings.signals import Signals


@dataclass(frozen=True, eq=False)
class PointToPoint(Motion):
    """Moves in joint space through ``points`` (K, n) [rad|m], with a ``pause`` [s] at each point, the first included.

    In each move, the joint with the longest distance accelerates at ``acceleration`` [rad/s^2|m/s^2], continues at
    ``speed`` [rad/s|m/s] and decelerates. The other joints follow in proportion, so that all start and stop together. A
    short move does not reach ``speed``. Source: thesis section 2.1. Raises InputError for fewer than two points, points
    that are all the same, and for a speed or an acceleration that is not positive.
    """

    points: Array
    speed: float
    acceleration: float
    pause: float = 0.5

    kind: ClassVar[str] = "point_to_point"

    def __post_init__(self) -> None:
        points = checked("points", self.points, (None, None))
        if len(points) < 2 or not np.ptp(points, axis=0).any():
            raise InputError(f"trajectory: {len(points)} points without a move, expected two different points or more")
        values = {key: checked(key, getattr(self, key), ()).item() for key in ("speed", "acceleration", "pause")}
        if values["speed"] <= 0 or values["acceleration"] <= 0 or values["pause"] < 0:
            raise InputError(f"trajectory: {values}, expected positive speed and acceleration and no negative pause")
        for key, value in {"points": points, **values}.items():
            object.__setattr__(self, key, value)

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.points.shape[1]

    @cached_property
    def duration(self) -> float:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Time of all moves and pauses [s]."""
        return float(self._starts[-1])

    def states(self, time: Array) -> Signals:
        """Position, velocity and acceleration at instants (N,) [s]; at rest before the start and after the end."""
        time = np.asarray(time, dtype=float)
        move = np.clip(np.searchsorted(self._starts, time, side="right") - 1, 0, len(self._moves) - 1)
        since = np.clip(time - self._starts[move] - self.pause, 0.0, self._lengths[move])
        full, ramp = self._lengths[move], self._ramps[move]
        distance = np.abs(self._moves).max(axis=1)
        rise = np.divide(distance, (self._lengths - self._ramps) * self._ramps, where=distance > 0, out=0 * distance)
        rise = rise[move]  # the acceleration of the joint with the longest distance
        early, late = since < ramp, since > full - ramp
        remaining = full - since
        path = np.where(
            early, since**2 / 2, np.where(late, ramp * (full - ramp) - remaining**2 / 2, ramp * since - ramp**2 / 2)
        )
        pace = np.where(early, since, np.where(late, remaining, ramp))
        inside = (since > 0) & (since < full)
        change = np.where(inside & early, 1.0, np.where(inside & late, -1.0, 0.0))
        share = np.divide(
            self._moves[move], distance[move, None], where=distance[move, None] > 0, out=0 * self._moves[move]
        )
        along = share * rise[:, None]
        return Signals(
            time, self.points[move] + along * path[:, None], along * pace[:, None], along * change[:, None],
            source="trajectory",
        )  # fmt: skip

    def extent(self) -> Extent:
        """The largest positions, speeds and accelerations."""
        moves = np.abs(self._moves)
        moving = self._lengths > 0
        peak = np.max(moves[moving] / (self._lengths - self._ramps)[moving, None], axis=0)
        rise = np.max(moves[moving] / ((self._lengths - self._ramps) * self._ramps)[moving, None], axis=0)
        return Extent(self.points.min(axis=0), self.points.max(axis=0), peak, rise)

    def as_dict(self) -> dict[str, Any]:
        """The kind and the settings of the motion, for JSON."""
        settings = {key: getattr(self, key) for key in ("speed", "acceleration", "pause")}
        return {"kind": self.kind, "points": self.points.tolist(), **settings}

    @property
    def _moves(self) -> Array:
        return np.diff(self.points, axis=0)

    @cached_property
    def _ramps(self) -> Array:
        """Duration of acceleration in each move [s]."""
        distance = np.abs(self._moves).max(axis=1)
        return np.minimum(self.speed / self.acceleration, np.sqrt(distance / self.acceleration))

    @cached_property
    def _lengths(self) -> Array:
        """Duration of each move [s]: d = speed * (length - ramp) where the speed is reached, else two ramps."""
        distance = np.abs(self._moves).max(axis=1)
        return np.where(
            distance > self.speed**2 / self.acceleration, distance / self.speed + self._ramps, 2 * self._ramps
        )

    @cached_property
    def _starts(self) -> Array:
        """Start of the pause before each move, and the end of the pause after the last [s]."""
        ends = np.cumsum(self._lengths + self.pause)
        return np.concatenate([[0.0], ends[:-1], [ends[-1] + self.pause]])
