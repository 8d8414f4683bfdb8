"""From a recording to signals: a uniform clock, velocity and acceleration, contiguous segments."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.large_arrays import blocks, empty, is_shared, joined_rows, release
from physident.processes import each
from physident.recordings.motion_smoothing import (
    MotionNoise,
    encoder_step,
    estimate_noise,
    pieces_of,
    smooth_piece,
    velocity_std,
)
from physident.recordings.recording import Recording
from physident.recordings.rests import Rests, fewest_samples, find_rests
from physident.recordings.rows import position_jumps, typical_step
from physident.recordings.signals import Filter, Signals

Array = NDArray[np.float64]


def prepare(recording: Recording, filter: Filter) -> Signals:
    """Signals of a recording: resampled to a uniform clock, with velocity and acceleration.

    Position, velocity and acceleration of each joint are the most likely motion (``smooth_motion``), whose noise is estimated
    from the recording. Gaps in time and jumps of position split the recording into segments. Raises InputError for currents
    without gains, a cutoff too high for the rate, or no segment long enough for the filter.
    """
    return _prepared(recording, filter, _most_likely)


def differentiate(recording: Recording, filter: Filter) -> Signals:
    """Signals as from ``prepare``, but with velocity and acceleration from positions alone, by local fits up to twice the
    filter's cutoff: for checks that doubt the measured velocity."""
    return _prepared(recording, filter, _differentiated)


def motion_noise(recording: Recording, filter: Filter) -> list[MotionNoise]:
    """The noise of each joint's positions and velocities, as ``prepare`` takes it in the longest part of a recording without gaps."""
    parts, rate = _parts(recording, filter)
    rows, clock = max(parts, key=lambda part: len(part[1]))
    measured, _, _, dq = _resampled(recording, rows, clock)
    return _noise(recording, measured, dq, rate)


def _prepared(recording: Recording, filter: Filter, uniform: Callable[..., Signals]) -> Signals:
    """The contiguous parts of a recording, each made ``uniform``, as one."""
    parts, rate = _parts(recording, filter)
    return _joined([uniform(recording, rows, clock, rate, filter) for rows, clock in parts], rate, recording)


def _parts(recording: Recording, filter: Filter) -> tuple[list[tuple[slice, Array]], float]:
    """The rows and the uniform clock of each contiguous part that is as long as the filter, and the clock's rate [Hz]."""
    step = typical_step(recording.time)
    rate = filter.rate or round(1 / step, 3)
    need, parts = len(filter.taps(rate)) / rate, []
    for rows in _contiguous(recording, step, filter):
        time = recording.time[rows]
        count = int((time[-1] - time[0]) * rate + 1e-6) + 1
        if filter.kept(count, rate):
            clock = empty(count)
            for some in blocks(count):
                clock[some] = time[0] + np.arange(some.start, some.stop) / rate
            parts.append((rows, clock))
    if not parts:
        raise InputError(
            f"{recording.source}: no part without gaps is as long as the filter ({need:.2g} s);"
            " use a higher cutoff or a better recording"
        )
    return parts, rate


def _most_likely(recording: Recording, rows: slice, clock: Array, rate: float, filter: Filter) -> Signals:
    """One contiguous part of a recording on a uniform clock, with the motion that its positions and velocities make most likely."""
    measured, torque, temperature, dq = _resampled(recording, rows, clock)
    speeds = [None] * recording.n if dq is None else list(dq.T)
    noise = _noise(recording, measured, dq, rate)
    q, v, a = (empty(measured.shape) for _ in range(3))

    def smooth(piece: slice) -> None:
        for j, speed in enumerate(speeds):
            q[piece, j], v[piece, j], a[piece, j] = smooth_piece(measured[:, j], speed, rate, noise[j], piece)
        release()

    each(smooth, pieces_of(len(clock)), shared=is_shared(q))
    fewest, stds = fewest_samples(rate, filter.cutoff), [velocity_std(rate, one) for one in noise]
    return Signals(
        clock, q, v, a, torque, temperature, rate=rate, cutoff=filter.cutoff,
        velocity_std=np.array(stds),
        rests=tuple(
            find_rests(q[:, j], v[:, j], one.position_range, std, fewest)
            for j, (one, std) in enumerate(zip(noise, stds, strict=True))
        ),
    )  # fmt: skip


def _noise(recording: Recording, q: Array, dq: Array | None, rate: float) -> list[MotionNoise]:
    """The noise of each joint's positions and velocities (N, n), on a uniform clock at ``rate`` [Hz]."""
    speeds = [None] * recording.n if dq is None else dq.T
    return [
        estimate_noise(position, speed, rate, encoder_step(recorded))
        for position, speed, recorded in zip(q.T, speeds, recording.q.T, strict=True)
    ]


def _differentiated(recording: Recording, rows: slice, clock: Array, rate: float, filter: Filter) -> Signals:
    """One contiguous part of a recording on a uniform clock, with the derivatives of its positions."""
    q, torque, temperature, _ = _resampled(recording, rows, clock)
    v, a = empty(q.shape), empty(q.shape)
    for some in blocks(len(q)):
        # a fit sees half a window on either side, so the values are those of the whole
        half = half_window(rate, 2 * filter.cutoff, len(q))
        around = slice(max(0, min(some.start, len(q) - 2 * half) - 2 * half), min(len(q), some.stop + 2 * half))
        inside = slice(some.start - around.start, some.stop - around.start)
        for target, order in ((v, 1), (a, 2)):
            target[some] = derivative(q[around], order, rate, 2 * filter.cutoff)[inside]
    return Signals(clock, q, v, a, torque, temperature, rate=rate, cutoff=filter.cutoff)


def _resampled(recording: Recording, rows: slice, clock: Array) -> tuple[Array, Array, Array | None, Array | None]:
    """Positions, torques and, where recorded, temperatures and velocities of some rows at the times of a clock."""
    time = recording.time[rows]

    def at(values: Array) -> Array:
        result = empty((len(clock), values.shape[1]))

        def fill(some: slice) -> None:
            wanted = clock[some]
            first = max(0, int(np.searchsorted(time, wanted[0], side="right")) - 1)
            near = slice(first, int(np.searchsorted(time, wanted[-1], side="left")) + 1)
            for j, column in enumerate(values[rows][near].T):
                result[some, j] = np.interp(wanted, time[near], column)
            release()

        each(fill, list(blocks(len(clock))), shared=is_shared(result))
        return result

    temperature = None if recording.temperature is None else at(recording.temperature)
    return at(recording.q), at(recording.torque), temperature, None if recording.dq is None else at(recording.dq)


def _joined(parts: Sequence[Signals], rate: float, recording: Recording) -> Signals:
    """The parts in sequence, each as one segment."""

    def joined(name: str) -> Array | None:
        arrays = [getattr(part, name) for part in parts]
        return None if arrays[0] is None else joined_rows(arrays)

    stds = [part.velocity_std for part in parts if part.velocity_std is not None]
    rests = [part.rests for part in parts if part.rests is not None]
    lengths = [len(part.time) for part in parts]
    time, q, v, a = (joined_rows([getattr(part, name) for part in parts]) for name in ("time", "q", "v", "a"))
    starts = tuple(int(s) for s in np.cumsum([0, *(len(part.time) for part in parts[:-1])]))
    return Signals(
        time,
        q,
        v,
        a,
        torque=joined("torque"),
        temperature=joined("temperature"),
        velocity_std=np.max(stds, axis=0) if stds else None,
        rests=tuple(Rests.joined([one[j] for one in rests], lengths) for j in range(q.shape[1])) if rests else None,
        starts=starts,
        rate=rate,
        cutoff=parts[0].cutoff,
        source=recording.source,
        origin=float(recording.time[0]),
        recording=recording.sha256,
        from_currents=recording.effort_kind == "current",
    )


def _contiguous(recording: Recording, step: float, filter: Filter) -> Sequence[slice]:
    """Slices of rows without a gap in time longer than a quarter of the cutoff's period, or a jump of position."""
    longest = max(5 * step, 0.25 / filter.cutoff)
    time = recording.time
    gaps = [
        rows.start + 1 + int(i)
        for rows in blocks(len(time) - 1)
        for i in np.flatnonzero(np.diff(time[rows.start : rows.stop + 1]) > longest)
    ]
    edges = sorted({0, *gaps, *position_jumps(recording.time, recording.q).tolist(), len(recording.time)})
    return [slice(a, b) for a, b in itertools.pairwise(edges) if b - a > 1]


def derivative(values: Array, order: int, rate: float, passband: float) -> Array:
    """Derivative of some order (N, ...) over time of uniform samples (N, ...) at ``rate`` [Hz], by local fits of fourth
    order over a window that passes ``passband`` [Hz]."""
    from scipy.signal import savgol_filter

    half = half_window(rate, passband, len(values))
    return np.asarray(savgol_filter(values, 2 * half + 1, polyorder=4, deriv=order, delta=1 / rate, axis=0))


def half_window(rate: float, passband: float, samples: int) -> int:
    """Samples on either side of the local fits of ``derivative`` to a number of samples."""
    passband = min(passband, 0.4 * rate)
    # half-width of a fourth-order fit with that passband: Schafer, "What is a Savitzky-Golay filter?" (2011), eq. 12
    half = max(3, round((5 * rate / (2 * passband) + 4.6) / 3.2))
    return min(half, (samples - 1) // 2)
