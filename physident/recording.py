"""A recording of an arm: time, positions, motor effort - with the rows that cannot be trusted taken out and named."""

from __future__ import annotations

import glob
import hashlib
import math
import os
from bisect import bisect_left
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from physident.columns import Columns
from physident.errors import InputError

Array = NDArray[np.float64]

MIN_DURATION = 2.0  # s: shorter than one swing of any arm's slow modes
MAX_STEP = 0.1  # s: no dynamics can be seen in fewer than ten rows a second
MAX_POSITION = 4 * np.pi  # rad: two turns either way, the widest range any arm's joint has
MAX_DEGREES = 1e4  # a larger position is a corrupt number, not an angle in degrees
ABSURD = {"position": 100.0, "velocity": 100.0, "effort": 1e5, "temperature": 1e3}
UNITS = {"position": "rad", "velocity": "rad/s", "effort": "N m or A", "temperature": "degrees C"}
MAX_SPEED = 20.0  # rad/s or m/s: faster than the fastest wrist of any arm; a larger step of position is a fault
MIN_RUN = 10  # rows: a shorter run between two impossible steps is a burst of bad rows


@dataclass(frozen=True)
class BadRow:
    """A row left out of a recording: its number in the file, counted from 1, and why."""

    row: int
    reason: str


@dataclass(frozen=True, eq=False)
class Recording:
    """What an arm of n joints measured, N good rows in order of time.

    ``time`` (N,) [s], ``q`` (N, n) [rad|m], ``dq`` (N, n) [rad/s|m/s] or None, ``effort`` (N, n) which is a torque [N m]
    or, where ``effort_kind`` is "current", a motor current [A] that ``drive_gains`` (n,) [N m/A] turn into one;
    ``temperature`` (N, n) [degC] or None. ``rejected`` names the rows that were left out, ``ignored`` the columns.
    """

    time: Array
    q: Array
    effort: Array
    effort_kind: str
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
        for value in (self.time, self.q, self.effort, self.dq, self.temperature):
            if value is not None:
                value.setflags(write=False)

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
                f"{self.source}: holds motor currents [A] but no drive gains; give one for each joint [N m/A]:"
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

    def __repr__(self) -> str:
        rate = (len(self.time) - 1) / self.duration if self.duration > 0 else float("nan")
        text = f"Recording {self.source}: {self.n} joints, {self.duration:.1f} s at {rate:.0f} Hz, {self.effort_kind}"
        return text + (f", {len(self.rejected)} bad rows left out" if self.rejected else "")


def load_recordings(
    paths: str | Path | Iterable[str | Path],
    columns: str | Columns | None = None,
    drive_gains: Sequence[float] | None = None,
) -> list[Recording]:
    """Recordings from files or glob patterns, in sorted order for a pattern.

    ``columns`` declares the layout of files without the canonical header, as in
    ``"time=0,q=1:7,dq=7:13,current=13:19"`` (zero-based, half-open). ``drive_gains`` (n,) [N m/A] turn currents into
    joint torques. Raises InputError, naming the file, for what cannot be a recording.
    """
    patterns = [paths] if isinstance(paths, str | Path) else list(paths)
    return [load_recording(file, columns, drive_gains) for file in find_recordings(patterns)]


def find_recordings(patterns: Iterable[str | Path]) -> list[str]:
    """The files of paths and glob patterns, each once; raises InputError for one that matches nothing."""
    files: list[str] = []
    for pattern in map(str, patterns):
        found = [pattern] if os.path.exists(pattern) else sorted(filter(os.path.exists, glob.glob(pattern)))
        if not found:
            raise InputError(f"recording {pattern!r} not found: expected a file or a pattern that matches some")
        files += found
    return list(dict.fromkeys(files))


def load_recording(
    path: str | Path, columns: str | Columns | None = None, drive_gains: Sequence[float] | None = None
) -> Recording:
    """One recording from a .csv, .csv.gz or .npz file; arguments and errors as in ``load_recordings``."""
    from physident.formats import read_table

    layout = Columns.parse(columns) if isinstance(columns, str) else columns
    table = read_table(Path(path))
    layout = layout or Columns.from_header(table.names, str(path))
    layout.check_width(table.values.shape[1], str(path))
    recording = recording_from_rows(
        *layout.split(table.values), layout.effort_kind, str(path), table.rows, table.rejected
    )
    recording = replace(recording, ignored=layout.unused(table.names))
    if drive_gains is None:
        return recording
    gained = recording.with_drive_gains(drive_gains)
    if recording.effort_kind == "torque":
        raise InputError(
            f"{path}: holds torques, but drive gains are given; name its effort 'current' or drop the gains"
        )
    return gained


def recording_from_rows(
    time: Array,
    q: Array,
    dq: Array | None,
    effort: Array,
    temperature: Array | None,
    effort_kind: str,
    source: str,
    rows: NDArray[np.intp] | None = None,
    rejected: Sequence[BadRow] = (),
) -> Recording:
    """A recording from raw arrays (N,) and (N, n): rows that cannot be are left out and named.

    Left out: values that are not finite, absurd ones, a clock that stands or runs backwards, bursts between impossible
    steps of position. Raises InputError for degrees, milliseconds, under two seconds, over half the rows bad.
    """
    rows = np.arange(1, len(time) + 1) if rows is None else rows
    total = len(time) + len(rejected)
    reasons = np.full(len(time), "", dtype=object)
    channels = {"position": q, "velocity": dq, "effort": effort, "temperature": temperature}
    _refuse_degrees(q, source)
    finite = np.isfinite(time)
    for name, values in channels.items():
        if values is not None:
            finite &= np.isfinite(values).all(axis=1)
            with np.errstate(invalid="ignore"):
                reasons[(np.abs(values) > ABSURD[name]).any(axis=1)] = (
                    f"absurd {name} (above {ABSURD[name]:g} {UNITS[name]})"
                )
    reasons[~finite] = "a value is missing or not finite"
    good = np.flatnonzero(reasons == "")
    late = good[_not_increasing(time[good])]
    reasons[late] = "the clock stands or runs backwards"
    good = np.flatnonzero(reasons == "")
    reasons[good[_bursts(time[good], q[good])]] = f"between two jumps of position (above {MAX_SPEED:g} rad/s)"
    keep = reasons == ""
    bad = [*rejected, *(BadRow(int(r), str(why)) for r, why in zip(rows[~keep], reasons[~keep], strict=True))]
    if len(bad) > total / 2:
        first = min(bad, key=lambda b: b.row)
        raise InputError(
            f"{source}: {len(bad)} of {total} rows are bad (row {first.row}: {first.reason}); expected under half: check --columns and units"
        )
    time = np.array(time[keep], dtype=float)
    _check_clock(time, source)

    def kept(values: Array | None) -> Array | None:
        return None if values is None else np.array(values[keep], dtype=float)

    q, effort = np.array(q[keep], dtype=float), np.array(effort[keep], dtype=float)
    order = tuple(sorted(bad, key=lambda b: b.row))
    return Recording(time, q, effort, effort_kind, kept(dq), kept(temperature), source=source, rejected=order)


def _refuse_degrees(q: Array, source: str) -> None:
    with np.errstate(invalid="ignore"):
        wide = np.abs(q)
        wide = wide[(wide < MAX_DEGREES).all(axis=1)]
    if len(wide) and np.mean((wide > MAX_POSITION).any(axis=1)) > 0.05:
        joint = int(np.argmax(np.median(wide, axis=0))) + 1
        value = np.median(wide[:, joint - 1])
        raise InputError(
            f"{source}: positions beyond 4 pi rad (joint {joint}: typically {value:.4g}); expected radians: convert degrees"
        )


def _check_clock(time: Array, source: str) -> None:
    if len(time) < 2 or time[-1] - time[0] < MIN_DURATION:
        length = time[-1] - time[0] if len(time) else 0.0
        raise InputError(
            f"{source}: {length:.3g} s of good rows, expected at least {MIN_DURATION:g} s; is the clock in seconds?"
        )
    step = float(np.median(np.diff(time)))
    if step > MAX_STEP:
        raise InputError(
            f"{source}: rows are {step:.4g} s apart, expected at most {MAX_STEP} s: is the clock in milliseconds? convert to seconds"
        )


def _not_increasing(time: Array) -> NDArray[np.intp]:
    """Indices outside the longest strictly increasing subsequence: the fewest rows whose removal mends the clock."""
    if len(time) < 2 or (np.diff(time) > 0).all():
        return np.empty(0, dtype=np.intp)
    tails: list[float] = []
    ends: list[int] = []
    before = np.full(len(time), -1)
    for i, t in enumerate(time.tolist()):
        k = bisect_left(tails, t)
        before[i] = ends[k - 1] if k else -1
        tails[k : k + 1], ends[k : k + 1] = [t], [i]
    kept = np.zeros(len(time), dtype=bool)
    i = ends[-1]
    while i >= 0:
        kept[i] = True
        i = before[i]
    return np.flatnonzero(~kept)


def position_jumps(time: Array, q: Array) -> NDArray[np.intp]:
    """Rows k (sorted) where the step of position from row k-1 is faster than any arm can move."""
    if len(time) < 2:
        return np.empty(0, dtype=np.intp)
    step = np.diff(time)
    allowed = MAX_SPEED * np.maximum(step, np.median(step))
    return np.flatnonzero((np.abs(np.diff(q, axis=0)) > allowed[:, None]).any(axis=1)) + 1


def _bursts(time: Array, q: Array) -> NDArray[np.intp]:
    """Rows of short runs between impossible steps of position."""
    jumps = position_jumps(time, q)
    if not len(jumps):
        return jumps
    runs = np.split(np.arange(len(time)), jumps)
    short = [run for run in runs if len(run) < MIN_RUN]
    return np.concatenate(short) if short else np.empty(0, dtype=np.intp)


def check_gains(gains: Sequence[float], n: int, source: str) -> None:
    """Raises InputError unless drive gains [N m/A] are ``n`` finite numbers other than zero."""
    if len(gains) != n:
        raise InputError(f"{source}: {len(gains)} drive gains, expected {n}, one for each joint [N m/A]")
    if not all(isinstance(g, int | float) and math.isfinite(g) and g != 0 for g in gains):
        raise InputError(f"{source}: drive gains are {list(gains)}, expected finite numbers other than zero [N m/A]")
