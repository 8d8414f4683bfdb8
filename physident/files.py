"""Reading a text or a JSON object of bounded size; writing a file whole or not at all."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from physident.errors import InputError

VERSION = "0.1.0"  # of this program, written into every file it makes


def read_text(path: str | Path, limit: int, expected: str) -> str:
    """The text of a UTF-8 file of at most ``limit`` bytes; raises InputError, saying what was ``expected``."""
    try:
        size = os.stat(path).st_size
        if size > limit:
            raise InputError(f"{path}: {size} bytes, expected {expected} of at most {limit} bytes")
        with open(path, "rb") as stream:  # the size of what is no plain file is not known beforehand
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
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not valid JSON ({error}); expected {expected}") from None
    if not isinstance(data, dict) or data.get("schema") not in schemas:
        found = data.get("schema") if isinstance(data, dict) else type(data).__name__
        known = " or ".join(map(repr, schemas))
        raise InputError(f"{path}: schema is {found!r}, expected {known}: {expected}")
    return data


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


def check_target(path: str | Path) -> None:
    """Raises InputError where no file can be written at ``path``; leaves nothing there."""
    target = Path(path)
    if os.path.isdir(target) or not os.path.isdir(target.parent):
        what = "is a folder" if os.path.isdir(target) else f"lies in a folder that does not exist ({target.parent})"
        raise InputError(f"output {str(path)!r} {what}; expected the path of a file to write")
    try:
        Path(_temporary(target)).unlink()
    except (OSError, ValueError) as error:
        raise _refused(path, error) from None


def write_text(path: str | Path, text: str) -> None:
    """Write a text file, replacing what was there only once all of it is on disk."""
    write_with(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))


def write_json(path: str | Path, data: dict[str, Any]) -> None:
    """Write an object as JSON, whole or not at all; raises ValueError for a number that is not finite."""
    write_text(path, json_text(data))


def json_text(data: dict[str, Any]) -> str:
    """An object as the text of a JSON file; raises ValueError for a number that is not finite."""
    return json.dumps(data, indent=1, allow_nan=False) + "\n"


def write_with(path: str | Path, write: Callable[[Path], object]) -> None:
    """Let ``write`` fill a temporary file beside ``path``, then move it there; raises InputError where it cannot be.

    The temporary file keeps the ending of ``path``, which libraries take the format from, and is gone on any error.
    """
    check_target(path)
    target = Path(path)
    try:
        temporary = Path(_temporary(target))
        try:
            write(temporary)
            temporary.chmod(0o666 & ~_umask())
            temporary.replace(target)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise _refused(path, error) from None


def _temporary(target: Path) -> str:
    """An empty file beside the target, so that moving it there is one step; its name is as long as the target's."""
    handle, name = tempfile.mkstemp(suffix=target.suffix, prefix=f".{target.stem}-", dir=target.parent)
    os.close(handle)
    return name


def _refused(path: str | Path, error: Exception) -> InputError:
    reason = getattr(error, "strerror", None) or error
    return InputError(f"output {str(path)!r} cannot be written ({reason}); choose another place")


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
