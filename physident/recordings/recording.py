"""A recording of an arm: time, positions, motor effort, and the rows that were left out of it."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError

Array = NDArray[np.float64]
EffortKind = Literal["torque", "current"]


@dataclass(frozen=True)
class BadRow:
    """A row left out of a recording: its number in the file, counted from 1, and why."""

    row: int
    reason: str


@dataclass(frozen=True, eq=False)
class Recording:
    """Measurements of an arm of n joints: N good rows in order of time.

    ``time`` (N,) [s], ``q`` (N, n) [rad|m], ``dq`` (N, n) [rad/s|m/s] or None, ``effort`` (N, n): a torque [N m] or, for
    ``effort_kind`` "current", a motor current [A], which ``drive_gains`` (n,) [N m/A] convert to a torque;
    ``temperature`` (N, n) [degC] or None. ``rejected`` are the rows that were left out, ``ignored`` the unused columns.
    """

    time: Array
    q: Array
    effort: Array
    effort_kind: EffortKind
    dq: Array | None = None
    temperature: Array | None = None
    drive_gains: tuple[float, ...] | None = None
    source: str = "recording"
    rejected: tuple[BadRow, ...] = ()
    ignored: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.effort_kind not in ("torque", "current"):
            raise InputError(f"{self.source}: effort_kind is {self.effort_kind!r}, expected 'torque' or 'current'")
        if self.q.ndim != 2 or self.time.shape != (len(self.q),):
            raise InputError(
                f"{self.source}: time {self.time.shape} and q {self.q.shape} do not fit: expected (N,), (N, n)"
            )
        for name in ("effort", "dq", "temperature"):
            value = getattr(self, name)
            if value is not None and value.shape != self.q.shape:
                raise InputError(f"{self.source}: {name} is {value.shape}, expected the shape of q, {self.q.shape}")
        if self.drive_gains is not None:
            check_gains(self.drive_gains, self.n, self.source)
        for name in ("time", "q", "effort", "dq", "temperature"):
            value = getattr(self, name)
            if value is not None and value.flags.writeable:  # the caller's array stays the caller's
                kept = value.copy()
                kept.setflags(write=False)
                object.__setattr__(self, name, kept)

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.q.shape[1]

    @property
    def duration(self) -> float:
        """Time from the first to the last good row [s]."""
        return float(self.time[-1] - self.time[0])

    @cached_property
    def torque(self) -> Array:
        """Joint torque (N, n) [N m]; raises InputError for currents without drive gains."""
        if self.effort_kind == "torque":
            return self.effort
        if self.drive_gains is None:
            raise InputError(
                f"{self.source}: has motor currents [A] but no drive gains; give one for each joint [N m/A]:"
                ' drive_gains=(...) or --drive-gains "10.7 10.7 10.7 10.2 10.2 10.2"'
            )
        return self.effort * np.array(self.drive_gains)

    @cached_property
    def sha256(self) -> str:
        """Hash of the parsed arrays: the same data under another name or format hash the same."""
        digest = hashlib.sha256()
        for value in (self.time, self.q, self.dq, self.effort):
            digest.update(b"none" if value is None else np.ascontiguousarray(value, dtype="<f8").tobytes())
        return digest.hexdigest()

    def with_drive_gains(self, gains: Sequence[float]) -> Recording:
        """The same recording with drive gains (n,) [N m/A]."""
        return replace(self, drive_gains=tuple(float(g) for g in gains))

    def with_default_drive_gains(self, gains: Sequence[float] | None) -> Recording:
        """The same recording with drive gains (n,) [N m/A] where it has currents and no gains yet, as for a model's."""
        if self.effort_kind == "torque" or self.drive_gains is not None or gains is None:
            return self
        return self.with_drive_gains(gains)

    def __repr__(self) -> str:
        rate = (len(self.time) - 1) / self.duration if self.duration > 0 else float("nan")
        text = f"Recording {self.source}: {self.n} joints, {self.duration:.1f} s at {rate:.0f} Hz, {self.effort_kind}"
        return text + (f", {len(self.rejected)} bad rows left out" if self.rejected else "")


def recording_count(count: int) -> str:
    """A number of recordings in words: "1 recording", "2 recordings"."""
    return "1 recording" if count == 1 else f"{count} recordings"


def check_gains(gains: Sequence[float], n: int, source: str) -> None:
    """Raises InputError unless drive gains [N m/A] are ``n`` finite numbers other than zero."""
    if len(gains) != n:
        raise InputError(f"{source}: {len(gains)} drive gains, expected {n}, one for each joint [N m/A]")
    if not all(isinstance(g, int | float) and math.isfinite(g) and g != 0 for g in gains):
        raise InputError(f"{source}: drive gains are {list(gains)}, expected finite numbers other than zero [N m/A]")
