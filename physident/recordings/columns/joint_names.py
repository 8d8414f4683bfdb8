"""Joints of a recording in the order of a robot, by their names and never by their position."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from physident.errors import InputError, did_you_mean, warn
from physident.recordings.channels import printable

MOST_SHOWN = 14  # names in a message: two arms of seven joints


def joint_order(names: Sequence[str], wanted: Sequence[str], source: str) -> list[int]:
    """Index in ``names`` of each ``wanted`` joint; other names are left out.

    Names are equal, or differ by one prefix that ends with a separator and is the same for all joints: "left_elbow_joint"
    is the robot's "elbow_joint", "fer_joint1" its "panda_joint1"; a warning then says so. Raises InputError where a joint
    is missing, and where two prefixes fit, as in a recording of two arms.
    """
    if len(set(names)) < len(names):
        twice = next(name for name in names if list(names).count(name) > 1)
        raise InputError(f"{source}: joint {twice!r} appears twice; expected each joint once")
    if set(wanted) <= set(names):
        return [list(names).index(name) for name in wanted]
    for endings in (list(wanted), _without_prefix(wanted)):
        prefixes = [prefix for prefix in _prefixes(names, endings[0]) if {prefix + e for e in endings} <= set(names)]
        if len(prefixes) > 1:
            shown = " and ".join(repr(prefix) for prefix in prefixes[:4])
            raise InputError(
                f"{source}: contains the joints of {len(prefixes)} arms (names that begin with {shown}); expected one arm:"
                " a description whose joints have the names of the recording, or the topic of one arm"
            )
        if prefixes:
            before = wanted[0].removesuffix(endings[0])
            warn(
                f"{source}: joints are matched by the ends of their names: {prefixes[0]!r} in the recording stands for"
                f" {before!r} in the description ({prefixes[0]}{endings[0]} is {wanted[0]})"
            )
            return [list(names).index(prefixes[0] + ending) for ending in endings]
    missing = [name for name in wanted if name not in names]
    near = did_you_mean(missing[0], names) if len(missing) < len(wanted) else ""  # all of them: another arm
    raise InputError(
        f"{source}: has no joint {listed(missing)}{near}; its joints are {listed(names)}; expected"
        " the robot's joints: choose the description of this arm, or declare the names in the robot's order (columns"
        ' "joints=NAME NAME ...")'
    )


def listed(names: Iterable[str]) -> str:
    """The first names in one line."""
    every = [printable(name) for name in names]
    return ", ".join(every[:MOST_SHOWN]) + (f" and {len(every) - MOST_SHOWN} more" if len(every) > MOST_SHOWN else "")


def _prefixes(names: Sequence[str], ending: str) -> list[str]:
    """What stands before an ending in the names that have it: nothing, or a text that ends with a separator."""
    found = [name.removesuffix(ending) for name in names if name.endswith(ending)]
    return sorted(prefix for prefix in set(found) if re.fullmatch(r"|.*[\W_]", prefix))


def _without_prefix(names: Sequence[str]) -> list[str]:
    """The names without the longest beginning up to a separator that all of them share."""
    shared = ""
    for match in re.finditer(r"[\W_]", names[0]):
        if len(names) > 1 and all(name[: match.end()] == names[0][: match.end()] != name for name in names):
            shared = names[0][: match.end()]
    return [name.removeprefix(shared) for name in names]
