"""The short time that holds much of a residual: something happened then, whatever the joint's state was."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.effects.contact import PIECE

Array = NDArray[np.float64]
SHORT = 0.1  # of all rows, at most
LONGEST = 20  # half seconds: what lasts longer in a recording of an hour is no moment
MUCH = 1 / 3  # of the power, at least
MOSTLY = 0.5  # of a burst
CERTAIN = 0.01  # how often noise of one size has a burst somewhere


@dataclass(frozen=True, kw_only=True)
class Burst:
    """A ``share`` of a residual's power lies between ``start`` and ``end`` [s] of one ``recording`` (its name), in ``of_time``, a share of
    all rows; ``at_rest``: the joint stood or crept for most of it."""

    recording: str
    start: float
    end: float
    share: float
    of_time: float
    at_rest: bool = False

    def __str__(self) -> str:
        when = f"between {self.start:.1f} and {self.end:.1f} s of {self.recording}"
        why = (
            "the joint stood or crept then, and what holds it is friction of any size up to its level"
            if self.at_rest
            else "see what happened then"
        )
        return f"{100 * self.share:.0f} % of it lies {when}, in {100 * self.of_time:.0f} % of the time: {why}"


def burst_of(
    residual: Array,
    time: Array,
    recording: NDArray[np.intp],
    names: Sequence[str],
    worth: float,
    resting: NDArray[np.bool_] | None = None,
) -> Burst | None:
    """The burst of a residual (M,), if it has one: a tenth of the time, and ten seconds, at most that hold a third of the power at least.

    ``time`` (M,) [s] since each row's recording began, whose place among the ``names`` is ``recording`` (M,); ``worth``: how many independent
    samples the rows are; ``resting`` (M,): where the joint stands or creeps. Of all runs of half seconds the one is taken whose own variance is the most likely beside that of all other rows;
    noise of one size would make it once in a hundred times (F test, Bonferroni over as many runs of its length as there is room for).
    """
    from scipy.stats import f

    found = [
        one
        for index in np.unique(recording)
        if (one := _likeliest(residual, time, np.flatnonzero(recording == index), names[int(index)])) is not None
    ]
    if not found:
        return None
    _, best = max(found, key=lambda one: one[0])
    ratio = best.share / best.of_time * (1 - best.of_time) / max(1 - best.share, 1e-12)
    chance = float(f.sf(ratio, max(best.of_time * worth, 1.0), max((1 - best.of_time) * worth, 1.0)))
    if best.share < MUCH or chance / best.of_time >= CERTAIN:
        return None
    of_it = (recording == names.index(best.recording)) & (time >= best.start) & (time <= best.end)
    return replace(best, at_rest=resting is not None and bool(resting[of_it].mean() > MOSTLY))


def _likeliest(residual: Array, time: Array, rows: NDArray[np.intp], name: str) -> tuple[float, Burst] | None:
    """The run of half seconds in a recording's ``rows`` whose variance is the most likely to be another, larger one, and how likely it is:
    the logarithm of the likelihood of two variances over that of one, a row's share of it."""
    total, best = max(float(residual @ residual), 1e-300), None
    bins = (time[rows] / PIECE).astype(np.intp)
    parts, powers = (
        np.concatenate([[0.0], np.cumsum(np.bincount(bins, weights))])
        for weights in (np.full(len(rows), 1 / len(residual)), residual[rows] ** 2 / total)
    )
    for length in range(1, min(LONGEST + 1, len(parts))):
        p, s = parts[length:] - parts[:-length], np.minimum(powers[length:] - powers[:-length], 1 - 1e-12)
        larger = (p > 0) & (p <= SHORT) & (s > p)
        p, s, places = p[larger], s[larger], np.flatnonzero(larger)
        likely = -p * np.log(s / p) - (1 - p) * np.log((1 - s) / (1 - p))
        if len(likely) and (best is None or likely.max() > best[0]):
            at = int(np.argmax(likely))
            start = PIECE * float(places[at])
            end = min(start + PIECE * length, float(time[rows[-1]]))
            best = (
                float(likely[at]),
                Burst(recording=name, start=start, end=end, share=float(s[at]), of_time=float(p[at])),
            )
    return best
