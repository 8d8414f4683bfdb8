"""The column layout of a recording's table, declared by its canonical header or by the user."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.recordings.recording import EffortKind

Array = NDArray[np.float64]
CHANNELS = ("q", "dq", "tau", "current", "temperature")
EXAMPLE = "time=0,q=1:7,dq=7:13,current=13:19"


@dataclass(frozen=True, eq=False, kw_only=True)
class Channels:
    """The raw channels of a table, bad rows included: ``time`` (N,) [s], all others (N, n) or None, see ``Recording``."""

    time: Array
    q: Array
    effort: Array
    effort_kind: EffortKind
    dq: Array | None = None
    temperature: Array | None = None


@dataclass(frozen=True, kw_only=True)
class ColumnLayout:
    """Zero-based column numbers of a table: ``time``, and one for each joint of ``q``, ``dq``, effort, temperature."""

    time: int
    q: tuple[int, ...]
    effort: tuple[int, ...]
    effort_kind: EffortKind
    dq: tuple[int, ...] | None = None
    temperature: tuple[int, ...] | None = None

    @staticmethod
    def parse(text: str) -> ColumnLayout:
        """The layout that a text declares, such as "time=0,q=1:7,dq=7:13,current=13:19" (zero-based, half-open ranges)."""
        if not isinstance(text, str):
            raise InputError(f"columns: {text!r} is not understood; expected a text such as {EXAMPLE!r}")
        found: dict[str, tuple[int, ...]] = {}
        for part in text.split(","):
            match = re.fullmatch(r"\s*(\w+)\s*=\s*([0-9]{1,6})(?::([0-9]{1,6}))?\s*", part)
            if not match or match[1] not in ("time", *CHANNELS):
                raise InputError(
                    f"columns: {part!r} is not understood; expected a text such as {EXAMPLE!r} ({', '.join(CHANNELS)})"
                )
            if match[1] in found:
                raise InputError(f"columns: {match[1]!r} is given twice; expected each channel once, as in {EXAMPLE!r}")
            start = int(match[2])
            stop = int(match[3]) if match[3] else start + 1
            if stop <= start:
                raise InputError(
                    f"columns: {part!r} is an empty range; expected first:past-the-last, as in {EXAMPLE!r}"
                )
            found[match[1]] = tuple(range(start, stop))
        return ColumnLayout._from(found, "columns")

    @staticmethod
    def from_header(names: Sequence[str] | None, source: str) -> ColumnLayout:
        """The layout of a canonical header ``time,q_1..q_n,dq_1..,tau_1..`` or ``current_1..``, ``temperature_1..``."""
        if names is None:
            raise InputError(f"{source}: has no header; declare its layout, for example --columns {EXAMPLE}")
        found: dict[str, dict[int, int]] = {}
        for index, name in enumerate(names):
            match = re.fullmatch(rf"(time)|({'|'.join(CHANNELS)})_([0-9]{{1,4}})", name)
            if match is None:
                continue
            joints, number = found.setdefault(match[1] or match[2], {}), int(match[3] or 1)
            if number in joints:
                raise InputError(f"{source}: column {name!r} appears twice, expected each once")
            joints[number] = index
        for channel, joints in found.items():
            if sorted(joints) != list(range(1, len(joints) + 1)):
                numbers = ", ".join(map(str, sorted(joints)))
                raise InputError(f"{source}: {channel} is given for joints {numbers}; expected exactly 1 to n")
        return ColumnLayout._from({k: tuple(v[j] for j in sorted(v)) for k, v in found.items()}, source)

    @staticmethod
    def _from(found: dict[str, tuple[int, ...]], source: str) -> ColumnLayout:
        if len(found.get("time", ())) != 1:
            raise InputError(f"{source}: no time column; expected one named 'time' [s], or time=K in --columns")
        if not found.get("q"):
            raise InputError(f"{source}: no joint positions; expected columns q_1..q_n [rad], or q=A:B in --columns")
        efforts = [name for name in ("tau", "current") if found.get(name)]
        if len(efforts) != 1:
            present = "both tau and current" if efforts else "neither tau nor current"
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
            time=found["time"][0],
            q=found["q"],
            effort=found[efforts[0]],
            effort_kind="torque" if efforts[0] == "tau" else "current",
            dq=found.get("dq") or None,
            temperature=found.get("temperature") or None,
        )

    def check_width(self, width: int, source: str) -> None:
        """Raises InputError for a column beyond the ``width`` of the table."""
        last = max(self.time, *self.q, *self.effort, *(self.dq or ()), *(self.temperature or ()))
        if last >= width:
            raise InputError(
                f"{source}: has {width} columns, but its layout names column {last} (counted from 0); correct --columns"
            )

    def split(self, values: Array) -> Channels:
        """The channels of a table (N, C)."""

        def take(numbers: tuple[int, ...] | None) -> Array | None:
            return None if numbers is None else values[:, numbers]

        return Channels(
            time=values[:, self.time],
            q=values[:, self.q],
            effort=values[:, self.effort],
            effort_kind=self.effort_kind,
            dq=take(self.dq),
            temperature=take(self.temperature),
        )

    def unused(self, names: Sequence[str] | None) -> tuple[str, ...]:
        """Names of the columns in the table's header that belong to no channel."""
        used = {self.time, *self.q, *self.effort, *(self.dq or ()), *(self.temperature or ())}
        return tuple(name for index, name in enumerate(names or ()) if index not in used)
