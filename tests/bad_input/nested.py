"""Entries of nested JSON by their path."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from typing import Any


def replaced(data: dict[str, Any], path: tuple[str | int, ...], value: Any) -> dict[str, Any]:
    """A copy of the data with the entry at a path replaced."""
    copy = json.loads(json.dumps(data))
    _holder(copy, path)[path[-1]] = value
    return copy


def without(*path: str | int) -> Callable[[dict], None]:
    """A change in place that takes the entry at a path away."""

    def change(data: dict) -> None:
        del _holder(data, path)[path[-1]]

    return change


def _holder(data: Any, path: tuple[str | int, ...]) -> Any:
    for key in path[:-1]:
        data = data[key]
    return data


def leaves(value: Any, path: tuple = ()) -> Iterator[tuple]:
    """Paths of every entry of nested JSON, of lists only the first."""
    if path:
        yield path
    entries = (
        value.items() if isinstance(value, dict) else list(enumerate(value))[:1] if isinstance(value, list) else ()
    )
    for key, one in entries:
        yield from leaves(one, (*path, key))
