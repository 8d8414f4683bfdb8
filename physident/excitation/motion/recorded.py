"""The motion of a recording, to be recorded again."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from scipy.interpolate import CubicSpline

from physident.errors import InputError
from physident.excitation.motion.motion import Array, Extent, Motion, checked
from physident.recordings.signals import MOVING_SPEED, Signals
from physident.robots.robot import Robot

KNOTS = (
    8  # of a period of the filter's cutoff: a cubic spline through them follows what the filter passes to a thousandth
)
SHORTEST_REPEAT = (
    5.0  # s that two recordings must have in common to be compared: a slow stretch alone can be like another
)
LEAD = 1.0  # s, in which a motion that was recorded at speed is started and stopped


@dataclass(frozen=True, eq=False)
class RecordedMotion(Motion):
    """A smooth motion through ``points`` (K, n) [rad|m] at a ``rate`` [Hz], from standstill to standstill.

    Between the points each joint follows a cubic spline. Raises InputError for fewer than four points and for a rate that is not
    positive.
    """

    points: Array
    rate: float

    kind: ClassVar[str] = "recorded"

    def __post_init__(self) -> None:
        points, rate = checked("points", self.points, (None, None)), checked("rate", self.rate, ()).item()
        if len(points) < 4 or rate <= 0:
            raise InputError(
                f"trajectory: {len(points)} points at {rate} Hz, expected four or more and a positive rate"
            )
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "rate", rate)

    @staticmethod
    def of_signals(signals: Signals, seconds: float, robot: Robot) -> RecordedMotion | None:
        """The motion of a recording's first contiguous part in at most so many ``seconds``; None where nothing moves there.

        Where the recording begins or is cut at speed, a second of it is spent on starting or stopping the arm; it begins later, or ends
        earlier, where a joint would leave its range in that second.
        """
        part = signals.part(signals.segments[0])
        moving = part.moving
        if moving is None:
            return None
        first = _first_inside(part, int(np.searchsorted(part.time, moving[0])), -1, robot)
        end = min(moving[1], part.time[first] + seconds - 2 * LEAD)
        last = _first_inside(part, min(int(np.searchsorted(part.time, end)), len(part.time) - 1), 1, robot)
        step = max(1, int(signals.rate / (KNOTS * signals.cutoff)))
        rows = np.arange(first, last + 1, step)
        rate = signals.rate / step
        if len(rows) < 4:
            return None
        q, v = part.q[rows], part.v[rows]
        return RecordedMotion(np.concatenate([_lead(q[0], -v[0], rate)[::-1], q, _lead(q[-1], v[-1], rate)]), rate)

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.points.shape[1]

    @property
    def duration(self) -> float:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Time of the motion [s]."""
        return (len(self.points) - 1) / self.rate

    def states(self, time: Array) -> Signals:
        """Position, velocity and acceleration at instants (N,) [s]; at standstill before the start and after the end."""
        time = np.asarray(time, dtype=float)
        inside = ((time >= 0) & (time <= self.duration))[:, None]
        at = np.clip(time, 0.0, self.duration)
        q, v, a = (np.asarray(self._path(at, k)) for k in range(3))
        return Signals(time, q, v * inside, a * inside, source="trajectory")

    def extent(self) -> Extent:
        """The largest positions, speeds and accelerations, at the points and where a derivative is zero between them."""
        knots = np.arange(len(self.points)) / self.rate
        q, v = [np.asarray(self._path(knots))], [np.asarray(self._path(knots, 1))]
        for values, order in ((q, 1), (v, 2)):
            for roots in np.atleast_1d(self._path.derivative(order).roots(extrapolate=False)):
                at = np.asarray(roots)[np.isfinite(roots)]
                values.append(np.asarray(self._path(at, order - 1)).reshape(-1, self.n))
        positions, speeds = np.concatenate(q), np.abs(np.concatenate(v))
        return Extent(
            positions.min(axis=0), positions.max(axis=0), speeds.max(axis=0), np.abs(self._path(knots, 2)).max(axis=0)
        )

    def as_dict(self) -> dict[str, Any]:
        """The kind and the points of the motion, for JSON."""
        return {"kind": self.kind, "points": self.points.tolist(), "rate": self.rate}

    @cached_property
    def _path(self) -> CubicSpline:
        return CubicSpline(np.arange(len(self.points)) / self.rate, self.points, bc_type="clamped")


def _first_inside(part: Signals, at: int, way: int, robot: Robot) -> int:
    """The sample nearest to ``at`` from which every joint stops inside its range, or started inside of it (``way`` -1); ``at`` where none does."""
    stop = part.q + way * LEAD / 2 * part.v  # a speed that falls as in ``_lead``
    # a recording itself may go beyond a limit by its noise
    inside = (stop >= np.minimum(robot.lower, part.q)) & (stop <= np.maximum(robot.upper, part.q))
    found = np.flatnonzero(inside.all(axis=1))
    found = found[found <= at] if way > 0 else found[found >= at]
    return int(at) if not len(found) else int(found[-1] if way > 0 else found[0])


def _lead(q: Array, v: Array, rate: float) -> Array:
    """Positions (K, n) after ``q`` (n,) in which a speed ``v`` (n,) falls smoothly to zero; none where it is as good as zero."""
    if (np.abs(v) <= MOVING_SPEED).all():
        return np.empty((0, len(q)))
    t = np.arange(1, int(LEAD * rate) + 1) / rate / LEAD
    return q + LEAD * v * (t / 2 + np.sin(np.pi * t) / (2 * np.pi))[:, None]
