"""Ranges of a session's vertical axes, on which the viewer labels multiples of powers of ten only."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from physident.graphics.session.data import SessionData
from physident.graphics.session.joints import effects_of

Array = NDArray[np.float64]
Range = tuple[float, float]
MARGIN = 0.03  # of a range, so that a tick at its end is visible
MAX_TICKS = 8.5  # in a plot of a third of a window: the viewer does not label more


def labelled_range(curves: Iterable[Array]) -> Range | None:
    """A range that contains all curves and two labelled ticks, None where there is nothing to show.

    Ticks lie at multiples of a power of ten, and are labelled where they are not dense. The viewer's default range about
    zero may show the label 0 only, which does not tell the size of the curves.
    """
    finite = np.concatenate([[], *(np.ravel(one)[np.isfinite(np.ravel(one))] for one in curves)])
    if len(finite) == 0 or not finite.min() < finite.max():
        return None
    low, high = float(finite.min()), float(finite.max())
    step = 10.0 ** math.ceil(math.log10((high - low) / MAX_TICKS))
    first, last = math.ceil(low / step), math.floor(high / step)
    below, above = (first - 1) * step, (last + 1) * step
    if last < first:  # everything lies between two ticks
        low, high = below, above
    elif last == first:  # one tick: extend to the nearer of its neighbours
        low, high = (low, above) if above - high <= low - below else (below, high)
    margin = MARGIN * (high - low)
    return low - margin, high + margin


def joint_ranges(data: SessionData) -> dict[str, tuple[Range | None, ...]]:
    """The range of each joint's plot of ``torque``, ``residual``, ``effects`` of the last model, and ``motion``."""
    every = range(data.n)
    last = data.predictions[-1] if data.predictions else None
    drawn = {
        "torque": [[data.measured[:, j], *(p.torque[:, j] for p in data.predictions)] for j in every],
        "residual": [[data.residual(p)[:, j] for p in data.predictions] for j in every],
        "effects": [[last.effects[name][:, j] for name in effects_of(last, j)] if last else [] for j in every],
        "motion": [[data.q[:, j], data.v[:, j]] for j in every],
    }
    return {name: tuple(labelled_range(curves) for curves in joints) for name, joints in drawn.items()}
