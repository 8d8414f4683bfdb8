"""Entries of a model file held against what a saved estimate can hold: a damaged one is named before it is used."""

from __future__ import annotations

import math
from typing import Any

from physident.errors import InputError

CERTIFICATE = ("stationarity", "condition", "determined", "iterations", "primal", "gap")


def check_entries(data: dict[str, Any]) -> None:
    """Raises InputError, naming the entry, for one of another type or range than an estimate saves.

    ``data`` is a model file's content; KeyError and TypeError tell of missing entries and of structures that are none.
    """
    _whole("blocks", data["blocks"], 1)
    if data["prior_weight"] is not None:
        _number("prior_weight", data["prior_weight"], 0.0)
    for name in ("shares", "base_shares"):
        _numbers(name, data[name], 0.0, 1.0)
    for k, text in enumerate(_listed("held", data["held"])):
        _text(f"held[{k}]", text)
    for k, source in enumerate(_listed("recordings", data["recordings"])):
        _fields(f"recordings[{k}]", source, texts=("path", "sha256"), numbers=("duration", "used"))
    for k, shape in enumerate(_listed("shapes", data["shapes"])):
        _fields(f"shapes[{k}]", shape, texts=("effect", "field", "unit"), numbers=("value", "std"))
        _whole(f"shapes[{k}].joint", shape["joint"], 1)
    for name in CERTIFICATE:
        _number(f"certificate.{name}", data["certificate"][name])
    _numbers("certificate.eigenvalues", data["certificate"]["eigenvalues"])
    _check_estimator(data["estimator"])


def _check_estimator(data: dict[str, Any]) -> None:
    """What a physical estimator does not ask of its own settings until it solves."""
    for name in ("resamples", "seed"):
        if name in data:
            _whole(f"estimator.{name}", data[name], 0)
    nominal = data["prior"]["nominal"] if "prior" in data else None
    if nominal is not None:
        _numbers("estimator.prior.nominal", nominal)


def _fields(where: str, value: Any, texts: tuple[str, ...], numbers: tuple[str, ...]) -> None:
    if not isinstance(value, dict):
        raise _misfit(where, value, "an object")
    for name in texts:
        _text(f"{where}.{name}", value[name])
    for name in numbers:
        _number(f"{where}.{name}", value[name], 0.0)


def _listed(where: str, value: Any) -> list[Any]:
    if not isinstance(value, list):
        raise _misfit(where, value, "a list")
    return value


def _numbers(where: str, value: Any, low: float = -math.inf, high: float = math.inf) -> None:
    for k, one in enumerate(_listed(where, value)):
        _number(f"{where}[{k}]", one, low, high)


def _number(where: str, value: Any, low: float = -math.inf, high: float = math.inf) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise _misfit(where, value, "a finite number")
    if not low <= value <= high:
        raise _misfit(where, value, f"at least {low:g}" if high == math.inf else f"{low:g} to {high:g}")


def _whole(where: str, value: Any, least: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise _misfit(where, value, f"a whole number from {least}")


def _text(where: str, value: Any) -> None:
    if not isinstance(value, str):
        raise _misfit(where, value, "a text")


def _misfit(where: str, value: Any, expected: str) -> InputError:
    text = repr(value)
    shown = text if len(text) < 60 else f"{text[:57]}..."
    return InputError(f"{where} is {shown}, expected {expected}; identify it again")
