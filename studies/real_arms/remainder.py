"""What the extended model leaves: how slow it is, and how much of it a friction of each recording's own takes away."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, minimum_filter1d

import physident as pid
from physident.dynamics.dry_sign import smooth_sign
from physident.validation.predictions import predict

Array = NDArray[np.float64]
SLOW = 0.2  # Hz
MOVES = 0.02  # rad/s
STANDS = 0.5  # s: shorter is a reversal
EARLY = ("ur-20_02_05", "ur-20_02_06")  # days of the runs


def explained(before: pid.Estimate, after: pid.Estimate, recordings: list[pid.Recording]) -> dict[str, list[float]]:
    """Shares [%] of the residual's power for each joint, and the dry friction [N m] of early and late days."""
    p, v = predict(after, recordings), []
    first = predict(before, recordings)
    waits = []
    for index, recording in enumerate(recordings):
        signals = pid.prepare(recording, after.filter)
        rows = p.recording == index
        at = np.clip(np.searchsorted(signals.time, p.time[rows]), 0, len(signals.time) - 1)
        v.append(signals.v[at])
        fastest = maximum_filter1d(np.abs(signals.v), round(STANDS * signals.rate), axis=0)
        waits.append(minimum_filter1d(fastest, round(STANDS * signals.rate), axis=0)[at] < MOVES)
    speed, still = np.concatenate(v), np.concatenate(waits)
    own = np.eye(len(recordings))[p.recording]
    result: dict[str, list[Any]] = {}

    def add(name: str, value: Any) -> None:
        result.setdefault(name, []).append(float(value))

    late = np.array([not str(r.source).split("/")[-1].startswith(EARLY) for r in recordings])
    dry = _dry_friction(after)
    for j in range(after.model.robot.n):
        r, start = (x.measured[:, j] - x.predicted[:, j] for x in (p, first))
        sign = smooth_sign(speed[:, [j]])
        columns = np.hstack([own * sign, own * speed[:, [j]]])
        values = np.linalg.lstsq(columns, r, rcond=None)[0]
        rest = r - columns @ values
        level = np.linalg.lstsq(own * sign, r, rcond=None)[0]
        add("slow_before", 100 * _slow(start, first.recording, first.rate))
        add("slow_after", 100 * _slow(r, p.recording, p.rate))
        add("slow_own_friction", 100 * _slow(rest, p.recording, p.rate))
        add("own_friction", 100 * (1 - float(rest @ rest) / float(r @ r)))
        add("standing", 100 * float(np.sum(r[still[:, j]] ** 2) / (r @ r)))
        add("standing_time", 100 * float(np.mean(still[:, j])))
        add("dry_early", dry[j] + level[~late].mean())
        add("dry_late", dry[j] + level[late].mean())
    return result


def _dry_friction(estimate: pid.Estimate) -> Array:
    """Dry friction (n,) [N m] at a creep, unloaded, as the model has it."""
    from physident.diagnosis.at_rest.at_rest import breakaway

    return breakaway(estimate.model, np.zeros(estimate.model.robot.n))


def _slow(r: Array, recording: NDArray[np.intp], rate: float) -> float:
    """Share of power below 0.2 Hz, over all recordings."""
    below = total = 0.0
    for index in np.unique(recording):
        part = r[recording == index]
        power = np.abs(np.fft.rfft(part * np.hanning(len(part)))) ** 2
        below += float(power[np.fft.rfftfreq(len(part), 1 / rate) < SLOW].sum())
        total += float(power.sum())
    return below / total
