"""Which rows of raw channels are good: physically impossible ones are left out, with their number and the reason."""

from __future__ import annotations

import itertools
from bisect import bisect_left
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.large_arrays import blocks, empty, is_increasing, median
from physident.recordings.channels import BadRow, Channels

Array = NDArray[np.float64]

MIN_DURATION = 2.0  # s: shorter than one swing of any arm's slow modes
MAX_STEP = 0.1  # s: no dynamics can be seen in fewer than ten rows a second
SLOWEST = 0.45  # s: nobody logs an arm more slowly, but a clock may count in milliseconds
MAX_POSITION = 4 * np.pi  # rad: two turns either way, the widest range any arm's joint has
MAX_DEGREES = 1e4  # a larger position is a corrupt number, not an angle in degrees
ABSURD = {"position": 100.0, "velocity": 100.0, "effort": 1e5, "temperature": 1e3}
UNITS = {"position": "rad", "velocity": "rad/s", "effort": "N m or A", "temperature": "degrees C"}
MAX_SPEED = 20.0  # rad/s or m/s: faster than the fastest wrist of any arm; a larger step of position is a fault
MOST_ADDED = (
    4.0  # samples for each row: a log that lost three of four rows still has the rate of the rows that are left
)
MIN_RUN = 10  # rows: a shorter run between two impossible steps is a burst of bad rows
SHOWN = 1_000_000  # rows from which a mistake is put into words
REASONS = (
    "",
    *(f"absurd {name} (above {limit:g} {UNITS[name]})" for name, limit in ABSURD.items()),
    "a value is missing or not finite",
    "the clock stands or runs backwards",
    f"between two jumps of position (above {MAX_SPEED:g} rad/s)",
)


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
    _refuse_degrees(channels.q, source)
    reasons = _reasons(channels)
    left_out = np.flatnonzero(reasons)
    numbers = left_out + 1 if rows is None else rows[left_out]
    bad = [*rejected, *(BadRow(int(r), REASONS[why]) for r, why in zip(numbers, reasons[left_out], strict=True))]
    bad.sort(key=lambda row: row.row)
    if len(bad) > (total := len(time) + len(rejected)) / 2:
        raise InputError(
            f"{source}: {len(bad)} of {total} rows are bad (row {bad[0].row}: {bad[0].reason}); expected under half: check the"
            " columns and units"
        )
    count = len(time) - len(left_out)

    def kept(values: Array) -> Array:
        good, at = empty((count, *values.shape[1:])), 0
        for block in blocks(len(values)):
            some = values[block][reasons[block] == 0]
            good[at : at + len(some)] = some
            at += len(some)
        good.setflags(write=False)
        return good

    clock = kept(time)
    _check_clock(clock, source)
    kept_channels = Channels(
        time=clock,
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

    def steps() -> Iterator[Array]:
        return (np.diff(time[rows.start : rows.stop + 1]) for rows in blocks(len(time) - 1))

    middle = median(steps)
    longest, total, count = max(MAX_STEP, 5 * middle), 0.0, 0
    for some in steps():
        connected = some[some <= longest]
        total, count = total + float(connected.sum()), count + len(connected)
    mean = total / count if count else float("nan")
    return middle if mean <= MOST_ADDED * middle else mean


def _reasons(channels: Channels) -> NDArray[np.int8]:
    """Why each row (N,) is left out: the place of the reason in ``REASONS``, 0 for a good row."""
    time, q = channels.time, channels.q
    reasons = empty(len(time), np.int8)
    for rows in blocks(len(time)):
        reasons[rows] = _of_each_row(channels, rows)
    every = not reasons.any()
    good = slice(None) if every else np.flatnonzero(reasons == 0)
    if len(backwards := _not_increasing(time[good])):
        reasons[backwards if isinstance(good, slice) else good[backwards]] = len(REASONS) - 2
        good = np.flatnonzero(reasons == 0)
    if len(bursts := _bursts(time[good], q[good])):
        reasons[bursts if isinstance(good, slice) else good[bursts]] = len(REASONS) - 1
    return reasons


def _of_each_row(channels: Channels, rows: slice) -> NDArray[np.int8]:
    """The reasons that a row's own values give, of some rows."""
    finite = np.isfinite(channels.time[rows])
    reasons = np.zeros(len(finite), dtype=np.int8)
    given = (channels.q, channels.dq, channels.effort, channels.temperature)
    for place, (limit, values) in enumerate(zip(ABSURD.values(), given, strict=True), start=1):
        if values is not None:
            finite &= np.isfinite(values[rows]).all(axis=1)
            with np.errstate(invalid="ignore"):
                reasons[(np.abs(values[rows]) > limit).any(axis=1)] = place
    reasons[~finite] = len(ABSURD) + 1
    return reasons


def _refuse_degrees(q: Array, source: str) -> None:
    far = total = 0
    for rows in blocks(len(q)):
        with np.errstate(invalid="ignore"):
            wide = np.abs(q[rows])
            wide = wide[(wide < MAX_DEGREES).all(axis=1)]
        far, total = far + int((wide > MAX_POSITION).any(axis=1).sum()), total + len(wide)
    if far > 0.05 * total:
        some = np.abs(q[:: max(1, len(q) // SHOWN)])  # enough to name the joint
        with np.errstate(invalid="ignore"):
            some = some[(some < MAX_DEGREES).all(axis=1)]
        joint = int(np.argmax(np.median(some, axis=0))) + 1
        value = np.median(some[:, joint - 1])
        raise InputError(
            f"{source}: positions beyond 4 pi (joint {joint}: typically {value:.4g}); expected radians of the joints, metres of those that slide: convert degrees or millimetres, or divide the positions of motors by their gear ratios"
        )


def _check_clock(time: Array, source: str) -> None:
    if len(time) < 2 or time[-1] - time[0] < MIN_DURATION:
        length = time[-1] - time[0] if len(time) else 0.0
        raise InputError(
            f"{source}: {length:.3g} s of good rows, expected at least {MIN_DURATION:g} s; is the clock in seconds?"
        )
    step = typical_step(time)
    if MAX_STEP < step < SLOWEST:
        raise InputError(
            f"{source}: rows are {step:.4g} s apart ({1 / step:.2g} Hz), expected at most {MAX_STEP} s: record faster, 100 Hz or more"
        )
    if step > MAX_STEP:
        units = (("milliseconds", 1e3), ("microseconds", 1e6))
        unit = next((name for name, parts in units if step / parts <= MAX_STEP), "nanoseconds")
        raise InputError(
            f"{source}: rows are {step:.4g} s apart, expected at most {MAX_STEP} s: is the clock in {unit}? convert to seconds"
        )


def _not_increasing(time: Array) -> NDArray[np.intp]:
    """Indices outside the longest strictly increasing subsequence: the fewest rows whose removal repairs the clock."""
    if len(time) < 2 or is_increasing(time):
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
    typical, found = typical_step(time), []
    for rows in blocks(len(time) - 1):
        some = slice(rows.start, rows.stop + 1)
        allowed = MAX_SPEED * np.maximum(np.diff(time[some]), typical)
        far = (np.abs(np.diff(q[some], axis=0)) > allowed[:, None]).any(axis=1)
        found.append(np.flatnonzero(far) + rows.start + 1)
    return np.concatenate(found)


def _bursts(time: Array, q: Array) -> NDArray[np.intp]:
    """Rows of short runs between impossible steps of position."""
    jumps = position_jumps(time, q)
    if not len(jumps):
        return jumps
    edges = [0, *jumps.tolist(), len(time)]
    short = [np.arange(a, b) for a, b in itertools.pairwise(edges) if b - a < MIN_RUN]
    return np.concatenate(short) if short else np.empty(0, dtype=np.intp)
