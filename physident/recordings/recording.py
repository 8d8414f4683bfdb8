"""A recording of an arm: time, positions, motor effort, and the rows that were left out of it."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from physident.errors import InputError, warn
from physident.large_arrays import blocks, is_finite, is_increasing, scaled
from physident.recordings.channels import BadRow, Channels, EffortKind, check_gains, numbers, read_only
from physident.recordings.columns.joint_names import joint_order
from physident.recordings.columns.layout import ColumnLayout
from physident.recordings.columns.reading import Reading
from physident.recordings.formats.frame import frame_of, table_of_frame
from physident.recordings.formats.table import Table
from physident.recordings.notebook import recording_html
from physident.recordings.rows import good_rows

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]
ARRAYS = ("time", "q", "effort", "dq", "temperature")


@dataclass(frozen=True, eq=False)
class Recording:
    """Measurements of an arm of n joints: N good rows in order of time.

    ``time`` (N,) [s], ``q`` (N, n) [rad|m], ``dq`` (N, n) [rad/s|m/s] or None, ``effort`` (N, n): a torque [N m] or, for
    ``effort_kind`` "current", a motor current [A], which ``drive_gains`` (n,) [N m/A] convert to a torque;
    ``temperature`` (N, n) [degC] or None. ``rejected`` are the rows that were left out, ``ignored`` the unused columns.
    ``joint_names`` (n,) are known for files that name the joints. ``effort_stated`` is False where the file does not state
    whether the effort is a torque or a current, as in ROS: it is a torque unless there are drive gains. ``layout`` is the text that
    declared the columns of its file.

    Arrays that may contain bad rows go through ``Recording.from_arrays`` or ``Recording.from_frame``.
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
    joint_names: tuple[str, ...] | None = None
    effort_stated: bool = True
    layout: str | None = None

    def __post_init__(self) -> None:
        for name in ARRAYS:
            value = getattr(self, name)
            if value is not None or name in ("time", "q", "effort"):
                object.__setattr__(self, name, read_only(value, name, self.source))
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
        if self.joint_names is not None and len(self.joint_names) != self.n:
            raise InputError(
                f"{self.source}: {len(self.joint_names)} joint names, expected {self.n}, one for each joint"
            )
        if not is_increasing(self.time) or not all(
            is_finite(value) for name in ARRAYS if (value := getattr(self, name)) is not None
        ):
            raise InputError(
                f"{self.source}: a value is not finite, or the time does not increase; expected good rows only:"
                " Recording.from_arrays leaves bad rows out"
            )

    @staticmethod
    def from_arrays(
        time: ArrayLike | None,
        q: ArrayLike,
        effort: ArrayLike,
        dq: ArrayLike | None = None,
        *,
        effort_kind: EffortKind | None = None,
        drive_gains: Sequence[float] | None = None,
        temperature: ArrayLike | None = None,
        joint_names: Sequence[str] | None = None,
        rate: float | None = None,
        source: str = "arrays",
    ) -> Recording:
        """A recording from arrays, whose bad rows are left out as those of a file; the arrays are copied.

        ``time`` (N,) [s], or None with a ``rate`` [Hz]; ``q`` (N, n) [rad|m], ``effort`` (N, n) a torque [N m|N] or, with
        ``drive_gains`` (n,) [N m/A] or the ``effort_kind`` "current", a current [A]; ``dq`` (N, n) [rad/s|m/s] and
        ``temperature`` (N, n) [degC] may be missing. With ``joint_names`` (n,), the joints are brought into the order of
        the robot. Raises InputError for shapes that do not fit and for arrays that are no recording.
        """
        Reading(rate=rate)
        kind = effort_kind or ("torque" if drive_gains is None else "current")
        if (time is None) == (rate is None):
            raise InputError(f"{source}: expected the time [s] of each row, or a rate [Hz] without a time")
        given = {"q": q, "effort": effort, "dq": dq, "temperature": temperature}
        arrays = {name: numbers(value, name, source) for name, value in given.items() if value is not None}
        positions = arrays["q"]
        clock = numbers(time, "time", source) if rate is None else np.arange(len(positions)) / rate
        if positions.ndim != 2 or clock.shape != positions.shape[:1] or not positions.shape[1]:
            raise InputError(f"{source}: time {clock.shape} and q {positions.shape} do not fit: expected (N,), (N, n)")
        if wrong := [name for name, value in arrays.items() if value.shape != positions.shape]:
            raise InputError(
                f"{source}: {wrong[0]} is {arrays[wrong[0]].shape}, expected the shape of q, {positions.shape}"
            )
        names = None if joint_names is None else tuple(map(str, joint_names))
        channels = Channels(time=clock, effort_kind=kind, **arrays)
        return recording_from_rows(channels, source, joint_names=names).gained(drive_gains)

    @staticmethod
    def from_frame(
        frame: Any,
        columns: str | ColumnLayout | None = None,
        drive_gains: Sequence[float] | None = None,
        *,
        joint_names: Sequence[str] | None = None,
        rate: float | None = None,
        source: str = "frame",
    ) -> Recording:
        """A recording from a pandas or polars frame with the columns of a file: ``time, q_1.., dq_1.., tau_1..`` and so on.

        ``columns`` declares other names, as in ``"time=t,q=position,tau=torque"``. ``drive_gains`` (n,) [N m/A],
        ``joint_names`` (n,) and ``rate`` [Hz] are those of ``from_arrays``. Raises InputError as reading a file does.
        """
        reading = Reading.parse(columns) if isinstance(columns, str) else Reading(columns=columns)
        if rate is not None:
            reading = replace(reading, rate=rate)
        table = table_of_frame(frame, source)
        if joint_names is not None:
            table = replace(table, joints=tuple(map(str, joint_names)))
        return Recording.from_table(table, reading, source).gained(drive_gains)

    @staticmethod
    def from_table(table: Table, reading: Reading, source: str) -> Recording:
        """The recording in a table, without its bad rows, with the joints in the order that ``reading`` wants.

        Raises InputError for a table without the columns of a recording.
        """
        declared, clock = reading.columns, reading.rate is None
        if isinstance(declared, str):
            layout = ColumnLayout.parse(declared, table.names, source, clock)
        else:
            layout = declared or ColumnLayout.from_header(table.names, source, clock)
        layout.check_width(table.values.shape[1], source)
        if reading.rate is not None and layout.time is not None:
            warn(f"{source}: has a clock, which is used; its rows are not taken to be at {reading.rate:g} Hz")
        # rows that could not be read leave a gap
        time = None if reading.rate is None else (table.rows - 1) / reading.rate
        recording = recording_from_rows(
            layout.split(table.values, time), source, table.rows, table.rejected, table.joints, layout.effort_stated
        )
        recording = replace(recording, ignored=layout.unused(table.names))
        if reading.declared_joints is not None:
            if recording.joint_names is None:
                raise InputError(
                    f"{source}: its joints have no names, but names are declared; expected columns in the order"
                )
            return replace(recording.in_order_of(reading.declared_joints), joint_names=None)
        return recording if reading.joints is None else recording.in_order_of(reading.joints)

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
        return scaled(self.effort, np.array(self.drive_gains))

    @cached_property
    def sha256(self) -> str:
        """Hash of the parsed arrays: the same data under another name or format hash the same."""
        digest = hashlib.sha256()
        for value in (self.time, self.q, self.dq, self.effort):
            if value is None:
                digest.update(b"none")
                continue
            for rows in blocks(len(value)):
                digest.update(np.ascontiguousarray(value[rows], dtype="<f8").data)
        return digest.hexdigest()

    def with_drive_gains(self, gains: Sequence[float]) -> Recording:
        """The same recording with drive gains (n,) [N m/A]; an effort that is not stated to be a torque is then a current."""
        kind = self.effort_kind if self.effort_stated else "current"
        return replace(self, drive_gains=tuple(float(g) for g in gains), effort_kind=kind, effort_stated=True)

    def with_default_drive_gains(self, gains: Sequence[float] | None) -> Recording:
        """The same recording with drive gains (n,) [N m/A] where it has currents and no gains yet, as for a model's."""
        if self.drive_gains is not None or gains is None or (self.effort_kind == "torque" and self.effort_stated):
            return self
        if not self.effort_stated:
            warn(f"{self.source}: its effort is taken as motor currents [A], because the model has drive gains")
        return self.with_drive_gains(gains)

    def part(self, rows: slice) -> Recording:
        """Some rows of the recording, as one that lists no bad rows."""
        arrays = {name: None if (value := getattr(self, name)) is None else value[rows] for name in ARRAYS}
        return replace(self, rejected=(), **arrays)

    def in_order_of(self, joints: Sequence[str]) -> Recording:
        """The recording of these joints alone, in their order; as it is where its joints have no names.

        Raises InputError where a joint is missing, see ``joint_order``.
        """
        if self.joint_names is None or self.joint_names == tuple(joints):
            return self
        order = joint_order(self.joint_names, joints, self.source)
        arrays = {name: None if (value := getattr(self, name)) is None else value[:, order] for name in ARRAYS[1:]}
        gains = None if self.drive_gains is None else tuple(self.drive_gains[j] for j in order)
        return replace(self, drive_gains=gains, joint_names=tuple(joints), **arrays)

    def to_pandas(self) -> pd.DataFrame:
        """The good rows as a pandas frame with the columns ``time``, ``q_1``.., ``dq_1``.., ``tau_1``.. or ``current_1``..,
        ``temperature_1``..; raises InputError without pandas."""
        effort = "tau" if self.effort_kind == "torque" else "current"
        channels = {"q": self.q, "dq": self.dq, effort: self.effort, "temperature": self.temperature}
        return frame_of(self.time, channels)

    def gained(self, gains: Sequence[float] | None) -> Recording:
        """The same recording with drive gains (n,) [N m/A], or without; raises InputError for gains of a stated torque."""
        if gains is None:
            return self
        gained = self.with_drive_gains(gains)  # first, because it checks the gains
        if self.effort_kind == "torque" and self.effort_stated:
            raise InputError(
                f"{self.source}: contains torques, but drive gains are given; name its effort 'current', or leave out the gains"
            )
        return gained

    def __repr__(self) -> str:
        rate = (len(self.time) - 1) / self.duration if self.duration > 0 else float("nan")
        text = f"Recording {self.source}: {self.n} joints, {self.duration:.1f} s at {rate:.0f} Hz, {self.effort_kind}"
        return text + (f", {len(self.rejected)} bad rows left out" if self.rejected else "")

    def _repr_html_(self) -> str:
        return recording_html(self)


def recording_from_rows(
    channels: Channels,
    source: str,
    rows: NDArray[np.intp] | None = None,
    rejected: Sequence[BadRow] = (),
    joint_names: tuple[str, ...] | None = None,
    effort_stated: bool = True,
) -> Recording:
    """A recording from raw channels without the rows that ``good_rows`` leaves out, whose arguments and errors it has."""
    kept, bad = good_rows(channels, source, rows, rejected)
    return Recording(
        time=kept.time,
        q=kept.q,
        effort=kept.effort,
        effort_kind=kept.effort_kind,
        dq=kept.dq,
        temperature=kept.temperature,
        source=source,
        rejected=bad,
        joint_names=joint_names,
        effort_stated=effort_stated,
    )


def recording_count(count: int) -> str:
    """A number of recordings in words: "1 recording", "2 recordings"."""
    return "1 recording" if count == 1 else f"{count} recordings"
