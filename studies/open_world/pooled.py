"""Summaries of sets that were run at different times, as if they were one: hits and trials add up."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from studies.open_world.summary import share

Summary = Mapping[str, Any]


def pooled(one: Summary, other: Summary) -> dict[str, Any]:
    """Two summaries as one; what only one of them counted is its own."""
    result = {key: _both(one.get(key), other.get(key)) for key in {**one, **other} if key != "seconds"}
    both, n = (one, other), one["rows"] + other["rows"]
    result["seconds"] = {  # a mean over trials
        stage: sum(some["seconds"].get(stage, 0.0) * some["rows"] for some in both) / n
        for stage in {**one["seconds"], **other["seconds"]}
    }
    return result


def _both(one: Any, other: Any) -> Any:
    """Counts add up, shares are those of all trials, and parts are pooled by their names."""
    if one is None or other is None:
        return other if one is None else one
    if not isinstance(one, Mapping):
        return one + other
    if {"n", "percent"} <= one.keys():
        hits, n = _hits(one) + _hits(other), one["n"] + other["n"]
        return share([True] * hits + [False] * (n - hits))
    return {key: _both(one.get(key), other.get(key)) for key in {**one, **other}}


def _hits(some: Mapping[str, float]) -> int:
    return round(some["percent"] * some["n"] / 100)
