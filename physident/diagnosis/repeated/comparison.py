"""New recordings beside control recordings of the same motion: what the model lacks is in both, and taken off.

A model that is wrong errs by some torque at each state of the arm. Where a motion is recorded again, the error that the control
shows along it is known to the noise, whatever its cause; the rest is what has changed, and the model's own parameters have no part
in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.repeated.same_motion import lag_of_repeat, refined_lag
from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor, build_regressor
from physident.effects.effect import Effect
from physident.estimation.dry_friction.row_weights import spread_rows
from physident.recordings.signals import Filter, Signals

Array = NDArray[np.float64]
PASSED = 0.8  # of half the lower rate: noise above it would fold back, and double what two recordings differ by
TAPS = 4  # samples at the lower rate on either side, over which that filter lasts
REPEATED = 0.8  # of the samples from a recording's first motion to its last; the rest is cut off, as what is begun or stopped earlier


@dataclass(frozen=True, kw_only=True, eq=False)
class Comparison:
    """New recordings, of which some repeat a motion of the control.

    ``signals`` are all of them, the model's error along the control taken off the torque of those that repeat one; ``partner`` has the
    index of the ``control`` recording of each, None where it has none, and ``lag`` [s] by how much that one's clock is ahead.
    ``untouched`` are the same signals with the torque as measured.
    """

    signals: tuple[Signals, ...]
    partner: tuple[int | None, ...]
    lag: tuple[float, ...]
    untouched: tuple[Signals, ...]
    control: tuple[Signals, ...]

    @property
    def compared(self) -> frozenset[int]:
        """The indices of the new recordings that repeat a motion of the control."""
        return frozenset(k for k, partner in enumerate(self.partner) if partner is not None)

    def of_compared(self) -> Comparison:
        """The same of the recordings that repeat a motion alone."""
        kept = sorted(self.compared)
        signals, partner, lag, untouched = (
            tuple(values[k] for k in kept) for values in (self.signals, self.partner, self.lag, self.untouched)
        )
        return replace(self, signals=signals, partner=partner, lag=lag, untouched=untouched)

    def spread_of_both(
        self, spread: Array, model: Model, effects: Sequence[Effect], filter: Filter, regressor: Regressor
    ) -> Array:
        """How little the sign of each joint's velocity is known in the rows of a regressor of the signals, from the ``spread`` (M, n) of
        the new recordings and, where they are compared, that of the control: standard deviation (M, n)."""
        result = spread.copy()
        for k in sorted(self.compared):
            own = [self.control[self.partner[k] or 0]]
            time = build_regressor(model.robot, [], own, filter, model=model).time
            rows = regressor.recording == k
            known = spread_rows(model.robot, effects, own, filter)
            before = [np.interp(regressor.time[rows] + self.lag[k], time, column) for column in known.T]
            result[rows] = np.where(np.array(before).T > 0, np.hypot(spread[rows], np.array(before).T), spread[rows])
        return result

    def taken_off(self, model: Model, filter: Filter) -> Array:
        """The torque (M, n) [N m|N] that was taken off the rows of a regressor of the signals; zero where nothing was."""
        return (
            build_regressor(model.robot, [], self.untouched, filter, model=model).torque
            - build_regressor(model.robot, [], self.signals, filter, model=model).torque
        )


def compare_with_control(model: Model, new: Sequence[Signals], control: Sequence[Signals]) -> Comparison:
    """The new recordings beside those of the ``control`` whose motions they repeat, each beside the one that is nearest.

    A recording with gaps, or of whose motion less than four fifths repeats one, is compared with none.
    """
    errors: dict[tuple[int, float], Array] = {}
    signals, untouched = list(new), list(new)
    partner: list[int | None] = [None] * len(new)
    lags = [0.0] * len(new)
    for i, one in enumerate(new):
        best = _nearest(one, control)
        if best is None:
            continue
        k, lag, rows = best
        if (k, one.rate) not in errors:
            errors[k, one.rate] = _error(model, control[k], one.rate)
        kept = one.part(rows)
        assert kept.torque is not None
        partner[i], lags[i], untouched[i] = k, lag, kept
        signals[i] = replace(kept, torque=kept.torque - _at(control[k].time, errors[k, one.rate], kept.time + lag))
    return Comparison(
        signals=tuple(signals),
        partner=tuple(partner),
        lag=tuple(lags),
        untouched=tuple(untouched),
        control=tuple(control),
    )


def _nearest(one: Signals, control: Sequence[Signals]) -> tuple[int, float, slice] | None:
    """The control recording whose positions are nearest, the lag [s] between the clocks, and the samples that repeat it."""
    best, least = None, np.inf
    for k, other in enumerate(control):
        lag = lag_of_repeat(one, other)
        if lag is None:
            continue
        lag = refined_lag(one, other, lag)
        first, last = np.searchsorted(one.time + lag, other.time[[0, -1]], "left")
        rows = slice(int(first), int(last))
        moving = _moving(one)
        if min(rows.stop, moving.stop) - max(rows.start, moving.start) < REPEATED * (moving.stop - moving.start):
            continue
        apart = float(np.mean((one.q[rows] - _at(other.time, other.q, one.time[rows] + lag)) ** 2))
        if apart < least:
            best, least = (k, lag, rows), apart
    return best


def _moving(signals: Signals) -> slice:
    """The samples from the first motion of a recording to the last, all where nothing moves."""
    if signals.moving is None:
        return slice(0, len(signals.time))
    first, last = np.searchsorted(signals.time, signals.moving)
    return slice(int(first), int(last))


def _error(model: Model, signals: Signals, rate: float) -> Array:
    """What a model leaves of the torque (N, n) [N m|N] at every sample, without what samples at a lower ``rate`` [Hz] cannot show."""
    from scipy.signal import firwin

    assert signals.torque is not None
    error = signals.torque - model.torque(signals)
    if rate > 0.9 * signals.rate:
        return error
    half = round(TAPS * signals.rate / rate)
    taps = np.asarray(firwin(2 * half + 1, PASSED * rate / 2, fs=signals.rate))
    padded = np.pad(error, ((half, half), (0, 0)), mode="edge")
    return np.apply_along_axis(np.convolve, 0, padded, taps, "valid")


def _at(time: Array, values: Array, wanted: Array) -> Array:
    """Values (N, n) at other instants (K,) [s]."""
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(time, values)(wanted))
