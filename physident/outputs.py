"""Outputs: a file is written whole or not at all, a set of files together, and only regular files are replaced."""

from __future__ import annotations

import os
import signal
import stat
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path

from physident.errors import InputError

STANDARD_OUTPUT = ("-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1")
STOPPING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))


@dataclass(frozen=True)
class _Written:
    """A file that is complete, and waits for its place."""

    temporary: Path
    place: Path


_WAITING: ContextVar[list[_Written] | None] = ContextVar("_WAITING", default=None)


def is_standard_output(path: str | Path) -> bool:
    """Whether a path stands for standard output: ``-``, or one of the system's names for it."""
    return str(path) in STANDARD_OUTPUT


def check_target(path: str | Path) -> None:
    """Raises InputError where no regular file can be written at ``path``; leaves nothing there."""
    if is_standard_output(path):
        return
    target = _place(path)
    try:
        Path(_temporary(target)).unlink()
    except (OSError, ValueError) as error:
        raise _refused(path, error) from None


def write_with(path: str | Path, write: Callable[[Path], object]) -> None:
    """Let ``write`` fill a temporary file beside ``path``, then move it there; raises InputError where it cannot be.

    The temporary file keeps the ending of ``path``, which libraries take the format from, and is gone on any error. A
    symbolic link's target is written, and a file that is replaced keeps its mode. Within ``together`` the file is moved when
    that ends. ``-`` and ``/dev/stdout`` mean standard output.
    """
    if is_standard_output(path):
        _print_file(path, write)
        return
    place = _place(path)
    try:
        temporary = Path(_temporary(place))
        try:
            write(temporary)
            temporary.chmod(_mode(place))
            waiting = _WAITING.get()
            if waiting is None:
                temporary.replace(place)
            else:
                waiting.append(_Written(temporary, place))
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise _refused(path, error) from None


@contextmanager
def together() -> Iterator[None]:
    """While several results are written: all files are replaced at the end, or none where anything fails or interrupts."""
    if _WAITING.get() is not None:  # part of a larger set
        yield
        return
    waiting: list[_Written] = []
    token = _WAITING.set(waiting)
    try:
        yield
        with _uninterrupted():
            for written in waiting:
                try:
                    written.temporary.replace(written.place)
                except OSError as error:
                    raise _refused(written.place, error) from None
    finally:
        _WAITING.reset(token)
        for written in waiting:
            written.temporary.unlink(missing_ok=True)


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Signals that would stop the program wait until the files of a set are in their places."""
    if not hasattr(signal, "pthread_sigmask") or threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, STOPPING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _place(path: str | Path) -> Path:
    """The regular file that a path means, at the end of its symbolic links; raises InputError for anything else."""
    try:
        if os.path.islink(path) and not os.path.exists(path) and os.path.islink(os.path.realpath(path)):
            raise InputError(f"output {str(path)!r} is a symbolic link to itself; expected the path of a file to write")
        target = Path(os.path.realpath(path)) if os.path.islink(path) else Path(path)
        kind = os.stat(target).st_mode if os.path.exists(target) else None
    except (OSError, ValueError) as error:
        raise _refused(path, error) from None
    what = ""
    if kind is not None and stat.S_ISDIR(kind):
        what = "is a folder"
    elif not os.path.isdir(target.parent):
        what = f"lies in a folder that does not exist ({target.parent})"
    elif kind is not None and not stat.S_ISREG(kind):
        what = "is a device, a pipe or a socket"
    if what:
        raise InputError(f"output {str(path)!r} {what}; expected the path of a file to write")
    # for root every file is writable: the mode says what its owner wants
    if kind is not None and not (kind & 0o222 and os.access(target, os.W_OK)):
        raise InputError(f"output {str(path)!r} is read-only; choose another place, or make it writable")
    return target


def _mode(place: Path) -> int:
    """The mode of the file that is replaced, or that of a new file."""
    if place.exists():
        return stat.S_IMODE(place.stat().st_mode)
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


def _print_file(path: str | Path, write: Callable[[Path], object]) -> None:
    """Write a temporary file and copy it to standard output once it is complete."""
    with tempfile.TemporaryDirectory() as folder:
        temporary = Path(folder, "output")
        write(temporary)
        content = memoryview(temporary.read_bytes())
    try:
        while content:
            content = content[os.write(1, content) :]
    except BrokenPipeError:
        raise
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
