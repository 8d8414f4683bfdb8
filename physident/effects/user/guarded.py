"""The code of effects from outside of the package, called so that its faults are one line and change nothing else."""

from __future__ import annotations

import functools
import traceback
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from physident.effects.effect import Array, Effect
from physident.errors import InputError
from physident.recordings.signals import Signals
from physident.robots.robot import Robot

ARRAYS = ("time", "q", "v", "a", "torque", "temperature", "links", "rotors", "load", "motor")
LARGEST = 1e50  # N m|N a unit of a parameter: the squares of larger ones have no sum


def guard(effect: type[Effect]) -> None:
    """Let the methods of a class that compute torque see signals that they cannot write to, and raise InputError where they fail or
    give other values than one finite number for each entry and instant."""
    for name, check in (("values", _check_values), ("torque_at", None)):
        method = getattr(effect, name)
        if method is not getattr(Effect, name) and not hasattr(method, "unguarded"):
            setattr(effect, name, _guarded(method, check))


def _guarded(
    method: Callable[..., Any], check: Callable[[Effect, Robot, Signals, Any], str | None] | None
) -> Callable[..., Array]:
    @functools.wraps(method)
    def call(self: Effect, robot: Robot, signals: Signals, *rest: Any) -> Array:
        try:
            with np.errstate(all="ignore"):
                found = method(self, robot, read_only(signals), *rest)
        except InputError:
            raise
        except Exception as error:
            where = line_of(error, Path(self.origin))
            raise InputError(
                f"{self.origin}: {where}{self.name}.{method.__name__} fails: {type(error).__name__}: {error};"
                " correct it, and try it with physident.testing.check_effect"
            ) from None
        wrong = check(self, robot, signals, found) if check else None
        if wrong:
            raise InputError(f"{self.origin}: {self.name}.{method.__name__} gives {wrong}")
        return found

    call.unguarded = method  # pyright: ignore[reportAttributeAccessIssue]
    return call


def read_only(signals: Signals) -> Signals:
    """The same signals, in arrays that cannot be written to: they belong to all effects."""
    views = {name: given.view() for name in ARRAYS if (given := getattr(signals, name)) is not None}
    for view in views.values():
        view.flags.writeable = False
    return replace(signals, **views)


def _check_values(effect: Effect, robot: Robot, signals: Signals, found: Any) -> str | None:
    """What is wrong with the values of an effect, and what was expected; None where nothing is."""
    expected = (len(effect.pattern(robot)), len(signals.time))
    if not isinstance(found, np.ndarray) or found.dtype.kind not in "fiub":
        kind = f"an array of {found.dtype}" if isinstance(found, np.ndarray) else f"a {type(found).__name__}"
        return f"{kind}; expected a NumPy array of real numbers"
    if found.shape != expected:
        return f"an array of shape {found.shape}; expected {expected}, a row for each entry of pattern and a column for each instant"
    if not found.size or np.abs(found).max() < LARGEST:
        return None
    at = int(np.flatnonzero(~(np.abs(found) < LARGEST).all(axis=0))[0])
    state = ", ".join(f"{name} = {np.array2string(getattr(signals, name)[at], precision=3)}" for name in "qva")
    return (
        f"values that are not finite or larger than {LARGEST:g}, where {state}; expected finite torques at every state"
    )


def line_of(error: BaseException, file: Path) -> str:
    """Where in a file an error arose: "line 3: "; empty where that is not known."""
    if isinstance(error, SyntaxError):
        return f"line {error.lineno}: " if error.lineno else ""
    frames = [
        frame for frame in traceback.extract_tb(error.__traceback__) if Path(frame.filename).resolve() == file.resolve()
    ]
    return f"line {frames[-1].lineno}: " if frames else ""
