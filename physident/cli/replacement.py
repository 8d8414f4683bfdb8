"""Which existing files a command may replace: those that this program wrote, and with --force any file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from physident.errors import InputError

# what the files of this program have near their start or end: JSON, figures and pages, sessions, exported models
MARKS = (
    b'"schema": "physident.',
    b'name="generator" content="physident',
    b"Software\0physident",
    b"(physident ",
    b">physident ",
    b"\n\tphysident",
    b"identified with physident",
    b"ahigjhdhjgegfgogehpfehpgchbhfhfg",  # physident_torque, as CasADi spells it
)
ENDS = 4096  # bytes looked at on either side
_FORCED: ContextVar[bool] = ContextVar("_FORCED", default=False)


@contextmanager
def replacing_any(forced: bool) -> Iterator[None]:
    """While a command runs that was given --force, or not."""
    token = _FORCED.set(forced)
    try:
        yield
    finally:
        _FORCED.reset(token)


def check_replacement(path: Path) -> None:
    """Raises InputError for a file that exists and that this program did not write, unless the command has --force."""
    if _FORCED.get() or not path.is_file() or not path.stat().st_size:
        return
    with path.open("rb") as stream:
        start = stream.read(ENDS)
        stream.seek(max(0, path.stat().st_size - ENDS))
        end = stream.read(ENDS)
    if not any(mark in part for mark in MARKS for part in (start, end)):
        why = "a table does not show who wrote it" if path.suffix == ".csv" else "physident did not write it"
        raise InputError(f"output {str(path)!r} exists and is kept, because {why}; choose another path, or add --force")
