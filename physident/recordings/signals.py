"""Signals: motion and torque on a uniform clock, and the one filter that torque and regressor columns pass."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.large_arrays import BLOCK, blocks, empty, release, row_slices
from physident.recordings.rests import Rests
from physident.recordings.white_noise import white_noise

Array = NDArray[np.float64]
MAX_RATE = 1e5  # Hz, faster than any controller
MIN_CUTOFF = 0.01  # Hz: the filter then lasts 500 s, longer than any recording's motion
MOVING_SPEED = 0.02  # rad/s: the moving part lies between the first and last sample with any joint faster than this
MOVING_MARGIN = 0.2  # s
ROWS = 16  # filtered at once: more rows mean more products with zero, fewer rows more calls


@dataclass(frozen=True)
class Filter:
    """A linear-phase FIR low-pass and the decimation after it; torque and every regressor column pass the same one.

    ``cutoff`` [Hz] is where the gain is one half; ``rate`` [Hz] is the uniform clock recordings are resampled to, None
    for the recording's own rate (from the typical step of its clock).
    """

    cutoff: float = 5.0
    rate: float | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.cutoff) and self.cutoff >= MIN_CUTOFF):
            raise InputError(f"cutoff is {self.cutoff} Hz, expected {MIN_CUTOFF} Hz or more; 5 Hz suits most arms")
        if self.rate is not None and not 0 < self.rate <= MAX_RATE:
            raise InputError(f"rate is {self.rate} Hz, expected a positive frequency up to {MAX_RATE:g} Hz")

    def decimation(self, rate: float) -> int:
        """Number of samples for each kept row: at least four rows for each period of the cutoff remain."""
        return max(1, int(rate / (4 * self.cutoff)))

    def taps(self, rate: float) -> Array:
        """Coefficients (L,) of the filter at a sampling rate [Hz]: a Hamming-windowed sinc, unit gain at rest.

        It lasts five periods of the cutoff, which makes the transition two thirds of the cutoff wide. L - 1 is an even
        multiple of the decimation, so that the delay is whole rows.
        """
        if self.cutoff >= 0.4 * rate:
            raise InputError(
                f"cutoff {self.cutoff:g} Hz is too high for data at {rate:g} Hz; expected below {0.4 * rate:.3g} Hz"
            )
        return _low_pass(2 * self.delay(rate) * self.decimation(rate) + 1, self.cutoff, rate)

    def delay(self, rate: float) -> int:
        """Half the filter's length, in kept rows."""
        return math.ceil(2.5 * rate / (self.cutoff * self.decimation(rate)))

    def apply(self, values: Array, rate: float) -> Array:
        """Filtered and decimated (C, M) of contiguous samples (C, N): the rows whose whole window lies inside.

        Row k stands for sample (k + delay) * decimation; M = 0 where N is shorter than the filter.
        """
        taps, D = self.taps(rate), self.decimation(rate)
        kept = empty((len(values), self.kept(values.shape[-1], rate)))
        # ROWS kept rows at once are one matrix product with the taps, each row's shifted by the decimation
        block = np.zeros(((ROWS - 1) * D + len(taps), ROWS))
        for k in range(ROWS):
            block[k * D : k * D + len(taps), k] = taps
        for start in range(0, kept.shape[1], ROWS):
            rows = min(ROWS, kept.shape[1] - start)
            window = values[:, start * D : (start + rows - 1) * D + len(taps)]
            kept[:, start : start + rows] = window @ block[: window.shape[1], :rows]
            if start % BLOCK == 0:
                release()
        return kept

    def kept(self, samples: int, rate: float) -> int:
        """Number of rows that ``apply`` returns for a number of contiguous samples."""
        length = 2 * self.delay(rate) * self.decimation(rate) + 1
        return max(0, (samples - length) // self.decimation(rate) + 1)


def as_filter(filter: Filter | float | None) -> Filter:
    """A filter as it is, the filter of a cutoff [Hz], or the default filter; raises InputError for anything else."""
    if isinstance(filter, Filter):
        return filter
    if filter is None:
        return Filter()
    if isinstance(filter, bool) or not isinstance(filter, int | float | np.number):
        raise InputError(f"filter is {filter!r}, expected a cutoff [Hz], such as 8, or Filter(cutoff=8)")
    return Filter(float(filter))


@lru_cache(maxsize=64)
def _low_pass(length: int, cutoff: float, rate: float) -> Array:
    from scipy.signal import firwin

    taps = np.asarray(firwin(length, cutoff, fs=rate))
    taps.setflags(write=False)
    return taps


@dataclass(frozen=True, eq=False, repr=False)
class Signals:
    """Motion and torque of n joints at N instants, uniform in time within each contiguous segment.

    ``time`` (N,) [s], ``q`` [rad|m], ``v`` [rad/s|m/s], ``a`` [rad/s^2|m/s^2] (N, n); ``torque`` (N, n) [N m|N] or None;
    ``temperature`` (N, n) [degC] or None; ``starts`` the first sample of each segment; ``rate`` [Hz]; ``cutoff`` [Hz] of
    the filter that they will pass; ``origin`` [s] the recording's first time and ``recording`` its hash; ``from_currents`` where the
    torque was computed from motor currents.

    Of the sign of each joint's velocity: ``velocity_std`` (n,) [rad/s|m/s] is the standard deviation of ``v``, None where ``v``
    is exact; ``rests`` when each joint rests; ``transition`` (n,) [rad/s|m/s] the width over which the arm's own friction turns, None
    where it is dry.

    ``Model.refer`` adds the torques that a model predicts for the motion, which the columns of some effects depend on:
    ``links`` (10 n,) its link parameters and ``rotors`` (n,) [kg m^2|kg] its rotor inertias, ``load`` (N, n) the torque of the links' inertia and
    gravity, which the gears carry, ``motor`` (N, n) the torque of all but the measurement effects.
    """

    time: Array
    q: Array
    v: Array
    a: Array
    torque: Array | None = None
    temperature: Array | None = None
    starts: tuple[int, ...] = (0,)
    rate: float = math.nan
    cutoff: float = math.inf
    source: str = "signals"
    origin: float = 0.0
    recording: str = ""
    from_currents: bool = False
    velocity_std: Array | None = None
    rests: tuple[Rests, ...] | None = None
    transition: Array | None = None
    links: Array | None = None
    rotors: Array | None = None
    load: Array | None = None
    motor: Array | None = None

    @staticmethod
    def of_states(q: Array, v: Array, a: Array) -> Signals:
        """Unrelated states q, v, a (N, n): for evaluating a model pointwise, not for filtering."""
        arrays = [np.atleast_2d(np.asarray(x, dtype=float)) for x in (q, v, a)]
        if len({x.shape for x in arrays}) != 1:
            raise InputError(f"q, v, a have shapes {[x.shape for x in arrays]}, expected one shape (N, n)")
        return Signals(np.arange(len(arrays[0]), dtype=float), arrays[0], arrays[1], arrays[2])

    @cached_property
    def torque_noise(self) -> Array:
        """Standard deviation (n,) [N m|N] of the torque's white noise; zero where there is no torque."""
        return np.zeros(self.q.shape[1]) if self.torque is None else white_noise(self.torque)

    @property
    def segments(self) -> list[slice]:
        """The contiguous parts, as slices of samples."""
        ends = (*self.starts[1:], len(self.time))
        return [slice(start, end) for start, end in zip(self.starts, ends, strict=True)]

    @property
    def moving(self) -> tuple[float, float] | None:
        """Start and end [s] of the moving part: 0.2 s beyond the first and last sample with any |v| > 0.02; or None."""
        forward = list(blocks(len(self.v)))
        first = next((found[0] for rows in forward if len(found := self._fast(rows))), None)
        last = next((found[-1] for rows in reversed(forward) if len(found := self._fast(rows))), None)
        if first is None or last is None:
            return None
        return float(self.time[first] - MOVING_MARGIN), float(self.time[last] + MOVING_MARGIN)

    def _fast(self, rows: slice) -> NDArray[np.intp]:
        """Which of some samples move."""
        return rows.start + np.flatnonzero((np.abs(self.v[rows]) > MOVING_SPEED).any(axis=1))

    def blocks(self, pointwise: bool = True) -> list[slice]:
        """Slices of samples that a model can be evaluated on one by one: whole segments unless its effects are ``pointwise``."""
        return list(row_slices(self.segments)) if pointwise else self.segments

    def from_model(self, name: str) -> Array:
        """``links``, ``rotors``, ``load`` or ``motor``; raises InputError for signals without a model, see ``Model.refer``."""
        value = getattr(self, name)
        if value is None:
            raise InputError(f"{self.source}: an effect needs the model's {name}, expected signals from Model.refer")
        return value

    def __repr__(self) -> str:
        samples, n = self.q.shape
        has = ", ".join(name for name in ("torque", "temperature") if getattr(self, name) is not None) or "no torque"
        return f"Signals of {self.source}: {n} joints, {samples} samples at {self.rate:g} Hz in {len(self.starts)} segments, {has}"

    def at(self, chosen: NDArray[np.bool_]) -> Signals:
        """Some samples (N,), among them all of every rest, laid end to end: for evaluating a model pointwise."""
        before = np.concatenate([[0], np.cumsum(chosen)])

        def place(sample: NDArray[np.intp]) -> NDArray[np.intp]:
            inside = np.clip(sample, 0, len(chosen))
            return before[inside] + sample - inside  # a rest may begin before the first sample and end after the last

        def pick(x: Array | None) -> Array | None:
            return None if x is None else x[chosen]

        rests = self.rests and tuple(replace(r, start=place(r.start), stop=place(r.stop)) for r in self.rests)
        return replace(
            self, time=self.time[chosen], q=self.q[chosen], v=self.v[chosen], a=self.a[chosen], torque=pick(self.torque),
            temperature=pick(self.temperature), load=pick(self.load), motor=pick(self.motor), rests=rests, starts=(0,),
        )  # fmt: skip

    def part(self, samples: slice) -> Signals:
        """The samples of one slice, which must lie within a segment."""

        def cut(x: Array | None) -> Array | None:
            return None if x is None else x[samples]

        return replace(
            self, time=self.time[samples], q=self.q[samples], v=self.v[samples], a=self.a[samples],
            torque=cut(self.torque), temperature=cut(self.temperature), load=cut(self.load), motor=cut(self.motor),
            rests=None if self.rests is None else tuple(one.part(samples.start, samples.stop) for one in self.rests),
            starts=(0,),
        )  # fmt: skip
