"""One-line errors: what was found, what was expected, and what to do."""

import difflib
import warnings
from collections.abc import Iterable


class PhysidentError(Exception):
    """Base of every error this package raises on purpose."""

    exit_code = 2


class InputError(PhysidentError):
    """A robot, recording, model or option that cannot be used as given (exit code 2)."""


class NotSolvedError(PhysidentError):
    """An estimation or design problem that ended without a certified solution (exit code 3)."""

    exit_code = 3


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """The end of a message about an unknown name: the known one that is nearest, or that contains it; or nothing."""
    names = list(known)
    near = difflib.get_close_matches(str(name), names, n=1) or [one for one in names if name and str(name) in one]
    return f"; did you mean {near[0]!r}?" if near else ""


class PhysidentWarning(UserWarning):
    """Something the user should know about their data or robot; the result stands."""


def warn(message: str) -> None:
    """Warn the user in words, without the line of this package that found it."""
    warnings.warn_explicit(message, PhysidentWarning, "physident", 1)
