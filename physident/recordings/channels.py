"""The raw channels of a recording, bad rows included, and what a bad row is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

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


@dataclass(frozen=True, eq=False, kw_only=True)
class Channels:
    """The raw channels of a table, bad rows included: ``time`` (N,) [s], all others (N, n) or None, see ``Recording``."""

    time: Array
    q: Array
    effort: Array
    effort_kind: EffortKind
    dq: Array | None = None
    temperature: Array | None = None


def numbers(value: Any, name: str, source: str) -> Array:
    """The values as an array of numbers; raises InputError for any that are none."""
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "fiuO":
            raise ValueError(f"values of type {array.dtype}")
        return array.astype(float, copy=False)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{source}: {name} is no array of real numbers ({str(error)[:120]}); expected numbers"
        ) from None


def read_only(value: Any, name: str, source: str) -> Array:
    """The values as an array that nobody can write to: a copy, unless it is read-only already."""
    array = numbers(value, name, source)
    if array.flags.writeable:
        array = array.copy()
        array.setflags(write=False)
    return array


def printable(text: Any) -> str:
    """A path or a name as a text that can be printed and saved: signs that are not printable are shown by their number."""
    return "".join(
        sign if sign.isprintable() else sign.encode("unicode_escape", "surrogatepass").decode() for sign in str(text)
    )


def check_gains(gains: Sequence[float], n: int, source: str) -> None:
    """Raises InputError unless drive gains [N m/A] are ``n`` finite numbers other than zero."""
    if len(gains) != n:
        raise InputError(f"{source}: {len(gains)} drive gains, expected {n}, one for each joint [N m/A]")
    if not all(isinstance(g, int | float) and math.isfinite(g) and g != 0 for g in gains):
        raise InputError(f"{source}: drive gains are {list(gains)}, expected finite numbers other than zero [N m/A]")
