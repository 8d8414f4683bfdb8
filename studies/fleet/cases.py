"""The fleet of the study: 40 arms, 25 recordings each over two years, five arms that degrade."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import date, timedelta
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from plant import JOINTS, Arm, Course, State, write

Array = NDArray[np.float64]
ARMS, EACH, DAYS = 40, 25, 730
START = date(2024, 1, 1)
GROWTH = 0.0015  # of the whole a day, from the onset on
LOST_MOTION = 0.3  # rad: the whole of the lost motion; a tenth is 1.7 degrees
TILT = 0.3  # rad: the whole of the tilt
LOAD = 3.0  # kg


@dataclass(frozen=True)
class Case:
    """An arm that degrades: its number, the words that its cause must contain, the joint (from 1, 0 for the whole arm), and the day
    (from the start) on which it crosses a tenth of the whole."""

    arm: int
    cause: str
    joint: int
    onset: float
    crossing: float
    course: Course


def _only(joint: int, value: float, otherwise: float = 1.0) -> Array:
    result = np.full(JOINTS, otherwise)
    result[joint - 1] = value
    return result


def cases(schedules: list[Array], offset: int) -> list[Case]:
    """The five of the fleet of an ``offset`` of all seeds, at arms and days that are drawn once."""
    rng = np.random.default_rng(26 + offset)
    arms = rng.choice(ARMS, 5, replace=False).tolist()
    onset = [float(x) for x in rng.uniform(300, 500, 5)]
    tenth = 0.1 / GROWTH

    def grown(day: float, k: int) -> float:
        return max(0.0, GROWTH * (day - onset[k]))

    # the load is forgotten for a week in which the arm was recorded
    later = schedules[arms[3]]
    onset[3] = float(later[np.searchsorted(later, onset[3])]) - 2.0
    return [
        Case(arms[0], "friction of joint 2", 2, onset[0], onset[0] + tenth, lambda d: State(friction=_only(2, 1 + grown(d, 0)))),
        Case(arms[1], "torque constant of joint 3", 3, onset[1], onset[1] + tenth,
             lambda d: State(torque_constant=_only(3, 1 - grown(d, 1)))),
        Case(arms[2], "lost motion in the transmission of joint 2", 2, onset[2], onset[2] + tenth,
             lambda d: State(lost_motion=_only(2, LOST_MOTION * grown(d, 2), 0.0))),
        Case(arms[3], "payload", 0, onset[3], onset[3],
             lambda d: State(payload=LOAD if onset[3] <= d < onset[3] + 7 else 0.0)),
        Case(arms[4], "mounting", 0, onset[4], onset[4] + tenth, lambda d: State(tilt=(TILT * grown(d, 4), 0.0))),
    ]  # fmt: skip


def schedules(offset: int) -> list[Array]:
    """The days (25,) on which each arm is recorded."""
    rng = np.random.default_rng(27 + offset)
    return [np.sort(np.linspace(10, DAYS - 10, EACH) + rng.uniform(-8, 8, EACH)) for _ in range(ARMS)]


def temperature(day: float, arm: int, offset: int) -> float:
    """Temperature [degC] of an arm on a day: the season, the weather and the hall."""
    rng = np.random.default_rng([arm + offset, int(day), 3])
    return float(22 + 6 * np.sin(2 * np.pi * (day - 110) / 365) + rng.normal(0, 2.5) + arm % 4)


def write_fleet(folder: Path, offset: int) -> list[Case]:
    """Write all recordings as ``arm_07/2024-05-01.parquet`` and return the arms that degrade."""
    plans = schedules(offset)
    chosen = cases(plans, offset)
    for number in range(ARMS):
        arm = Arm.drawn(number + offset)
        course = next((case.course for case in chosen if case.arm == number), lambda _: State())
        for day in plans[number].tolist():
            name = START + timedelta(days=int(day))
            seed = 1000 * (number + offset) + int(day)
            columns = arm.recording(course(day), temperature(day, number, offset), seed)
            write(folder / f"arm_{number:02d}" / f"{name}.parquet", columns)
    return chosen
