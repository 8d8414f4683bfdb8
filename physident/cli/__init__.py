"""The command line: one command a file.

``app`` is the application and what commands share, ``options`` the options that several commands have. The commands are in
``recordings``, ``models`` and ``diagnosis``, as ``physident --help`` lists them.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import signal
import sys
import warnings
from pathlib import Path

import typer

# the matrices are small: one thread is as fast, threads that wait for a busy core cost ten times as much, and the last
# digits of a sum depend on their number
os.environ.update(dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1"))

from physident.cli.app import COMMANDS, app
from physident.errors import PhysidentError, PhysidentWarning

# the base class of all usage errors: by version, typer uses its own copy of click or the real one
CommandLineError: type[Exception] = typer.BadParameter.__mro__[2]
INTERRUPTED = 130  # the exit code of Ctrl-C
MAX_LINE = 800  # characters of a message
for _folder, _names in COMMANDS.items():
    for _name in _names:
        importlib.import_module(f"physident.cli.{_folder}.{_name.replace('-', '_')}")


def main() -> None:
    """Run the command line; exit code 0, 2 for unusable input, 3 for a problem that was not solved."""
    _open_closed_streams()
    for stream in (sys.stdout, sys.stderr):  # a character that the terminal lacks is shown by its number
        stream.reconfigure(errors="backslashreplace")  # pyright: ignore[reportAttributeAccessIssue]
    for name in ("SIGTERM", "SIGHUP"):  # as Ctrl-C: temporary files are removed on the way out
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), _stop)
    code = run(sys.argv[1:])
    try:
        sys.stdout.flush()
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what is left in the buffer cannot be printed at exit either
        if code == 0 and not isinstance(error, BrokenPipeError):  # a reader that has seen enough is no error
            _print_line(f"error: standard output: {error.strerror}; expected a place that can be used")
            code = 2
    sys.exit(code)


def _open_closed_streams() -> None:
    """Streams that the caller closed (``>&-``) go nowhere, so that no file is opened in their place."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest free number: this one
            setattr(sys, name, os.fdopen(number, "w" if number else "r"))


def _stop(number: int, _: object) -> None:
    raise SystemExit(128 + number)


def run(arguments: list[str]) -> int:
    """Run one command and return its exit code; an error is one line on standard error.

    Warnings are collected and shown after a success only.
    """
    collected: list[str] = []

    def collect(message: Warning | str, category: type[Warning], filename: str, lineno: int, *_: object) -> None:
        if issubclass(category, PhysidentWarning):
            collected.append(f"warning: {message}")
        elif (
            "physident" in Path(filename).parts
        ):  # a library's own warning speaks of its code: here answers are checked
            collected.append(f"warning: {category.__name__}: {message} ({Path(filename).name}:{lineno})")

    with warnings.catch_warnings():
        warnings.showwarning = collect
        warnings.simplefilter("always", PhysidentWarning)
        try:
            result = app(args=arguments or ["--help"], prog_name="physident", standalone_mode=False)
            if result == INTERRUPTED:  # typer turns Ctrl-C into this result
                raise KeyboardInterrupt
            for text in dict.fromkeys(collected):
                _print_line(text)
            return result if isinstance(result, int) else 0
        except PhysidentError as error:
            _print_line(f"error: {error}")
            return error.exit_code
        except CommandLineError as error:
            context = getattr(error, "ctx", None)
            verb = context.command_path if context is not None else "physident"
            text = error.format_message().rstrip(".")  # pyright: ignore[reportAttributeAccessIssue]
            _print_line(f"error: {text}; see {verb} --help")
            return 2
        except (typer.Abort, KeyboardInterrupt):
            _print_line("stopped; no file was left half written")
            return INTERRUPTED
        except BrokenPipeError:
            return 0
        except OSError as error:
            place = error.filename or "standard output"  # the writing of files has its own message
            _print_line(f"error: {place}: {error.strerror or error}; expected a place that can be used")
            return 2
        except MemoryError:
            _print_line("error: not enough memory for these recordings; expected shorter ones, split them")
            return 2


def _print_line(text: str) -> None:
    """Print a text as one line on standard error, without control characters and of limited length."""
    line = "".join(sign if sign.isprintable() else "?" for sign in " ".join(text.split()))
    if len(line) > MAX_LINE:
        line = f"{line[: MAX_LINE // 2]} ... {line[-MAX_LINE // 2 :]}"
    with contextlib.suppress(OSError):  # nobody reads it
        print(f"physident: {line}", file=sys.stderr)
