"""Reading a text of bounded size; writing a file whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from physident.errors import InputError


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
