"""The column layout of a recording's table, declared by its header or by the user."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.recordings.channels import Channels, EffortKind
from physident.recordings.columns.header import CHANNELS, check_named_alike, columns_named, columns_of_header

Array = NDArray[np.float64]
EFFORTS = ("tau", "current", "effort")
EXAMPLE = "time=0,q=1:7,dq=7:13,current=13:19"
NAME = r"[A-Za-z][\w./ -]*(?:\[[0-9:]{1,13}\])?"


@dataclass(frozen=True, kw_only=True)
class ColumnLayout:
    """Zero-based column numbers of a table: ``time``, and one for each joint of ``q``, ``dq``, effort, temperature.

    ``time`` is None for rows at a known rate. ``effort_stated`` is False where the table does not state whether its effort
    is a torque or a current, as in ROS.
    """

    time: int | None
    q: tuple[int, ...]
    effort: tuple[int, ...]
    effort_kind: EffortKind
    dq: tuple[int, ...] | None = None
    temperature: tuple[int, ...] | None = None
    effort_stated: bool = True

    @staticmethod
    def parse(
        text: str, names: Sequence[str] | None = None, source: str = "columns", clock: bool = True
    ) -> ColumnLayout:
        """The layout that a text declares, such as "time=0,q=1:7,dq=7:13,current=13:19" (zero-based, half-open ranges).

        Columns may also be given by their ``names``: "time=t,q=position,tau=torque[0:6]". Without a ``clock``, no time
        column is needed. Raises InputError where a number takes a column that its name gives to another channel.
        """
        found: dict[str, tuple[int, ...]] = {}
        for channel, value in _entries(text):
            if re.fullmatch(NAME, value):
                found[channel] = columns_named(names or (), value, source)
                continue
            start, _, stop = value.partition(":")
            found[channel] = tuple(range(int(start), int(stop) if stop else int(start) + 1))
            check_named_alike(names or (), channel, found[channel], source)
        return ColumnLayout._from(found, source, clock)

    @staticmethod
    def from_header(names: Sequence[str] | None, source: str, clock: bool = True) -> ColumnLayout:
        """The layout of a header ``time,q_1..q_n,dq_1..,tau_1..`` or ``current_1..``, ``temperature_1..``, or of UR's names."""
        if names is None:
            raise InputError(f"{source}: has no header; declare its layout, for example --columns {EXAMPLE}")
        return ColumnLayout._from(columns_of_header(names, source), source, clock)

    @staticmethod
    def check(text: str) -> None:
        """Raises InputError for a text that declares no layout, whatever the file."""
        _entries(text)

    @staticmethod
    def _from(found: dict[str, tuple[int, ...]], source: str, clock: bool) -> ColumnLayout:
        if len(found.get("time", ())) != 1 and (clock or found.get("time")):
            raise InputError(
                f"{source}: no time column; expected one named 'time' [s], time=K in the columns, or the rate of the rows"
                " [Hz] (--rate)"
            )
        if not found.get("q"):
            raise InputError(f"{source}: no joint positions; expected columns q_1..q_n [rad], or q=A:B in the columns")
        efforts = [name for name in EFFORTS if found.get(name)]
        if len(efforts) != 1:
            present = f"both {' and '.join(efforts)}" if efforts else "neither tau nor current"
            raise InputError(f"{source}: has {present}; expected one: tau_1..tau_n [N m] or current_1..current_n [A]")
        n = len(found["q"])
        for name in (*efforts, "dq", "temperature"):
            if name in found and len(found[name]) != n:
                raise InputError(f"{source}: {len(found[name])} columns of {name} and {n} of q; expected as many")
        numbers = [number for channel in found.values() for number in channel]
        if len(set(numbers)) < len(numbers):
            twice = next(number for number in numbers if numbers.count(number) > 1)
            raise InputError(f"{source}: column {twice} is in two channels; expected ranges that do not overlap")
        return ColumnLayout(
            time=found["time"][0] if "time" in found else None,
            q=found["q"],
            effort=found[efforts[0]],
            effort_kind="current" if efforts[0] == "current" else "torque",
            dq=found.get("dq") or None,
            temperature=found.get("temperature") or None,
            effort_stated=efforts[0] != "effort",
        )

    @property
    def _used(self) -> set[int]:
        time = () if self.time is None else (self.time,)
        return {*time, *self.q, *self.effort, *(self.dq or ()), *(self.temperature or ())}

    def check_width(self, width: int, source: str) -> None:
        """Raises InputError for a column beyond the ``width`` of the table."""
        last = max(self._used)
        if last >= width:
            raise InputError(
                f"{source}: has {width} columns, but its layout names column {last} (counted from 0); correct the columns"
            )

    def split(self, values: Array, clock: Array | None = None) -> Channels:
        """The channels of a table (N, C); ``clock`` (N,) [s] stands for a missing time column."""

        def take(numbers: tuple[int, ...] | None) -> Array | None:
            if numbers is None:
                return None
            first, last = numbers[0], numbers[-1]
            consecutive = numbers == tuple(range(first, last + 1))
            return values[:, first : last + 1] if consecutive else values[:, numbers]  # a view needs no memory

        time = clock if self.time is None else values[:, self.time]
        q, effort = take(self.q), take(self.effort)
        assert time is not None
        assert q is not None
        assert effort is not None
        return Channels(
            time=time,
            q=q,
            effort=effort,
            effort_kind=self.effort_kind,
            dq=take(self.dq),
            temperature=take(self.temperature),
        )

    def unused(self, names: Sequence[str] | None) -> tuple[str, ...]:
        """Names of the columns in the table's header that belong to no channel."""
        return tuple(name for index, name in enumerate(names or ()) if index not in self._used)


def _entries(text: str) -> list[tuple[str, str]]:
    """Channel and columns of each entry; raises InputError for one that is not understood, empty or given twice."""
    if not isinstance(text, str):
        raise InputError(f"columns: {text!r} is not understood; expected a text such as {EXAMPLE!r}")
    found: dict[str, str] = {}
    for part in text.split(","):
        match = re.fullmatch(rf"\s*(\w+)\s*=\s*(?:([0-9]{{1,6}})(?::([0-9]{{1,6}}))?|{NAME})\s*", part)
        if not match or match[1] not in ("time", *CHANNELS):
            raise InputError(
                f"columns: {part!r} is not understood; expected a text such as {EXAMPLE!r} ({', '.join(CHANNELS)})"
            )
        if match[1] in found:
            raise InputError(f"columns: {match[1]!r} is given twice; expected each channel once, as in {EXAMPLE!r}")
        if match[3] and int(match[3]) <= int(match[2]):
            raise InputError(f"columns: {part!r} is an empty range; expected first:past-the-last, as in {EXAMPLE!r}")
        found[match[1]] = part.partition("=")[2].strip()
    return list(found.items())
