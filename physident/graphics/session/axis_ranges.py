"""Ranges of a session's vertical axes, which fit the curves, and the same in words for the titles of the plots."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from physident.graphics.session.data import SessionData
from physident.graphics.session.joints import effects_of

Array = NDArray[np.float64]
Range = tuple[float, float]
MARGIN = 0.04  # of a range, so that no curve touches the frame
LEGEND_ROOM = 0.35  # of a range, kept free above the curves of a plot with its own legend


def extent(curves: Iterable[Array]) -> Range | None:
    """The least and the greatest finite value of all curves, None where they are equal or there is none."""
    finite = np.concatenate([[], *(np.ravel(one)[np.isfinite(np.ravel(one))] for one in curves)])
    if len(finite) == 0 or not finite.min() < finite.max():
        return None
    return float(finite.min()), float(finite.max())


def with_margin(found: Range, above: float = 0.0) -> Range:
    """A range with a margin at both ends, and a share ``above`` of it more at the top."""
    low, high = found
    margin = MARGIN * (high - low)
    return low - margin, high + margin + above * (high - low)


def in_title(found: Range | None, unit: str) -> str:
    """The unit of an axis and its ends, "-5.8 to 6.1 N m": the viewer labels multiples of powers of ten only, often just 0."""
    if found is None:
        return f"[{unit}]"
    step = 10.0 ** (np.floor(np.log10(found[1] - found[0])) - 1)
    low, high = (f"{float(np.round(value / step) * step):.10g}" for value in found)
    return f"{low} to {high} {unit}"


def joint_extents(data: SessionData) -> dict[str, tuple[Range | None, ...]]:
    """The extent of each joint's plot of ``torque``, ``residual``, ``effects`` of the last model, and ``motion``."""
    every = range(data.n)
    last = data.predictions[-1] if data.predictions else None
    parts = [[last.effects[name][:, j] for name in effects_of(last, j)] if last else [] for j in every]
    drawn = {
        "torque": [[data.measured[:, j], *(p.torque[:, j] for p in data.predictions)] for j in every],
        "residual": [[data.residual(p)[:, j] for p in data.predictions] for j in every],
        "effects": [[*parts[j], data.residual(last)[:, j]] if last else [] for j in every],
        "motion": [[data.q[:, j], data.v[:, j]] for j in every],
    }
    return {name: tuple(extent(curves) for curves in joints) for name, joints in drawn.items()}
