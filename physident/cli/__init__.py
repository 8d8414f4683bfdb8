"""The command line: one verb a file, each prints one type and writes one file."""

from __future__ import annotations

import importlib
import os
import sys
import warnings

import typer

# the matrices here are small: one thread is as fast, and threads that wait for a busy core cost ten times as much
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from physident.cli.app import app
from physident.errors import PhysidentError, PhysidentWarning

# typer builds on its own copy of click or on the real one, by version: the base of every usage error is found, not named
CommandLineError: type[Exception] = typer.BadParameter.__mro__[2]
VERBS = (  # in the order of --help
    "recordings.demo",
    "recordings.inspect",
    "models.identify",
    "models.validate",
    "models.compare",
    "diagnosis.diagnose",
    "diagnosis.report",
    "diagnosis.view",
    "models.base_parameters",
    "models.export",
    "models.payload",
    "models.drive_gains",
    "recordings.simulate",
    "recordings.design",
)
INTERRUPTED = 130  # the exit code of Ctrl-C
MAX_LINE = 800  # characters of a message
for _verb in VERBS:
    importlib.import_module(f"physident.cli.{_verb}")


def main() -> None:
    """Run the command line; exit code 0, 2 for input that cannot be used, 3 for a problem that was not solved."""
    for stream in (sys.stdout, sys.stderr):  # a terminal that lacks a sign shows its number
        stream.reconfigure(errors="backslashreplace")  # pyright: ignore[reportAttributeAccessIssue]
    sys.exit(run(sys.argv[1:]))


def run(arguments: list[str]) -> int:
    """Run one command and return its exit code; everything that goes wrong is one line on standard error.

    Warnings are shown after a success; beside an error there is nothing but its line.
    """
    held: list[str] = []

    def hold(message: Warning | str, category: type[Warning], filename: str, lineno: int, *_: object) -> None:
        known = issubclass(category, PhysidentWarning)
        held.append(
            f"warning: {message}" if known else f"warning: {category.__name__}: {message} ({filename}:{lineno})"
        )

    with warnings.catch_warnings():
        warnings.showwarning = hold
        warnings.simplefilter("always", PhysidentWarning)
        try:
            result = app(args=arguments or ["--help"], prog_name="physident", standalone_mode=False)
            if result == INTERRUPTED:  # typer takes Ctrl-C for an exit of its own
                raise KeyboardInterrupt
            for text in dict.fromkeys(held):
                _say(text)
            return result if isinstance(result, int) else 0
        except PhysidentError as error:
            _say(f"error: {error}")
            return error.exit_code
        except CommandLineError as error:
            _say(f"error: {error.format_message()}; see physident --help")  # pyright: ignore[reportAttributeAccessIssue]
            return 2
        except (typer.Abort, KeyboardInterrupt):
            _say("stopped; no file was left half written")
            return INTERRUPTED
        except BrokenPipeError:
            sys.stderr.close()
            return 0
        except OSError as error:
            _say(f"error: {error.filename or 'a file'}: {error.strerror or error}; expected a path that can be used")
            return 2
        except MemoryError:
            _say("error: not enough memory for these recordings; cut them into parts")
            return 2


def _say(text: str) -> None:
    """One line on standard error, whatever the text quotes: no control signs, nothing endless."""
    line = "".join(sign if sign.isprintable() else "?" for sign in " ".join(text.split()))
    if len(line) > MAX_LINE:
        line = f"{line[: MAX_LINE // 2]} ... {line[-MAX_LINE // 2 :]}"
    print(f"physident: {line}", file=sys.stderr)
