"""Values of parsed JSON as the frozen dataclasses that once wrote them, every type checked."""

from __future__ import annotations

import math
import types
from dataclasses import fields, is_dataclass
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from physident.errors import InputError


def typed(kind: Any, value: Any, where: str) -> Any:
    """``value`` as ``kind``: a str, bool, int, float, Literal, tuple, union with None, or a dataclass of these.

    Keys a dataclass does not know are passed over. Raises InputError, saying ``where``, for what does not fit.
    """
    if is_dataclass(kind):
        return _made(kind, value, where)
    origin, inner = get_origin(kind), get_args(kind)
    if origin in (Union, types.UnionType):
        (some,) = (k for k in inner if k is not type(None))
        return None if value is None else typed(some, value, where)
    if origin is Literal:
        if not isinstance(value, str) or value not in inner:
            raise _misfit(where, value, f"one of {', '.join(map(str, inner))}")
        return value
    if origin is tuple:
        return _tuple(inner, value, where)
    if kind is float:
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise _misfit(where, value, "a finite number")
        return float(value)
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise _misfit(where, value, {"str": "a text", "int": "a whole number"}.get(kind.__name__, kind.__name__))
    return value


def _tuple(inner: tuple[Any, ...], value: Any, where: str) -> tuple[Any, ...]:
    if not isinstance(value, list):
        raise _misfit(where, value, "a list")
    kinds = [inner[0]] * len(value) if len(inner) == 2 and inner[1] is Ellipsis else list(inner)
    if len(kinds) != len(value):
        raise _misfit(where, value, f"{len(kinds)} values")
    return tuple(typed(k, v, f"{where}[{i}]") for i, (k, v) in enumerate(zip(kinds, value, strict=True)))


def _made(kind: Any, value: Any, where: str) -> Any:
    if not isinstance(value, dict):
        raise _misfit(where, value, "an object")
    hints = get_type_hints(kind)
    for field in fields(kind):
        if field.name not in value:
            raise InputError(f"{where} has no {field.name!r}; diagnose again")
    return kind(**{f.name: typed(hints[f.name], value[f.name], f"{where}.{f.name}") for f in fields(kind)})


def _misfit(where: str, value: Any, expected: str) -> InputError:
    text = repr(value)
    return InputError(f"{where} is {text if len(text) < 60 else text[:57] + '...'}, expected {expected}")
