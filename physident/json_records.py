"""Typed records from parsed JSON: every entry is checked against the type of the field it fills."""

from __future__ import annotations

import math
import types
from dataclasses import dataclass, fields, is_dataclass
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from physident.errors import InputError

LONGEST = 60  # characters of a wrong value that a message repeats


@dataclass(frozen=True)
class Range:
    """Limits of a number, for ``Annotated`` fields: ``low`` <= value <= ``high``."""

    low: float = -math.inf
    high: float = math.inf


NotNegative = Annotated[float, Range(0.0)]
Share = Annotated[float, Range(0.0, 1.0)]
Positive = Annotated[int, Range(1)]


@dataclass(frozen=True)
class RecordReader:
    """Turns parsed JSON into typed records; ``remedy`` ends every message, for example "identify it again"."""

    remedy: str

    def read(self, kind: Any, value: Any, where: str) -> Any:
        """``value`` as ``kind``: a dataclass, str, bool, int, finite float, Literal, tuple, Any, or one of these or None.

        ``where`` names the entry in messages; it is empty for the file itself. Keys that a dataclass does not have are
        ignored. Raises InputError, which names the entry, for a value of another type or outside its ``Range``.
        """
        if kind is Any:
            return value
        if is_dataclass(kind):
            return self._record(kind, value, where)
        origin, arguments = get_origin(kind), get_args(kind)
        if origin is Annotated:
            return self._in_range(self.read(arguments[0], value, where), arguments[1], where)
        if origin in (Union, types.UnionType):
            return self._union(arguments, value, where)
        if origin is Literal:
            if not isinstance(value, str) or value not in arguments:
                raise self._mismatch(where, value, f"one of {', '.join(map(str, arguments))}")
            return value
        if origin is tuple:
            return self._tuple(arguments, value, where)
        return self._plain(kind, value, where)

    def _union(self, kinds: tuple[Any, ...], value: Any, where: str) -> Any:
        """The kind that a text, a list or anything else can be, out of several; the first where none of them fits."""
        if value is None and type(None) in kinds:
            return None
        kinds = tuple(kind for kind in kinds if kind is not type(None))
        form = next((one for one in (str, list) if isinstance(value, one)), None)
        fitting = [kind for kind in kinds if _form(kind) is form]
        return self.read((fitting or kinds)[0], value, where)

    def _plain(self, kind: type, value: Any, where: str) -> Any:
        if kind is float:
            if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
                raise self._mismatch(where, value, "a finite number")
            return float(value)
        if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
            names = {str: "a text", int: "a whole number", bool: "true or false", dict: "an object"}
            raise self._mismatch(where, value, names.get(kind, kind.__name__))
        return value

    def _in_range(self, value: Any, limits: Range, where: str) -> Any:
        if not limits.low <= value <= limits.high:
            limited = math.isfinite(limits.high)
            expected = f"from {limits.low:g} to {limits.high:g}" if limited else f"of {limits.low:g} or more"
            raise self._mismatch(where, value, f"a number {expected}")
        return value

    def _tuple(self, arguments: tuple[Any, ...], value: Any, where: str) -> tuple[Any, ...]:
        if not isinstance(value, list):
            raise self._mismatch(where, value, "a list")
        any_length = len(arguments) == 2 and arguments[1] is Ellipsis
        kinds = [arguments[0]] * len(value) if any_length else list(arguments)
        if len(kinds) != len(value):
            raise self._mismatch(where, value, f"{len(kinds)} values")
        return tuple(self.read(k, v, f"{where}[{i}]") for i, (k, v) in enumerate(zip(kinds, value, strict=True)))

    def _record(self, kind: Any, value: Any, where: str) -> Any:
        if not isinstance(value, dict):
            raise self._mismatch(where, value, "an object")
        prefix = f"{where}." if where else ""
        hints = get_type_hints(kind, include_extras=True)
        for field in fields(kind):
            if field.name not in value:
                raise InputError(f"{where or 'the file'} has no {field.name!r}; {self.remedy}")
        return kind(**{f.name: self.read(hints[f.name], value[f.name], f"{prefix}{f.name}") for f in fields(kind)})

    def _mismatch(self, where: str, value: Any, expected: str) -> InputError:
        text = repr(value)
        shown = text if len(text) < LONGEST else f"{text[: LONGEST - 3]}..."
        return InputError(f"{where} is {shown}, expected {expected}; {self.remedy}")


def _form(kind: Any) -> type | None:
    """How JSON writes a kind: as text, as a list, or as anything else (None)."""
    origin = get_origin(kind)
    if kind is str or origin is Literal:
        return str
    return list if origin is tuple else None
