"""Which arm and which day a recording is of, from the end of its path."""

from __future__ import annotations

import re
from datetime import date, datetime
from pathlib import Path

from physident.errors import InputError
from physident.recordings.formats.read import ENDINGS

FIELDS = {"robot": r"(?P<robot>[^/]+)", "date": r"(?P<date>[^/]+?)"}
WILD = {"*": "[^/]*", "?": "[^/]"}


def pattern_of(by: str) -> re.Pattern[str]:
    """The pattern of a text such as "{robot}/{date}" or "{robot}_{date}/run*" for the end of each path, suffix aside.

    Raises InputError unless it names ``{robot}`` and ``{date}``, each once.
    """
    parts = re.split(r"(\{[^{}]*\}|[*?])", by)
    names = [part[1:-1] for part in parts if part.startswith("{")]
    if sorted(names) != ["date", "robot"]:
        raise InputError(f"--by is {by!r}, expected {{robot}} and {{date}}, each once, as in '{{robot}}/{{date}}'")
    ends = [FIELDS[part[1:-1]] if part.startswith("{") else WILD.get(part, re.escape(part)) for part in parts]
    return re.compile("(?:^|.*/)" + "".join(ends) + "$")


def arm_and_day(path: str, pattern: re.Pattern[str]) -> tuple[str, date]:
    """The arm and the day of a file by ``pattern_of`` some text; raises InputError for a path that does not fit."""
    ending = next((one for one in ENDINGS.split(", ") if path.lower().endswith(one)), "")
    stem = Path(path[: len(path) - len(ending)]).as_posix()
    found = pattern.match(stem)
    if found is None:
        raise InputError(f"{path}: does not fit --by; expected an end such as arm7/2026-03-01")
    try:
        return found["robot"], datetime.fromisoformat(found["date"]).date()
    except ValueError:
        raise InputError(f"{path}: {found['date']!r} is no date; expected one such as 2026-03-01 or 20260301") from None
