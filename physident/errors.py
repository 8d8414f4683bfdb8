"""One-line errors: what was found, what was expected, and what to do."""

import warnings


class PhysidentError(Exception):
    """Base of every error this package raises on purpose."""

    exit_code = 2


class InputError(PhysidentError):
    """A robot, recording, model or option that cannot be used as given (exit code 2)."""


class NotSolvedError(PhysidentError):
    """An estimation or design problem that ended without a certified solution (exit code 3)."""

    exit_code = 3


class PhysidentWarning(UserWarning):
    """Something the user should know about their data or robot; the result stands."""


def warn(message: str) -> None:
    """Warn the user in words, without the line of this package that found it."""
    warnings.warn_explicit(message, PhysidentWarning, "physident", 1)
