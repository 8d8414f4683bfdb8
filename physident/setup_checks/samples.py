"""The effort's samples themselves: saturation and coarse steps; no robot is needed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from physident.recordings.recording import Recording
from physident.recordings.signals import MOVING_SPEED
from physident.setup_checks.finding import SetupFinding, joint_list, within

Array = NDArray[np.float64]
PLATEAU = 5  # samples in a row that are equal: noise repeats a value of many levels seldom, and never five times at its extreme
REPEATED = 0.5  # share of samples that equal the next one, within the range: such a channel is updated more slowly than it is logged
SHARE = 0.01  # of the rows in motion: fewer clipped rows hardly move an estimate
COARSE = 0.2  # of the effort's standard deviation: steps as coarse are a noise of 6 % of it
BINS = 200  # of the effort's range: what counts as its extreme


def check_samples(recordings: Sequence[Recording]) -> Iterator[SetupFinding]:
    """Efforts that are clipped, or that come in coarse steps."""
    clipped: dict[int, float] = {}
    coarse: dict[int, float] = {}
    n = recordings[0].n
    for recording in recordings:
        moving = _moving(recording)
        if moving.sum() < 10 * PLATEAU:
            continue
        for j in range(recording.n):
            effort = recording.effort[:, j]
            spread = float(np.ptp(effort[moving]))
            if spread == 0:
                continue
            share = _clipped(effort, moving, spread)
            if share > SHARE:
                clipped[j + 1] = max(share, clipped.get(j + 1, 0.0))
            step = _step(effort[moving]) / float(effort[moving].std())
            if step > COARSE:
                coarse[j + 1] = max(step, coarse.get(j + 1, 0.0))
    for j in set(clipped) & set(coarse):
        del clipped[j]  # a signal of a few levels stays at its extreme one
    if clipped:
        yield SetupFinding(
            kind="saturation",
            joints=tuple(clipped),
            statement=f"the effort of {within(clipped, n)} saturates: true torques were larger; record a slower motion or a wider range",
            evidence=f"at its limit in up to {100 * max(clipped.values()):.0f} % of the rows in motion",
            void=False,
        )
    if coarse:
        worst = max(coarse, key=lambda j: coarse[j])
        yield SetupFinding(
            kind="quantisation",
            joints=tuple(coarse),
            statement=f"the effort of {joint_list(coarse)} comes in coarse steps; log it with more digits",
            evidence=f"steps of {100 * coarse[worst]:.0f} % of the standard deviation on joint {worst}",
            void=False,
        )


def _moving(recording: Recording) -> NDArray[np.bool_]:
    """Rows (N,) at which some joint moves, over a quarter of a second."""
    step = float(np.median(np.diff(recording.time)))
    lag = max(1, round(0.25 / step))
    travel = np.abs(recording.q[lag:] - recording.q[:-lag]).max(axis=1)
    return np.concatenate([travel > lag * step * MOVING_SPEED, np.zeros(min(lag, len(recording.q)), dtype=bool)])[
        : len(recording.q)
    ]


def _clipped(effort: Array, moving: NDArray[np.bool_], spread: float) -> float:
    """Share of the rows in motion that lie in plateaus at either end of the range, each of equal samples in a row; zero for
    a channel that repeats samples everywhere."""
    inside = moving & (effort < effort[moving].max()) & (effort > effort[moving].min())
    repeated = np.append(np.diff(effort) == 0, False)
    if not inside.any() or repeated[inside].mean() > REPEATED:
        return 0.0
    count = 0
    for extreme in (effort[moving].max(), effort[moving].min()):
        at = (effort == extreme) & moving
        edges = np.flatnonzero(np.diff(np.concatenate([[False], at, [False]]).astype(int))).reshape(-1, 2)
        count += sum(int(b - a) for a, b in edges if b - a >= PLATEAU and _arrives(effort, a, spread))
    return count / int(moving.sum())


def _arrives(effort: Array, start: int, spread: float) -> bool:
    """Whether the effort was on its way when the plateau began: a smooth signal of few levels lingers near its turning point."""
    return start == 0 or abs(effort[start] - effort[max(0, start - PLATEAU)]) > spread / BINS


def _step(values: Array) -> float:
    """The step of values on a grid of few levels; zero where they are on none."""
    levels = np.unique(values)
    if not 2 <= len(levels) <= BINS:
        return 0.0
    apart = np.diff(levels)
    step = float(apart.min())
    on_grid = np.abs(apart / step - np.round(apart / step)) < 0.05
    return step if on_grid.mean() > 0.95 else 0.0
