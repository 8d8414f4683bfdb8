"""How much of the RMS on a held-out recording somebody would remove who knows the hidden torque."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

import physident as pid
from studies.open_world.bench import DEFAULT, DURATION, Bench
from studies.open_world.taken import Taken, bridged, torque_along
from tests.truth import HiddenEffect, Run

Array = NDArray[np.float64]
OPEN = 0.3  # of a row's surroundings: where a joint is stuck for longer, its torque is open and the row is not judged
LEAST = 0.05  # share of the rows of a joint below which nothing is said of it
PILOT_STEP = 4e-3  # s


@dataclass(frozen=True, eq=False)
class Oracle:
    """Reduction (n,) [%] of RMS, joint by joint, with the hidden torque known."""

    reduction: Array

    @property
    def joint(self) -> int:
        """Index of the joint that shows it most."""
        return int(np.argmax(self.reduction))

    @property
    def percent(self) -> float:
        """The reduction on that joint."""
        return float(self.reduction[self.joint])

    @staticmethod
    def of(hidden: Array, noise: Array) -> Oracle:
        """From RMS (n,) of the hidden torque and of what a model leaves of clean recordings, which are independent."""
        return Oracle(100 * (1 - 1 / np.sqrt(1 + (hidden / noise) ** 2)))


def strength(percent: float) -> float:
    """RMS of a hidden torque over that of the residual whose removal lowers the RMS by so much."""
    return float(np.sqrt(1 / (1 - percent / 100) ** 2 - 1))


def residual_rms(bench: Bench, model: pid.Estimate | pid.Model, taken: Sequence[Taken]) -> Array:
    """RMS (n,) [N m] of what a model leaves of recordings, where no joint is stuck."""
    known = model.model if isinstance(model, pid.Estimate) else model
    signals = [pid.prepare(t.recording, bench.filter) for t in taken]
    regressor = pid.build_regressor(bench.robot, known.effects, signals, bench.filter, theta=known.theta)
    judged = _judged(regressor, [(t.recording.time, t.stuck) for t in taken], bench.filter)
    judged |= judged.mean(axis=0) < LEAST  # a joint that hardly ever moves is judged at rest
    return _rms(regressor.torque - regressor.predict(known.theta), judged)


def hidden_rms(bench: Bench, taken: Sequence[Taken], refitted: bool) -> Array:
    """RMS (n,) [N m] of the hidden torque on the last recording, after the filter, where it is determined; ``refitted``: of
    what the ordinary model, fitted to the others - or to it alone - cannot imitate."""
    signals = [pid.prepare(t.alone, bench.filter) for t in taken]
    regressor = pid.build_regressor(bench.robot, pid.make_effects(DEFAULT), signals, bench.filter)
    judged = _judged(regressor, [(t.recording.time, ~np.isfinite(t.hidden)) for t in taken], bench.filter)
    last = regressor.recording == len(taken) - 1
    left = regressor.torque
    if refitted:
        fitted = judged & (~last[:, None] if len(taken) > 1 else True)
        left = left - regressor.predict(_imitation(regressor, fitted))
    return _rms(left[last], judged[last]) * (judged[last].mean(axis=0) >= LEAST)


def pilot(bench: Bench, hidden: HiddenEffect, seed: int, warmer: float, refitted: bool) -> Array:
    """RMS (n,) [N m] of an effect's torque along a plan that is followed exactly, as ``hidden_rms`` has it: a first guess."""
    motion = bench.world.motion(bench.arm, seed, DURATION)
    time = np.arange(0.0, motion.duration, PILOT_STEP)
    q, v, a = motion.states(time)
    run = Run(time, q, v, a, np.zeros_like(q), np.full_like(q, 25.0 + warmer), np.abs(v) < 1e-9)
    other = replace(bench.arm, effects=(*bench.arm.effects, hidden))
    torque = torque_along(bench.plant, other, run) - torque_along(bench.plant, bench.arm, run)
    recording = pid.Recording(time, q, bridged(torque), "torque", dq=v)
    return hidden_rms(bench, [Taken(recording, torque, ~np.isfinite(torque), "")], refitted)


def _imitation(regressor: pid.Regressor, rows: NDArray[np.bool_]) -> Array:
    """Parameters (p,) of the ordinary model that come nearest to a torque on some rows (M, n), each joint weighing alike."""
    Y = regressor.Y
    size = np.array([max(float(np.sqrt(np.mean(tau**2))), 1e-12) for tau in regressor.torque.T])
    weights = rows / np.maximum(size, 1e-3 * size.max())
    A, y = (Y * weights[:, :, None]).reshape(-1, Y.shape[2]), (regressor.torque * weights).ravel()
    scale = np.maximum(np.linalg.norm(A, axis=0), 1e-300)
    return np.linalg.lstsq(A / scale, y, rcond=1e-6)[0] / scale


def _judged(
    regressor: pid.Regressor, unknown: Sequence[tuple[Array, NDArray[np.bool_]]], filter: pid.Filter
) -> NDArray[np.bool_]:
    """Rows (M, n) whose surroundings, half a period of the cutoff to either side, are mostly known."""
    result = np.ones_like(regressor.torque, dtype=bool)
    half = 0.5 / filter.cutoff
    for index, (time, unknown_rows) in enumerate(unknown):
        rows = regressor.recording == index
        count = np.concatenate([np.zeros((1, unknown_rows.shape[1])), np.cumsum(unknown_rows, axis=0)])
        first, last = (np.searchsorted(time, regressor.time[rows] + side) for side in (-half, half))
        share = (count[last] - count[first]) / np.maximum(last - first, 1)[:, None]
        result[rows] = share <= OPEN
    return result


def _rms(values: Array, rows: NDArray[np.bool_]) -> Array:
    """RMS (n,) of values (M, n) over the rows of each joint that count."""
    return np.sqrt(np.sum(np.where(rows, values, 0.0) ** 2, axis=0) / np.maximum(rows.sum(axis=0), 1))
