"""Which rows of raw channels are good: physically impossible ones are left out, with their number and the reason."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.recordings.channels import BadRow, Channels

Array = NDArray[np.float64]

MIN_DURATION = 2.0  # s: shorter than one swing of any arm's slow modes
MAX_STEP = 0.1  # s: no dynamics can be seen in fewer than ten rows a second
MAX_POSITION = 4 * np.pi  # rad: two turns either way, the widest range any arm's joint has
MAX_DEGREES = 1e4  # a larger position is a corrupt number, not an angle in degrees
ABSURD = {"position": 100.0, "velocity": 100.0, "effort": 1e5, "temperature": 1e3}
UNITS = {"position": "rad", "velocity": "rad/s", "effort": "N m or A", "temperature": "degrees C"}
MAX_SPEED = 20.0  # rad/s or m/s: faster than the fastest wrist of any arm; a larger step of position is a fault
MOST_ADDED = (
    4.0  # samples for each row: a log that lost three of four rows still has the rate of the rows that are left
)
MIN_RUN = 10  # rows: a shorter run between two impossible steps is a burst of bad rows


def good_rows(
    channels: Channels, source: str, rows: NDArray[np.intp] | None = None, rejected: Sequence[BadRow] = ()
) -> tuple[Channels, tuple[BadRow, ...]]:
    """The channels without the rows that are physically impossible, and these rows, each with its reason.

    Left out are values that are missing or absurdly large, rows where the clock stands or runs backwards, and short bursts
    between impossible steps of position. ``rows`` (N,) are the rows' numbers in the file, ``rejected`` rows that could not
    be read. Raises InputError for positions in degrees, a clock in milliseconds, under two seconds of good rows, and over
    half the rows bad.
    """
    time = channels.time
    rows = np.arange(1, len(time) + 1) if rows is None else rows
    _refuse_degrees(channels.q, source)
    reasons = _reasons(channels)
    keep = reasons == ""
    bad = [*rejected, *(BadRow(int(r), str(why)) for r, why in zip(rows[~keep], reasons[~keep], strict=True))]
    bad.sort(key=lambda row: row.row)
    if len(bad) > (total := len(time) + len(rejected)) / 2:
        raise InputError(
            f"{source}: {len(bad)} of {total} rows are bad (row {bad[0].row}: {bad[0].reason}); expected under half: check the"
            " columns and units"
        )
    _check_clock(time[keep], source)

    def kept(values: Array) -> Array:
        good = np.array(values[keep], dtype=float)
        good.setflags(write=False)
        return good

    kept_channels = Channels(
        time=kept(time),
        q=kept(channels.q),
        effort=kept(channels.effort),
        effort_kind=channels.effort_kind,
        dq=None if channels.dq is None else kept(channels.dq),
        temperature=None if channels.temperature is None else kept(channels.temperature),
    )
    return kept_channels, tuple(bad)


def typical_step(time: Array) -> float:
    """Step [s] of a clock (N,), N > 1: the median, or the mean where the rows cannot hold the rate of the median.

    Several loggers in one file write bursts, with rows microseconds apart. Where the median step would put more than
    ``MOST_ADDED`` samples in the place of one row, it is that of the bursts, so the mean of all steps that are no gap counts.
    """
    steps = np.diff(time)
    median = float(np.median(steps))
    connected = steps[steps <= max(MAX_STEP, 5 * median)]
    return median if connected.mean() <= MOST_ADDED * median else float(connected.mean())


def _reasons(channels: Channels) -> NDArray[np.object_]:
    """Why each row (N,) is left out; an empty text for a good row."""
    time, q = channels.time, channels.q
    reasons = np.full(len(time), "", dtype=object)
    finite = np.isfinite(time)
    values_by_name = {"position": q, "velocity": channels.dq, "effort": channels.effort}
    for name, values in (values_by_name | {"temperature": channels.temperature}).items():
        if values is not None:
            finite &= np.isfinite(values).all(axis=1)
            with np.errstate(invalid="ignore"):
                too_large = (np.abs(values) > ABSURD[name]).any(axis=1)
            reasons[too_large] = f"absurd {name} (above {ABSURD[name]:g} {UNITS[name]})"
    reasons[~finite] = "a value is missing or not finite"
    good = np.flatnonzero(reasons == "")
    reasons[good[_not_increasing(time[good])]] = "the clock stands or runs backwards"
    good = np.flatnonzero(reasons == "")
    reasons[good[_bursts(time[good], q[good])]] = f"between two jumps of position (above {MAX_SPEED:g} rad/s)"
    return reasons


def _refuse_degrees(q: Array, source: str) -> None:
    with np.errstate(invalid="ignore"):
        wide = np.abs(q)
        wide = wide[(wide < MAX_DEGREES).all(axis=1)]
    if len(wide) and np.mean((wide > MAX_POSITION).any(axis=1)) > 0.05:
        joint = int(np.argmax(np.median(wide, axis=0))) + 1
        value = np.median(wide[:, joint - 1])
        raise InputError(
            f"{source}: positions beyond 4 pi rad (joint {joint}: typically {value:.4g}); expected radians of the joints: convert degrees, or divide the positions of motors by their gear ratios"
        )


def _check_clock(time: Array, source: str) -> None:
    if len(time) < 2 or time[-1] - time[0] < MIN_DURATION:
        length = time[-1] - time[0] if len(time) else 0.0
        raise InputError(
            f"{source}: {length:.3g} s of good rows, expected at least {MIN_DURATION:g} s; is the clock in seconds?"
        )
    step = typical_step(time)
    if step > MAX_STEP:
        raise InputError(
            f"{source}: rows are {step:.4g} s apart, expected at most {MAX_STEP} s: is the clock in milliseconds? convert to seconds"
        )


def _not_increasing(time: Array) -> NDArray[np.intp]:
    """Indices outside the longest strictly increasing subsequence: the fewest rows whose removal repairs the clock."""
    if len(time) < 2 or (np.diff(time) > 0).all():
        return np.empty(0, dtype=np.intp)
    tails: list[float] = []
    ends: list[int] = []
    before = np.full(len(time), -1)
    for i, t in enumerate(time.tolist()):
        k = bisect_left(tails, t)
        before[i] = ends[k - 1] if k else -1
        tails[k : k + 1], ends[k : k + 1] = [t], [i]
    kept = np.zeros(len(time), dtype=bool)
    i = ends[-1]
    while i >= 0:
        kept[i] = True
        i = before[i]
    return np.flatnonzero(~kept)


def position_jumps(time: Array, q: Array) -> NDArray[np.intp]:
    """Rows k (sorted) where the step of position from row k-1 is faster than any arm can move."""
    if len(time) < 2:
        return np.empty(0, dtype=np.intp)
    step = np.diff(time)
    allowed = MAX_SPEED * np.maximum(step, typical_step(time))
    return np.flatnonzero((np.abs(np.diff(q, axis=0)) > allowed[:, None]).any(axis=1)) + 1


def _bursts(time: Array, q: Array) -> NDArray[np.intp]:
    """Rows of short runs between impossible steps of position."""
    jumps = position_jumps(time, q)
    if not len(jumps):
        return jumps
    runs = np.split(np.arange(len(time)), jumps)
    short = [run for run in runs if len(run) < MIN_RUN]
    return np.concatenate(short) if short else np.empty(0, dtype=np.intp)
