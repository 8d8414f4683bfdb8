"""The history of one parameter of one arm, from the data set of a fleet."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from physident.fleet.candidates import WORDS, words_of
from physident.fleet.dataset import read_rows
from physident.fleet.drift.warm_up import warmth

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class History:
    """One parameter of one arm over N recordings.

    ``day`` (N,) is the day of each since the year 1, ``change`` (N,) the change since the baseline in the parameter's ``unit``, ``std``
    (N,) its standard error, ``information`` (N,) what a unit of it explains and ``coupling`` (N, k) that with the candidate's
    other parameters; ``temperature`` (N,) [degC] and ``load`` (N,) [N m|N], NaN where they are not known, and ``warmth`` (N, 2), see
    ``warm_up``; ``found`` (N,) says where a recording alone shows that the parameter differs; ``baseline`` is the value that changes
    are added to.
    """

    arm: str
    parameter: str
    effect: str
    joint: int
    unit: str
    baseline: float
    day: Array
    change: Array
    std: Array
    information: Array
    coupling: Array
    temperature: Array
    load: Array
    warmth: Array
    found: NDArray[np.bool_]

    @property
    def candidate(self) -> tuple[str, str, int]:
        """What it is a parameter of: arm, effect and joint."""
        return self.arm, self.effect, self.joint

    @property
    def unit_text(self) -> str:
        """The unit as it is printed: nothing for a relative change."""
        return "" if self.unit == "1" else self.unit

    @property
    def words(self) -> str:
        """What it is, in words."""
        return words_of(self.effect, self.joint)


@dataclass(frozen=True)
class BrokenFile:
    """A file of a fleet that cannot be used, and why."""

    arm: str
    file: str
    reason: str


def histories(folder: Path, until: date | None = None) -> tuple[list[History], list[BrokenFile]]:
    """The histories in a fleet's folder up to a day, by arm, and its broken files; raises InputError for a folder without results."""
    groups: dict[tuple[str, str], list[dict]] = defaultdict(list)
    broken = []
    for row in read_rows(folder):
        if until is not None and row["day"] is not None and row["day"] > until:
            continue
        if row["error"] is not None:
            broken.append(BrokenFile(row["arm"], row["file"], row["error"]))
        elif row["effect"] in WORDS:
            groups[row["arm"], row["parameter"]].append(row)
    return [_history(rows) for rows in groups.values()], broken


def _history(rows: list[dict]) -> History:
    def column(name: str) -> Array:
        return np.array([np.nan if row[name] is None else row[name] for row in rows], dtype=float)

    first = rows[0]
    return History(
        arm=first["arm"], parameter=first["parameter"], effect=first["effect"], joint=first["joint"], unit=first["unit"],
        baseline=first["baseline"], day=np.array([row["day"].toordinal() for row in rows], dtype=float),
        change=column("change"), std=column("std"), information=column("information"),
        coupling=np.array([row["coupling"] for row in rows], dtype=float), temperature=column("temperature"),
        load=column("load"), warmth=warmth(rows), found=np.array([row["finding"] is not None for row in rows]),
    )  # fmt: skip
