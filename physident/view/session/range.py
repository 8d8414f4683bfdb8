"""Ranges of a session's vertical axes, which the viewer marks at powers of ten only."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from physident.view.session.data import SessionData
from physident.view.session.joints import effects_of

Array = NDArray[np.float64]
Range = tuple[float, float]
ROOM = 0.03  # of a range, so that a mark at its end is seen
DENSE = 8.5  # marks in a plot of a third of a window: the viewer leaves out the numbers of more


def marked(curves: Iterable[Array]) -> Range | None:
    """A range that holds all curves and two of the viewer's numbered marks, None where there is nothing to show.

    Marks lie at the multiples of a power of ten, numbered where they are not dense. Left alone, a range about zero may
    hold the number 0 only, which says nothing of its size.
    """
    finite = np.concatenate([[], *(np.ravel(one)[np.isfinite(np.ravel(one))] for one in curves)])
    if len(finite) == 0 or not finite.min() < finite.max():
        return None
    low, high = float(finite.min()), float(finite.max())
    step = 10.0 ** math.ceil(math.log10((high - low) / DENSE))
    first, last = math.ceil(low / step), math.floor(high / step)
    below, above = (first - 1) * step, (last + 1) * step
    if last < first:  # all of it is between two marks
        low, high = below, above
    elif last == first:  # one mark: as far as the nearer of its neighbours
        low, high = (low, above) if above - high <= low - below else (below, high)
    room = ROOM * (high - low)
    return low - room, high + room


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
    return {name: tuple(marked(curves) for curves in joints) for name, joints in drawn.items()}
