"""The rests of a joint: stretches of a recording in which its position shows no displacement."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.large_arrays import blocks, picked

Array = NDArray[np.float64]
Index = NDArray[np.intp]
FEWEST = 3  # samples of a rest: two equal positions are a slow crossing as well
CERTAIN = 3.0  # standard deviations: a velocity beyond them shows motion
SHORTEST = 1 / 8  # of the period of a filter's cutoff: rows show no shorter rest


def fewest_samples(rate: float, cutoff: float) -> int:
    """How many samples, an odd number, a rest lasts at least at a ``rate`` [Hz] and a filter's ``cutoff`` [Hz]."""
    return max(FEWEST, 2 * int(SHORTEST * rate / cutoff / 2) + 1)


@dataclass(frozen=True, kw_only=True, eq=False)
class Rests:
    """K rests of one joint: the samples ``start`` to ``stop`` - 1 (K,) of each, and the velocities ``before`` and ``after``
    it (K,) [rad/s|m/s], NaN where the recording has none. ``held`` (K,) is the sign of the friction that holds the joint,
    where its torque is known to be all that friction can hold; None or NaN elsewhere."""

    start: Index
    stop: Index
    before: Array
    after: Array
    held: Array | None = None

    def part(self, start: int, stop: int) -> Rests:
        """The rests that touch some samples, numbered from the first of these; they may begin before it."""
        chosen = (self.stop > start) & (self.start < stop)
        return Rests(
            start=self.start[chosen] - start,
            stop=self.stop[chosen] - start,
            before=self.before[chosen],
            after=self.after[chosen],
            held=None if self.held is None else self.held[chosen],
        )

    def samples(self, count: int) -> tuple[Index, Index, Array]:
        """Of ``count`` samples those at rest: their index, which rest they are of, and how far (0 to 1) into it they are."""
        length = self.stop - self.start
        which = np.repeat(np.arange(len(length)), length)
        inside = np.arange(len(which)) - np.repeat(np.cumsum(length) - length, length)
        index = self.start[which] + inside
        kept = (index >= 0) & (index < count)
        return index[kept], which[kept], ((inside + 0.5) / length[which])[kept]

    def mask(self, count: int) -> NDArray[np.bool_]:
        """Which of ``count`` samples are at rest."""
        result = np.zeros(count, dtype=bool)
        result[self.samples(count)[0]] = True
        return result

    @staticmethod
    def joined(parts: list[Rests], lengths: list[int]) -> Rests:
        """The rests of parts of a recording that have some ``lengths``, laid end to end."""
        first = np.cumsum([0, *lengths[:-1]])
        return Rests(
            start=np.concatenate([part.start + at for part, at in zip(parts, first, strict=True)]),
            stop=np.concatenate([part.stop + at for part, at in zip(parts, first, strict=True)]),
            before=np.concatenate([part.before for part in parts]),
            after=np.concatenate([part.after for part in parts]),
        )


def find_rests(q: Array, v: Array, position_range: float, velocity_std: float, fewest: int = FEWEST) -> Rests:
    """The longest stretches in which positions (N,) [rad|m] of one joint stay within a range over any ``fewest`` samples, from
    the first velocity that shows no motion to the last.

    ``position_range`` [rad|m] is that of the errors of positions; ``velocity_std`` [rad/s|m/s] that of the errors of the
    velocities ``v`` (N,). The number of samples is odd. A joint that creeps towards its reversal leaves no step of its encoder
    in a few milliseconds either, but it moves; at rest a velocity may be beyond its errors now and then.
    """
    half = fewest // 2
    found = [_still(q, rows, position_range, half) for rows in blocks(len(q))]
    first, last = np.concatenate([one[0] for one in found]), np.concatenate([one[1] for one in found])
    apart = first[1:] - last[:-1] > 1  # a rest goes on across the seam of two blocks
    first, last = first[np.r_[True, apart]] if len(first) else first, last[np.r_[apart, True]] if len(last) else last
    start, stop = _without_creep(first - half, last + half + 1, v, CERTAIN * velocity_std)
    before = np.where(start > 0, picked(v, np.maximum(start - 1, 0)), np.nan)
    after = np.where(stop < len(q), picked(v, np.minimum(stop, len(q) - 1)), np.nan)
    return Rests(start=start, stop=stop, before=before, after=after)


def _without_creep(start: Index, stop: Index, v: Array, slow: float) -> tuple[Index, Index]:
    """The stretches from their first to their last sample that is not faster than ``slow``, those without any left out."""
    first, last = np.full(len(start), -1), np.full(len(start), -1)
    for rows in blocks(len(v)):
        still = rows.start + np.flatnonzero(np.abs(v[rows]) <= slow)
        here = np.arange(np.searchsorted(stop, rows.start, side="right"), np.searchsorted(start, rows.stop))
        a, b = np.searchsorted(still, start[here]), np.searchsorted(still, stop[here]) - 1
        here, a, b = here[b >= a], a[b >= a], b[b >= a]
        first[here] = np.where(first[here] < 0, still[a], first[here])
        last[here] = still[b]
    return first[first >= 0], last[first >= 0] + 1


def _still(q: Array, rows: slice, position_range: float, half: int) -> tuple[Index, Index]:
    """First and last (K,) middle of 2 ``half`` + 1 samples, in each run of middles among some rows, that stay within a range."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    around = slice(max(0, rows.start - half), min(len(q), rows.stop + half))
    some = q[around]
    still = (maximum_filter1d(some, 2 * half + 1) - minimum_filter1d(some, 2 * half + 1)) <= position_range
    inside = slice(max(rows.start, half) - around.start, min(rows.stop, len(q) - half) - around.start)
    centre = np.flatnonzero(still[inside]) + inside.start + around.start
    if not len(centre):
        return centre, centre
    breaks = np.flatnonzero(np.diff(centre) > 1)
    return centre[np.r_[0, breaks + 1]], centre[np.r_[breaks, -1]]
