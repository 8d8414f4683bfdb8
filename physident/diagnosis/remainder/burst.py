"""The times that hold much of a residual: something happened then, whatever the joint's state was."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.effects.contact import PIECE

Array = NDArray[np.float64]
LONGEST = 60  # half seconds: what lasts longer in a recording of an hour is no moment
WITHIN = 0.5  # of the rows of its recording, at most: what is large for longer is that recording, and no moment of it
MUCH = 1 / 3  # of the power, at least, all together
PART = 0.1  # of the power, at least, each
MOST = 4  # times that are told
MOSTLY = 0.5  # of a burst
CALM = 2.0  # times the power of the rest of a recording, at most
CERTAIN = 0.01  # how often noise of one size has a burst somewhere


@dataclass(frozen=True, kw_only=True)
class Burst:
    """A ``share`` of a residual's power lies between ``start`` and ``end`` [s] of one ``recording`` (its name), in ``of_time``, a share of
    all rows; ``at_rest``: the joint stood or crept for most of it, with a torque that its friction can hold."""

    recording: str
    start: float
    end: float
    share: float
    of_time: float
    at_rest: bool = False


def bursts_in_words(bursts: Sequence[Burst]) -> str:
    """When most of a residual is found; empty where it has no such time."""
    if not bursts:
        return ""
    by_recording: dict[str, list[str]] = {}
    for one in sorted(bursts, key=lambda one: (one.recording, one.start)):
        by_recording.setdefault(one.recording, []).append(f"{one.start:.1f} and {one.end:.1f} s")
    when = ", and ".join(f"between {' and between '.join(times)} of {name}" for name, times in by_recording.items())
    why = (
        "the joint stood or crept then, and what holds it is friction of any size up to its level"
        if all(one.at_rest for one in bursts)
        else "see what happened then"
    )
    share, of_time = (100 * sum(values) for values in zip(*((b.share, b.of_time) for b in bursts), strict=True))
    return f"{share:.0f} % of it lies {when}, in {of_time:.0f} % of the time: {why}"


def bursts_of(
    residual: Array,
    time: Array,
    recording: NDArray[np.intp],
    names: Sequence[str],
    worth: float,
    resting: NDArray[np.bool_] | None = None,
) -> tuple[Burst, ...]:
    """The bursts of a residual (M,), the largest first: half a minute at most each, that hold a third of the power together at least.

    ``time`` (M,) [s] since each row's recording began, whose place among the ``names`` is ``recording`` (M,); ``worth``: how many independent
    samples the rows are; ``resting`` (M,): where the joint stands or creeps, held by no more than its friction. Of all runs of half seconds the one is taken whose own variance
    is the most likely beside that of the other rows of its recording, and then again among the rows that are left;
    noise of one size would make it once in a hundred times (F test, Bonferroni over as many runs of its length as there is room for).
    """
    total, each = max(float(residual @ residual), 1e-300), worth / len(residual)
    left, result = np.ones(len(residual), dtype=bool), list[Burst]()
    while len(result) < MOST:
        found = [_likeliest(residual, time, left & (recording == k), each) for k in np.unique(recording)]
        likely = [one for one in found if one is not None]
        if not likely:
            break
        _, rows = max(likely, key=lambda one: one[0])
        share, of = float(residual[rows] @ residual[rows]) / total, recording == recording[rows[0]]
        calm = left & ~of  # what happened in each recording is no measure of what the others are without it
        calm[np.concatenate([some for _, some in likely])] = False
        if share < PART or not _is_certain(residual, rows, np.flatnonzero(calm), each):
            break
        first, last = (PIECE * np.floor(time[rows[at]] / PIECE) for at in (0, -1))
        result.append(
            Burst(
                recording=names[int(recording[rows[0]])],
                start=float(first),
                end=float(min(last + PIECE, time[of][-1])),
                share=share,
                of_time=len(rows) / len(residual),
                at_rest=resting is not None
                and bool(residual[rows] ** 2 @ resting[rows] > MOSTLY * (residual[rows] @ residual[rows])),
            )
        )
        left[rows] = False
    if sum(one.share for one in result) < MUCH:
        return ()
    return tuple(sorted(result, key=lambda one: -one.share))


def _is_certain(residual: Array, rows: NDArray[np.intp], others: NDArray[np.intp], each: float) -> bool:
    """Whether some rows have a larger variance than others, if there are any, as noise of one size has once in a hundred times."""
    from scipy.stats import f

    if not len(others):
        return True
    ratio = np.mean(residual[rows] ** 2) / max(float(np.mean(residual[others] ** 2)), 1e-300)
    chance = float(f.sf(ratio, max(len(rows) * each, 1.0), max(len(others) * each, 1.0)))
    return chance * (len(rows) + len(others)) / len(rows) < CERTAIN


def _likeliest(
    residual: Array, time: Array, some: NDArray[np.bool_], each: float
) -> tuple[float, NDArray[np.intp]] | None:
    """Of the run of half seconds among ``some`` rows of a recording whose variance is the most likely to be another, larger one than that of the
    rest: how likely it is, the logarithm of the likelihood of two variances over that of one; and its rows. None where none is certain."""
    rows = np.flatnonzero(some)
    bins = (time[rows] / PIECE).astype(np.intp)
    power = residual[rows] ** 2
    if len(rows) < 2 or not power.any():
        return None
    counts, powers = (
        np.concatenate([[0.0], np.cumsum(np.bincount(bins, weights))])
        for weights in (np.full(len(rows), 1 / len(rows)), power / power.sum())
    )
    best: tuple[float, NDArray[np.intp]] | None = None
    for length in range(1, min(LONGEST + 1, len(counts))):
        p, s = counts[length:] - counts[:-length], np.minimum(powers[length:] - powers[:-length], 1 - 1e-12)
        larger = (p > 0) & (p <= WITHIN) & (s > p)
        p, s, places = p[larger], s[larger], np.flatnonzero(larger)
        likely = len(rows) * (-p * np.log(s / p) - (1 - p) * np.log((1 - s) / (1 - p)))
        if len(likely) and (best is None or likely.max() > best[0]):
            at = int(places[np.argmax(likely)])
            best = float(likely.max()), rows[(bins >= at) & (bins < at + length)]
    if best is None or not _is_certain(residual, best[1], np.setdiff1d(rows, best[1]), each):
        return None
    return best[0], _between_calms(residual, time, best[1], np.setdiff1d(rows, best[1]))


def _between_calms(residual: Array, time: Array, rows: NDArray[np.intp], others: NDArray[np.intp]) -> NDArray[np.intp]:
    """Of a run of rows the part of the most power between two times that are as calm as the ``others``: two pushes are no long one."""
    calm = CALM * float(np.mean(residual[others] ** 2))
    bins = (time[rows] / PIECE).astype(np.intp)
    bins -= bins[0]
    count = np.bincount(bins)
    quiet = np.bincount(bins, residual[rows] ** 2) <= calm * count
    long = np.flatnonzero(quiet[1:] & quiet[:-1])  # two half seconds at least
    quiet[:] = False
    quiet[long], quiet[long + 1] = True, True
    part = np.cumsum(quiet)[bins]
    powers = np.bincount(part, np.where(quiet[bins], 0.0, residual[rows] ** 2))
    return rows[(part == np.argmax(powers)) & ~quiet[bins]]
