"""The curves of a session: measured and predicted torques of all recordings, one after another on one clock."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor, build_regressor
from physident.errors import InputError
from physident.estimation.identify import prepare_moving
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter, Signals
from physident.robots.robot import Robot

Array = NDArray[np.float64]
PAUSE = 1.0  # s between the end of a recording and the start of the next one on the session's clock
MOTION_RATE = 25.0  # Hz of what moves in 3D: smooth to the eye


@dataclass(frozen=True, eq=False)
class Prediction:
    """One model's ``torque`` (M, n) [N m|N] in every row, and the part (M, n) of each of its ``effects``.

    It is NaN in rows of a joint that do not count.
    """

    name: str
    model: Model
    torque: Array
    effects: dict[str, Array]


@dataclass(frozen=True, eq=False, kw_only=True)
class SessionData:
    """Recordings on one clock.

    ``starts`` [s] and ``durations`` [s] are those of each recording; ``clock`` (P,) [s] and ``motion`` (P, n) [rad|m] are
    the arm's positions at about 25 Hz. ``time`` (M,) [s], ``measured`` torque [N m|N], ``q`` [rad|m] and ``v`` [rad/s|m/s]
    (M, n) are the filtered rows in motion, on which models are validated. Between rows that are not contiguous there is a
    row of NaN.
    """

    recordings: tuple[Recording, ...]
    starts: tuple[float, ...]
    durations: tuple[float, ...]
    clock: Array
    motion: Array
    time: Array
    measured: Array
    q: Array
    v: Array
    predictions: tuple[Prediction, ...]

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.measured.shape[1]

    def residual(self, prediction: Prediction) -> Array:
        """Measured minus predicted torque (M, n) [N m|N]."""
        return self.measured - prediction.torque


def gather(recordings: Sequence[Recording], models: Mapping[str, Model], robot: Robot, filter: Filter) -> SessionData:
    """Evaluate models on recordings, all through one filter.

    Raises InputError for different numbers of joints, and for recordings without motion.
    """
    for name, model in models.items():
        if model.robot.n != robot.n:
            raise InputError(
                f"model {name} has {model.robot.n} joints, robot {robot.name} has {robot.n}; expected models of one arm"
            )
    signals = prepare_moving(robot, recordings, filter)
    durations = tuple(r.duration for r in recordings)
    starts = tuple(float(s) for s in np.cumsum([0.0, *(d + PAUSE for d in durations[:-1])]))
    regressors = {n: _regressor(m, signals, filter) for n, m in (models or {"": Model(robot, (), np.zeros(0))}).items()}
    first = next(iter(regressors.values()))
    shift = np.array([start - s.origin for start, s in zip(starts, signals, strict=True)])
    q, v = (_at_rows(first, signals, name) for name in ("q", "v"))
    order = _order_with_breaks(first)
    motions = [_thinned_motion(s, shift[i]) for i, s in enumerate(signals)]
    rows = (first.time + shift[first.recording])[np.abs(order) - 1]
    time = np.where(order < 0, rows + 1 / first.kept_rate, rows)
    predictions = tuple(_prediction(name, models[name], r, order) for name, r in regressors.items() if name in models)
    return SessionData(
        recordings=tuple(recordings),
        starts=starts,
        durations=durations,
        clock=np.concatenate([clock for clock, _ in motions]),
        motion=np.concatenate([positions for _, positions in motions]),
        time=time,
        measured=_ordered(first.torque, order, first.counted),
        q=_ordered(q, order),
        v=_ordered(v, order),
        predictions=predictions,
    )


def moving_rms(values: Array, time: Array, window: float) -> Array:
    """Root mean square (M, n) of values (M, n) over a window [s] about each instant (M,) [s]; NaN values do not count."""
    known = np.isfinite(values)
    total = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(np.where(known, values, 0.0) ** 2, axis=0)])
    count = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(known, axis=0)])
    a, b = np.searchsorted(time, time - window / 2), np.searchsorted(time, time + window / 2, side="right")
    mean = np.maximum(total[b] - total[a], 0.0) / np.maximum(count[b] - count[a], 1)
    return np.where(known, np.sqrt(mean), np.nan)


def _regressor(model: Model, signals: Sequence[Signals], filter: Filter) -> Regressor:
    return build_regressor(model.robot, model.effects, signals, filter, theta=model.theta)


def _prediction(name: str, model: Model, regressor: Regressor, order: NDArray[np.intp]) -> Prediction:
    effect_of_column = np.array([column.effect for column in model.columns])
    effects = {
        effect: _ordered(
            regressor.predict(np.where(effect_of_column == effect, model.theta, 0.0)), order, regressor.counted
        )
        for effect in dict.fromkeys(effect_of_column.tolist())
    }
    return Prediction(name, model, _ordered(regressor.predict(model.theta), order, regressor.counted), effects)


def _order_with_breaks(regressor: Regressor) -> NDArray[np.intp]:
    """Indices of rows (from 1) in order of time; a negative index marks a break after that row."""
    gap = (np.diff(regressor.time) > 1.5 / regressor.kept_rate) | (np.diff(regressor.segment) != 0)
    ends = np.flatnonzero(gap)
    return np.insert(np.arange(1, len(regressor.time) + 1), ends + 1, -(ends + 1))


def _ordered(values: Array, order: NDArray[np.intp], counted: NDArray[np.bool_] | None = None) -> Array:
    """Values of rows in order, NaN in breaks and in rows that do not count."""
    values = values if counted is None else np.where(counted, values, np.nan)
    return np.where(order[:, None] < 0, np.nan, values[np.abs(order) - 1])


def _at_rows(regressor: Regressor, signals: Sequence[Signals], name: str) -> Array:
    """Position or velocity (M, n) at the regressor's rows."""
    result = np.empty((len(regressor.time), len(regressor.joints)))
    for index, one in enumerate(signals):
        rows = regressor.recording == index
        for j, column in enumerate(getattr(one, name).T):
            result[rows, j] = np.interp(regressor.time[rows], one.time, column)
    return result


def _thinned_motion(signals: Signals, shift: float) -> tuple[Array, Array]:
    """Instants (P,) [s] on the session's clock and positions (P, n) of a whole recording, at about 25 Hz."""
    step = max(1, round(signals.rate / MOTION_RATE))
    return signals.time[::step] + shift, signals.q[::step]


def spans(data: SessionData) -> Iterator[tuple[Recording, float, float]]:
    """Each recording with its start and end [s] on the session's clock."""
    for recording, start, duration in zip(data.recordings, data.starts, data.durations, strict=True):
        yield recording, start, start + duration
