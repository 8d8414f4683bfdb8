"""Colours, the clock and curves, for every part of a session."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import rerun as rr

Array = NDArray[np.float64]
TIMELINE = "time"


def rgb(colour: str) -> list[int]:
    """Red, green and blue (0 to 255) of "#RRGGBB"."""
    return [int(colour[i : i + 2], 16) for i in (1, 3, 5)]


def path_part(name: str) -> str:
    """A name as one part of an entity's path."""
    import rerun as rr

    return rr.escape_entity_path_part(name)


def duration(time: Array) -> Any:
    """Instants (N,) [s] on the session's one timeline."""
    import rerun as rr

    return rr.TimeColumn(TIMELINE, duration=time)


def curve(
    rec: rr.RecordingStream, path: str, time: Array, values: Array, name: str, colour: str, width: float = 1.2
) -> None:
    """Log one curve (N,) over instants (N,) [s], with its name for the legend; NaN interrupts it."""
    import rerun as rr

    rec.log(path, rr.SeriesLines(colors=[rgb(colour)], names=[name], widths=[width]), static=True)
    rec.send_columns(path, [duration(time)], rr.Scalars.columns(scalars=values))
