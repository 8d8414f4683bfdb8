"""Which column of a table is what, by its name: the canonical header, and the names that a UR controller uses."""

from __future__ import annotations

import re
from collections.abc import Sequence

from physident.errors import InputError

CHANNELS = ("q", "dq", "tau", "current", "effort", "temperature")
CANONICAL = rf"(time)|({'|'.join(CHANNELS)})_([0-9]{{1,4}})"
NUMBER_SIGNS = ("_", "", ".", " ")  # between a name and its number
EXAMPLE_OF_NAMES = "--columns time=time,q=q,dq=dq,tau=tau"
# Universal Robots' real-time data exchange, whose columns are numbered from 0
OTHER_NAMES = {
    "timestamp": "time",
    "actual_q": "q",
    "actual_qd": "dq",
    "actual_current": "current",
    "joint_temperatures": "temperature",
}


def columns_of_header(names: Sequence[str], source: str) -> dict[str, tuple[int, ...]]:
    """Zero-based columns of each channel of ``time,q_1..q_n,dq_1..,tau_1..`` (or ``current_1..``), or of UR's names.

    Columns with other names are left out. Raises InputError for a name that appears twice and for a joint that is missing.
    """
    found: dict[str, dict[int, int]] = {}
    for index, name in enumerate(names):
        match = re.fullmatch(CANONICAL, name)
        if match is not None:
            _add(found, match[1] or match[2], int(match[3] or 1), index, name, source)
    canonical = set(found)
    for index, name in enumerate(names):
        stem, number = (name, "0") if name in OTHER_NAMES else name.rpartition("_")[::2]
        channel = OTHER_NAMES.get(stem)
        if channel is not None and channel not in canonical and re.fullmatch("[0-9]{1,4}", number):
            _add(found, channel, int(number) + 1, index, name, source)
    for channel, joints in found.items():
        if sorted(joints) != list(range(1, len(joints) + 1)):
            numbers = ", ".join(map(str, sorted(joints)))
            raise InputError(f"{source}: {channel} is given for joints {numbers}; expected exactly 1 to n")
    return {channel: tuple(joints[j] for j in sorted(joints)) for channel, joints in found.items()}


def _add(found: dict[str, dict[int, int]], channel: str, number: int, index: int, name: str, source: str) -> None:
    joints = found.setdefault(channel, {})
    if number in joints:
        raise InputError(f"{source}: column {name!r} appears twice, expected each once")
    joints[number] = index


def columns_named(names: Sequence[str], text: str, source: str) -> tuple[int, ...]:
    """Zero-based columns that a name declares: the column of that name, or those of NAME and a number, in its order.

    The number may follow directly or after a sign, as in Position1, q_1 or state.1. ``NAME[2:5]`` takes a range of these
    columns, counted from 0 and without its end. Raises InputError for a name without a column.
    """
    match = re.fullmatch(r"(.*?)(?:\[([0-9]{1,6})(?::([0-9]{1,6}))?\])?", text)
    assert match is not None
    places = next(filter(None, (_numbered(names, match[1], sign) for sign in NUMBER_SIGNS)), [])
    places = places or [index for index, name in enumerate(names) if name == match[1]]
    start = int(match[2] or 0)
    stop = len(places) if match[2] is None else int(match[3] or start + 1)
    if not places or stop > len(places) or stop <= start:
        stems = list(dict.fromkeys(re.sub(r"[_. ]?[0-9]{1,4}$", "", name) for name in names))
        shown = ", ".join(stems[:12]) + (f" and {len(stems) - 12} more" if len(stems) > 12 else "")
        what = f"{len(places)} columns {match[1]!r}, not {text!r}" if places else f"no column {text!r}"
        raise InputError(f"{source}: has {what}; its columns are {shown or 'without names'}; correct the columns")
    return tuple(places[start:stop])


def check_named_alike(names: Sequence[str], channel: str, columns: Sequence[int], source: str) -> None:
    """Raises InputError where declared columns of a channel have the canonical names of another: numbers that a model remembers are those of
    its own files, and a column of torques must not be taken for one of currents."""
    for index in columns:
        match = re.fullmatch(CANONICAL, names[index]) if index < len(names) else None
        stated = None if match is None else match[1] or match[2]
        # the name effort leaves open which of the two it is
        if stated not in (None, channel) and not (stated == "effort" and channel in ("tau", "current")):
            raise InputError(
                f"{source}: its header calls column {index} {names[index]!r}, but the declared or remembered columns take it for {channel};"
                f" declare this file's own columns, by name where its header is wrong: {EXAMPLE_OF_NAMES}"
            )


def _numbered(names: Sequence[str], stem: str, sign: str) -> list[int]:
    """Index of each column whose name is the stem, the sign and a number, in order of the numbers."""
    found = {
        int(match[1]): index
        for index, name in enumerate(names)
        if (match := re.fullmatch(re.escape(stem + sign) + "([0-9]{1,4})", name))
    }
    return [found[number] for number in sorted(found)]
