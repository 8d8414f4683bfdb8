"""Records from parsed JSON: what fits comes back typed, what does not is named."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal

import pytest

import physident as pid
from physident.json_records import Range, RecordReader


@dataclass(frozen=True)
class Inner:
    """A part of what JSON holds."""

    name: str
    size: float


@dataclass(frozen=True)
class Outer:
    """What JSON holds."""

    kind: Literal["a", "b"]
    parts: tuple[Inner, ...]
    ends: tuple[float, float]
    count: int | None
    weight: Annotated[float, Range(0.0, 1.0)]
    prior: float | Literal["auto"]


READER = RecordReader("write it again")
GOOD: dict[str, Any] = {
    "kind": "a",
    "parts": [{"name": "x", "size": 1}],
    "ends": [0, 1.5],
    "count": None,
    "more": 3,
} | {"weight": 0.5, "prior": 2}


def test_json_comes_back_as_what_wrote_it() -> None:
    assert READER.read(Outer, GOOD, "it") == Outer("a", (Inner("x", 1.0),), (0.0, 1.5), None, 0.5, 2.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"kind": "c"}, "it.kind is 'c', expected one of a, b"),
        ({"kind": []}, "it.kind is"),
        ({"parts": [{"name": "x"}]}, r"it.parts\[0\] has no 'size'"),
        ({"parts": [{"name": 3, "size": 1}]}, r"it.parts\[0\].name is 3, expected a text"),
        ({"parts": {}}, "it.parts is {}, expected a list"),
        ({"ends": [1]}, "expected 2 values"),
        ({"ends": [1, True]}, "expected a finite number"),
        ({"ends": [1, float("inf")]}, "expected a finite number"),
        ({"count": 1.5}, "expected a whole number"),
        ({"weight": 1.5}, "it.weight is 1.5, expected a number from 0 to 1; write it again"),
        ({"prior": "x"}, "it.prior is 'x', expected one of auto"),
        ({"prior": None}, "it.prior is None, expected a finite number"),
        ({"count": True}, "expected a whole number"),
    ],
)
def test_what_does_not_fit_is_named(change: dict[str, Any], message: str) -> None:
    with pytest.raises(pid.InputError, match=message):
        READER.read(Outer, GOOD | change, "it")
