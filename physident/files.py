"""Writing a file whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from physident.errors import InputError


def write_text(path: str | Path, text: str) -> None:
    """Write a text file, replacing what was there only once all of it is on disk."""
    write_with(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))


def write_with(path: str | Path, write: Callable[[Path], object]) -> None:
    """Let ``write`` fill a temporary file beside ``path``, then move it there; raises InputError where it cannot be.

    The temporary file keeps the ending of ``path``, which libraries take the format from, and is gone on any error.
    """
    target = Path(path)
    if target.is_dir() or not target.parent.is_dir():
        what = "is a folder" if target.is_dir() else f"lies in a folder that does not exist ({target.parent})"
        raise InputError(f"output {str(path)!r} {what}; expected the path of a file to write")
    try:
        handle, name = tempfile.mkstemp(prefix=".physident-", suffix=target.suffix, dir=target.parent)
        os.close(handle)
        temporary = Path(name)
        try:
            write(temporary)
            temporary.chmod(0o666 & ~_umask())
            temporary.replace(target)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"output {str(path)!r} cannot be written ({error.strerror}); choose another place") from None


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
