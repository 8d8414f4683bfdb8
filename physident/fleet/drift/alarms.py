"""The arms of a fleet that change: when each first shows it, and which cause explains it best."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.fleet.drift.conditions import REFERENCE, Explained, explain
from physident.fleet.drift.forecast import Forecast, forecast
from physident.fleet.drift.history import BrokenFile, histories
from physident.fleet.drift.threshold import YEAR, Chance, chance_of, limit, shifts, windows

Array = NDArray[np.float64]
FALSE_ALARMS = 0.01  # for each arm and year: one in a hundred
MORE = 4.0  # squares that a parameter more must explain: 95 % of what one explains of noise


@dataclass(frozen=True, eq=False, kw_only=True)
class Alarm:
    """An arm that changes: the ``day`` of the recording that first shows it, and ``since`` when.

    ``words`` is the cause that explains best what the recordings until ``clearest`` show, where a shift is largest, ``effect`` and ``joint`` (from 1) where it acts; ``shown`` is the
    cause's parameter, which changed by ``shift`` with a standard error ``std`` in its unit; ``strength`` is how many standard
    deviations the first shift is, and ``limit`` what chance reaches. ``rivals`` are other causes that explain nearly as much.
    """

    arm: str
    day: date
    clearest: date
    since: date
    words: str
    effect: str
    joint: int
    shown: Explained
    shift: float
    std: float
    strength: float
    limit: float
    rivals: tuple[str, ...]
    trend: Forecast | None


@dataclass(frozen=True, eq=False)
class Course:
    """The largest shift of any parameter of an ``arm`` at N recordings after its reference, ``share`` (N,) of what chance reaches, and
    their ``day`` (N,), since the year 1."""

    arm: str
    day: Array
    share: Array


@dataclass(frozen=True, eq=False, kw_only=True)
class Drift:
    """What has changed in a fleet: ``alarms`` in order of their days, all ``histories``, the ``courses`` of the arms, ``young`` arms
    whose history is too short, and ``broken`` files. ``rate`` are the false alarms for each arm and year that the limits allow."""

    alarms: tuple[Alarm, ...]
    histories: tuple[Explained, ...]
    courses: tuple[Course, ...]
    young: tuple[str, ...]
    broken: tuple[BrokenFile, ...]
    rate: float

    @property
    def arms(self) -> list[str]:
        """The arms that are watched."""
        return sorted({one.history.arm for one in self.histories})

    def __repr__(self) -> str:
        count = len(self.arms)
        rows = [
            f"{count} arm{'s' * (count != 1)} watched, {len(self.alarms)} need attention; false alarms at most {self.rate:g} for each arm and year"
        ]
        rows += [f"  {one.day}  {one.arm}: {alarm_text(one)}" for one in self.alarms]
        if self.young:
            rows.append(f"{len(self.young)} arms have {REFERENCE} recordings or fewer and are not watched yet")
        if self.broken:
            rows.append(f"{len(self.broken)} files cannot be used: {self.broken[0].file}: {self.broken[0].reason}")
        return "\n".join(rows)


def alarm_text(alarm: Alarm) -> str:
    """The cause of an alarm with its size, its rivals and its trend, in a sentence."""
    unit = alarm.shown.history.unit_text
    text = f"{alarm.words}; {alarm.shown.history.parameter} {alarm.shift:+.3g} ± {1.96 * alarm.std:.2g}{unit and ' '}{unit} since about {alarm.since}"
    if alarm.trend is not None:
        text += f", in {alarm.trend.days:.0f} days {alarm.trend.value:+.3g} ({alarm.trend.low:.3g} to {alarm.trend.high:.3g})"
    return text + (f"; or {', '.join(alarm.rivals)}" if alarm.rivals else "")


def find_drift(folder: str | Path, rate: float = FALSE_ALARMS, until: date | None = None) -> Drift:
    """The arms in a fleet's folder that change since their own baselines, without what temperature and load explain.

    An arm is watched from its ninth recording on. ``rate`` is the number of false alarms allowed for each arm and year, over all
    its parameters together. Later recordings than those of the day ``until`` are not looked at. Raises InputError for a folder without results, and for a rate that is not between 0 and 1.
    """
    if not 0 < rate < 1:
        raise InputError(f"the rate of false alarms is {rate}, expected a number between 0 and 1 for each arm and year")
    every, broken = histories(Path(folder), until)
    by_parameter = defaultdict(list)
    for one in every:
        by_parameter[one.parameter].append(one)
    found = [one for group in by_parameter.values() for one in explain(group)]
    watched = {one.history.arm for one in found}
    chance = chance_of(found) if found else Chance(0.0, 1.0)
    arms = {arm: [one for one in found if one.history.arm == arm] for arm in sorted(watched)}
    moved = {arm: [_moved(one, chance, rate / len(own)) for one in own] for arm, own in arms.items()}
    alarms = [alarm for arm, own in arms.items() if (alarm := _alarm(own, moved[arm])) is not None]
    return Drift(
        alarms=tuple(sorted(alarms, key=lambda alarm: (alarm.day, alarm.arm))), histories=tuple(found),
        courses=tuple(_course(arm, moved[arm]) for arm in arms),
        young=tuple(sorted({one.arm for one in every} - watched)), broken=tuple(broken), rate=rate,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Moved:
    """The shift of a history, in standard deviations, at each recording after the reference, ``strength`` (N,), the ``window`` (N,) of
    recordings that shows it, and the ``limit`` that chance reaches."""

    history: Explained
    strength: Array
    window: NDArray[np.intp]
    limit: float


def _moved(one: Explained, chance: Chance, rate: float) -> _Moved:
    """The shift of a history, beside what chance reaches at a ``rate`` of false alarms a year."""
    day = one.history.day
    years = max(1.0, day[-1] - day[REFERENCE - 1]) / YEAR
    most = limit(len(day), chance, min(0.5, rate * years))
    size = np.abs(shifts(one.rest / one.size, one.mean_error / one.size))
    return _Moved(one, size.max(axis=0), np.array(windows(size.shape[-1]))[size.argmax(axis=0)], most)


def _course(arm: str, moved: Sequence[_Moved]) -> Course:
    """The largest shift of an arm at each of its recordings; parameters may be seen in some of them only."""
    largest: dict[float, float] = defaultdict(float)
    for one in moved:
        for day, strength in zip(one.history.history.day[REFERENCE:].tolist(), one.strength.tolist(), strict=True):
            largest[day] = max(largest[day], strength / one.limit)
    return Course(arm, np.array(sorted(largest)), np.array([largest[day] for day in sorted(largest)]))


@dataclass(frozen=True, eq=False)
class _Shift:
    """A shift beyond chance at the recording ``last`` of a history, in a ``window`` of recordings up to it."""

    history: Explained
    last: int
    window: int
    strength: float
    limit: float

    @property
    def excess(self) -> float:
        """The shift over what chance reaches."""
        return self.strength / self.limit


def _alarm(arm: Sequence[Explained], moved: Sequence[_Moved]) -> Alarm | None:
    """The change of an arm that chance does not explain; None without one.

    What first shows it may be weak or chance; its cause is that of the recordings that show it most clearly.
    """
    shifted = [
        _Shift(one.history, REFERENCE + at, int(one.window[at]), float(one.strength[at]), one.limit)
        for one in moved
        for at in np.flatnonzero(one.strength > one.limit).tolist()
    ]
    if not shifted:
        return None
    first = min(shifted, key=lambda shift: (shift.last, -shift.excess))
    clearest = max(shifted, key=lambda shift: shift.excess)
    rows = slice(clearest.last - clearest.window + 1, clearest.last + 1)
    groups: dict[tuple[str, str, int], list[Explained]] = defaultdict(list)
    for one in arm:
        if len(one.history.day) == len(clearest.history.history.day):
            groups[one.history.candidate].append(one)
    noise = float(np.median([one.noise for one in arm]))
    gains = {key: _gain(group, rows, noise) for key, group in groups.items()}
    cause = max(gains, key=lambda key: gains[key])
    near = [key for key in gains if key != cause and gains[key] > gains[cause] - MORE]
    shown = max(groups[cause], key=lambda one: abs(_mean(one, rows)[0]) / _mean(one, rows)[1])
    day = shown.history.day
    begun = _begin(shown, clearest.last)
    later = slice(begun, len(day))
    shift, std = _mean(shown, rows)
    return Alarm(
        arm=shown.history.arm, day=_date(first.history.history.day[first.last]), clearest=_date(day[clearest.last]),
        since=_date(day[begun]), words=shown.history.words, effect=cause[1], joint=cause[2], shown=shown, shift=shift, std=std,
        strength=first.strength, limit=first.limit, rivals=tuple(groups[key][0].history.words for key in near),
        trend=forecast(day[later], shown.rest[later], shown.size[later]),
    )  # fmt: skip


def _date(day: float) -> date:
    return date.fromordinal(int(day))


def _gain(group: Sequence[Explained], rows: slice, noise: float) -> float:
    """What a cause explains of some recordings, in squares of the noise, less what its parameters would explain of noise: of more
    than one, each must explain ``MORE`` in each recording."""
    rest = np.array([one.rest[rows] for one in group])
    total = 0.0
    for k in range(rest.shape[1]):
        M = np.array([one.history.coupling[rows][k] for one in group])
        total += float(rest[:, k] @ M @ rest[:, k]) / noise**2
    return total - MORE * (len(group) - 1) * rest.shape[1]


def _mean(one: Explained, rows: slice) -> tuple[float, float]:
    """Weighted mean of the rest over some recordings, and its standard error."""
    weight = 1 / one.size[rows] ** 2
    error = float(np.hypot(weight.sum() ** -0.5, one.mean_error))
    return float(np.average(one.rest[rows], weights=weight)), error


def _begin(one: Explained, last: int) -> int:
    """The first recording of the change that is seen at recording ``last``: where a step or a straight line explains the history best."""
    z, size, day, gains = one.rest[: last + 1] / one.size[: last + 1], one.size, one.history.day, []
    for k in range(REFERENCE, last + 1):
        shapes = (1 / size[k : last + 1], (day[k : last + 1] - day[k - 1]) / size[k : last + 1])
        gains.append(max(float(z[k:] @ shape) ** 2 / float(shape @ shape) for shape in shapes))
    return REFERENCE + int(np.argmax(gains))
