"""Charts of one quantity against another, drawn as points and lines: the viewer itself plots over time only."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from physident.graphics import style
from physident.graphics.session.log import duration, rgb

if TYPE_CHECKING:
    import rerun as rr

Array = NDArray[np.float64]
WIDTH, HEIGHT = 3.3, 1.0  # of the axes, in units of the view
MARK_DROP = 0.02  # from the top of a chart to the name of a mark
LABEL_DROP = 0.1  # distance of the viewer's labels below their points
LEGEND_ROW, LEGEND_STEP = 5, 8.0  # names in a row of a legend, and their distance in heights of a row
LETTER = 0.12  # half a letter's width, so that a name begins beside its colour
MAX_POINTS = 1500
BINS = 24
LINES_FROM = 40.0  # the viewer's order of drawing, above points
BOUNDS = ((-0.33, 3.45), (-0.14, 1.42))  # x and y range of a view that shows one chart and its labels


@dataclass(frozen=True)
class Axes:
    """Ranges of x and y of a chart; with ``logarithmic``, y is the logarithm (base 10) of the labelled values."""

    x: tuple[float, float]
    y: tuple[float, float]
    logarithmic: bool = False

    @staticmethod
    def about(x: Array, y: Array, logarithmic: bool = False, inner: float = 1.0) -> Axes:
        """Axes that contain all finite values of x and the ``inner`` share of those of y, with a margin."""
        ranges = []
        for values, share in ((x, 1.0), (np.log10(y) if logarithmic else y, inner)):
            finite = values[np.isfinite(values)]
            ends = np.quantile(finite, [(1 - share) / 2, (1 + share) / 2]) if len(finite) else (0.0, 1.0)
            low, high = float(ends[0]), float(ends[1])
            room = 0.05 * (high - low) or max(abs(high), 1.0) * 0.1
            ranges.append((low - room, high + room))
        return Axes(ranges[0], ranges[1], logarithmic)

    def place(self, x: Array, y: Array) -> Array:
        """Positions (N, 2) of points in the view, whose second axis points down; points beyond the frame are put on its edge."""
        y = np.log10(y) if self.logarithmic else y
        across = (x - self.x[0]) / (self.x[1] - self.x[0])
        up = (y - self.y[0]) / (self.y[1] - self.y[0])
        return np.column_stack([WIDTH * np.clip(across, 0, 1), HEIGHT * (1 - np.clip(up, 0, 1))])


def log_axes(rec: rr.RecordingStream, path: str, axes: Axes, x_label: str, y_label: str) -> None:
    """Log frame, grid, ticks and the labels of both axes."""
    import rerun as rr

    grey, frame = rgb(style.SESSION_MEASURED), [[[0, 0], [0, HEIGHT], [WIDTH, HEIGHT]]]
    lines, places, texts = list(frame), [[WIDTH - 0.35, HEIGHT + 0.17], [0.35, -0.12]], [x_label, y_label]
    for value in ticks(*axes.x):
        at = WIDTH * (value - axes.x[0]) / (axes.x[1] - axes.x[0])
        lines.append([[at, HEIGHT], [at, 0.0 if value == 0 else HEIGHT - 0.02]])
        places.append([at, HEIGHT])
        texts.append(f"{value:g}")
    for value in decades(*axes.y) if axes.logarithmic else ticks(*axes.y):
        at = HEIGHT * (1 - (value - axes.y[0]) / (axes.y[1] - axes.y[0]))
        lines.append([[0, at], [WIDTH if value == 0 and not axes.logarithmic else 0.02, at]])
        places.append([-0.14, at - LABEL_DROP])
        texts.append(f"{10**value:.4g}" if axes.logarithmic else f"{value:g}")
    rec.log(f"{path}/axes", rr.LineStrips2D(lines, colors=[grey], radii=rr.Radius.ui_points(0.6)), static=True)
    rec.log(
        f"{path}/labels", rr.Points2D(places, labels=texts, show_labels=True, radii=0.0, colors=[grey]), static=True
    )


def log_points(rec: rr.RecordingStream, path: str, axes: Axes, x: Array, y: Array, colour: str) -> None:
    """Log points, thinned evenly to 1500 at most."""
    import rerun as rr

    known = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    chosen = (
        known[np.unique(np.linspace(0, len(known) - 1, min(MAX_POINTS, len(known))).astype(int))]
        if len(known)
        else known
    )
    drawn = rr.Points2D(axes.place(x[chosen], y[chosen]), colors=[[*rgb(colour), 180]], radii=rr.Radius.ui_points(1.0))
    rec.log(path, drawn, static=True)


def log_line(
    rec: rr.RecordingStream, path: str, axes: Axes, x: Array, y: Array, colour: str, width: float = 4.0, layer: int = 0
) -> None:
    """Log a line through points (N,); one of a higher layer is drawn above."""
    import rerun as rr

    line = rr.LineStrips2D(
        [axes.place(x, y)], colors=[rgb(colour)], radii=rr.Radius.ui_points(width / 2), draw_order=LINES_FROM + layer
    )
    rec.log(path, line, static=True)


def log_mark(rec: rr.RecordingStream, path: str, axes: Axes, x: float, text: str) -> None:
    """Log a vertical line at x, with a text for what begins there."""
    import rerun as rr

    grey = [rgb(style.SESSION_MEASURED)]
    at = WIDTH * (x - axes.x[0]) / (axes.x[1] - axes.x[0])
    line = rr.LineStrips2D([[[at, 0.0], [at, HEIGHT]]], colors=grey, radii=rr.Radius.ui_points(0.6))
    rec.log(f"{path}/line", line, static=True)
    name = rr.Points2D([[at + 0.03 * len(text), MARK_DROP]], labels=[text], show_labels=True, radii=0.0, colors=grey)
    rec.log(f"{path}/name", name, static=True)


def log_cursor(rec: rr.RecordingStream, path: str, axes: Axes, time: Array, x: Array, y: Array) -> None:
    """Log a point that moves through a chart with the session's clock."""
    import rerun as rr

    known = np.isfinite(x) & np.isfinite(y)
    rec.send_columns(path, [duration(time[known])], rr.Points2D.columns(positions=axes.place(x[known], y[known])))
    rec.log(path, rr.Points2D.from_fields(colors=[rgb(style.RESIDUAL)], radii=rr.Radius.ui_points(4.0)), static=True)


def binned_median(x: Array, y: Array, bins: int = BINS) -> tuple[Array, Array]:
    """Medians of x and y in bins of x with equal numbers of points."""
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    parts = [part for part in np.array_split(np.argsort(x, kind="stable"), bins) if len(part)]
    return np.array([np.median(x[p]) for p in parts]), np.array([np.median(y[p]) for p in parts])


def decades(low: float, high: float) -> Sequence[float]:
    """Logarithms (base 10) of the numbers 1, 2 and 5 times a power of ten between two logarithms."""
    every = [k + math.log10(m) for k in range(math.floor(low), math.ceil(high) + 1) for m in (1, 2, 5)]
    return [value for value in every if low <= value <= high]


def ticks(low: float, high: float) -> Sequence[float]:
    """Three to seven round numbers between two, in steps of 1, 2, 2.5 or 5 times a power of ten."""
    rough = (high - low) / 6
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(m * power for m in (1, 2, 2.5, 5, 10) if m * power >= rough)
    return [round(k * step, 12) for k in range(math.ceil(low / step), math.floor(high / step) + 1)]


def log_legend(rec: rr.RecordingStream, path: str, colours: dict[str, str], row: int = LEGEND_ROW) -> None:
    """Log names beside points of their colours, ``row`` of them in each row."""
    import rerun as rr

    grey = rgb(style.SESSION_MEASURED)
    for number, (name, colour) in enumerate(colours.items()):
        x, y = LEGEND_STEP * (number % row), float(number // row)
        dot = rr.Points2D([[x, y]], radii=rr.Radius.ui_points(5.0), colors=[rgb(colour)])
        rec.log(f"{path}/{number}/dot", dot, static=True)
        text = rr.Points2D(
            [[x + 0.8 + LETTER * len(name), y - 0.45]], labels=[name], show_labels=True, radii=0.0, colors=[grey]
        )
        rec.log(f"{path}/{number}/name", text, static=True)
