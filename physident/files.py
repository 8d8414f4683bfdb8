"""Reading and writing texts and JSON objects: of bounded size, and whole or not at all."""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from physident.errors import InputError
from physident.outputs import write_with

LARGEST = 1e150  # of a number in a file: its square is finite
VERSION = "0.1.0"  # of this program, written into every file it makes


def read_text(path: str | Path, limit: int, expected: str) -> str:
    """The text of a UTF-8 file of at most ``limit`` bytes; raises InputError, saying what was ``expected``."""
    try:
        status = os.stat(path)
        size = status.st_size
        if not (stat.S_ISREG(status.st_mode) or stat.S_ISDIR(status.st_mode)):  # a pipe would be waited for without end
            raise InputError(f"{path}: is a device, a pipe or a socket; expected {expected}")
        if size > limit:
            raise InputError(f"{path}: {size} bytes, expected {expected} of at most {limit} bytes")
        with open(path, "rb") as stream:
            return stream.read(limit).decode("utf-8-sig")
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); expected {expected}") from None
    except ValueError as error:
        reason = "a name with a zero byte" if "null" in str(error) else "not UTF-8 text"
        raise InputError(f"{str(path)!r}: cannot be read ({reason}); expected {expected}") from None


def read_json(path: str | Path, limit: int, expected: str, *schemas: str) -> dict[str, Any]:
    """The object in a JSON file of at most ``limit`` bytes whose "schema" is one of ``schemas``; raises InputError, saying
    what was ``expected``, where the file cannot be read, is no JSON, or of another schema."""
    text = read_text(path, limit, expected)
    try:
        data = json.loads(text, parse_float=_number)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not valid JSON ({error}); expected {expected}") from None
    if not isinstance(data, dict) or data.get("schema") not in schemas:
        found = data.get("schema") if isinstance(data, dict) else type(data).__name__
        known = " or ".join(map(repr, schemas))
        raise InputError(f"{path}: schema is {found!r}, expected {known}: {expected}")
    try:
        _check_values(data)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return data


def _number(text: str) -> float:
    """A number, zero where its square would be."""
    value = float(text)
    return 0.0 if abs(value) < 1 / LARGEST else value


def _check_values(data: Any) -> None:
    """Raises InputError, naming the entry, for a number whose square is none, and for a text that no name can be."""
    waiting: list[tuple[tuple, Any]] = [((), data)]  # each with its place: the place of its parent, and its key
    while waiting:
        place, one = waiting.pop()
        if isinstance(one, dict):
            waiting += [((place, key), value) for key, value in one.items()]
            waiting += [((place, key), key) for key in one]
        elif isinstance(one, list):
            waiting += [((place, index), value) for index, value in enumerate(one)]
        elif isinstance(one, str):
            # the second half of a character alone stands for a byte of a path that is no UTF-8
            if "\0" in one or any("\ud800" <= sign <= "\udc7f" or "\udd00" <= sign <= "\udfff" for sign in one):
                raise InputError(
                    f"{_spelled(place)} is {one[:40]!r}, expected a text of whole characters without zero bytes"
                )
        elif isinstance(one, int | float) and not abs(one) <= LARGEST:
            raise InputError(
                f"{_spelled(place)} is {one if isinstance(one, float) else 'a number of many digits'}, expected a finite number below {LARGEST:g}"
            )


def _spelled(place: tuple) -> str:
    """The place of an entry, as covariance[0][0]."""
    if not place:
        return ""
    parent, key = _spelled(place[0]), place[1]
    return f"{parent}[{key}]" if isinstance(key, int) else f"{parent}.{key!s:.40}".lstrip(".")


@contextmanager
def naming(path: str | Path, what: str, remedy: str) -> Iterator[None]:
    """While the content of a file is taken apart: an InputError gets the file's name before it, and entries that are missing
    or of another type become one, which says that it is no complete ``what`` and the ``remedy``."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except (OverflowError, KeyError, TypeError, ValueError, AttributeError, RecursionError) as error:
        raise InputError(f"{path}: not a complete {what} ({type(error).__name__}: {error}); {remedy}") from None


def write_text(path: str | Path, text: str) -> None:
    """Write a text file, replacing what was there only once all of it is on disk."""
    write_with(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))


def write_json(path: str | Path, data: dict[str, Any]) -> None:
    """Write an object as JSON, whole or not at all; raises ValueError for a number that is not finite."""
    write_text(path, json_text(data))


def json_text(data: dict[str, Any]) -> str:
    """An object as the text of a JSON file; raises ValueError for a number that is not finite."""
    return json.dumps(data, indent=1, allow_nan=False) + "\n"
