"""Line charts: SVG that stretches with the page, and HTML for the text of the axes, so that it is never distorted."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from physident.report.markup import tag

Array = NDArray[np.float64]
WIDTH, HEIGHT = 2000, 1000  # units of the drawing
BINS = 700  # of the width; a longer series is drawn by the smallest and the largest value in each
GAP = 3.0  # steps of the clock: a longer gap interrupts the line


@dataclass(frozen=True, eq=False)
class Line:
    """A curve: ``values`` (N,) over ``time`` (N,) [s], with its name, colour and width in pixels."""

    name: str
    time: Array
    values: Array
    colour: str
    width: float = 1.2


def line_chart(
    lines: Sequence[Line],
    unit: str,
    quantity: str,
    bands: Sequence[tuple[float, float]] = (),
    over: str = "time [s]",
) -> Markup:
    """A chart of lines over time [s], or what else ``over`` names; ``quantity`` and ``unit`` label the axis, and ``bands``
    (start, end) [s] are shaded."""
    left, right = min(float(x.time[0]) for x in lines), max(float(x.time[-1]) for x in lines)
    top, bottom = max(float(x.values.max()) for x in lines), min(float(x.values.min()) for x in lines)
    margin = 0.06 * (top - bottom) or 1.0
    box = (left, right, bottom - margin, top + margin)
    shaded = [tag("rect", **_band(band, box), class_="band") for band in bands if band[0] < right and band[1] > left]
    ys = ticks(box[2], box[3], 4)
    grid = [_segment(0, _y(y, box), WIDTH, _y(y, box), "zero" if y == 0 else "grid") for y in ys]
    drawn = [_polyline(part, line, box) for line in lines for part in _parts(line)]
    picture = tag(
        "svg", *shaded, *grid, *drawn,
        viewBox=f"0 0 {WIDTH} {HEIGHT}", preserveAspectRatio="none", role="img", aria_label=f"{quantity} over {over.partition(' [')[0]}",
    )  # fmt: skip
    rows = [tag("span", f"{y:g}".replace("-", "−"), style=f"top:{_y(y, box) / HEIGHT:.1%}") for y in ys]
    columns = [tag("span", f"{x:g}", style=f"left:{(x - left) / (right - left):.1%}") for x in ticks(left, right, 5)]
    return tag(
        "div",
        tag("div", f"{quantity} [{unit}]", class_="title"),
        tag("div", *rows, class_="rows"),
        tag("div", picture, class_="area"),
        tag("div", *columns, class_="columns"),
        tag("div", over, class_="below"),
        class_="chart",
    )


def legend(lines: Sequence[tuple[str, str]]) -> Markup:
    """A legend: names beside samples of their colours."""
    return tag("p", *(tag("span", swatch(colour), name) for name, colour in lines), class_="legend")


def swatch(colour: str) -> Markup:
    """A sample of a colour."""
    return tag("i", style=f"background:{colour}")


def ticks(low: float, high: float, count: int) -> list[float]:
    """About ``count`` round numbers between two ends, in steps of 1, 2 or 5 times a power of ten."""
    step = (high - low) / count
    power = 10.0 ** math.floor(math.log10(step))
    step = min((k * power for k in (1, 2, 5, 10)), key=lambda s: abs(math.log(s / step)))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [float(f"{k * step:.10g}") for k in range(first, last + 1)]


def _parts(line: Line) -> list[tuple[Array, Array]]:
    """The contiguous parts of a line, each thinned to what the chart can show."""
    step = float(np.median(np.diff(line.time))) if len(line.time) > 1 else 1.0
    cuts = np.flatnonzero(np.diff(line.time) > GAP * step) + 1
    pieces = zip(np.split(line.time, cuts), np.split(line.values, cuts), strict=True)
    return [_thinned(x, y) for x, y in pieces if len(x) > 1]


def _thinned(x: Array, y: Array) -> tuple[Array, Array]:
    if len(x) <= 2 * BINS:
        return x, y
    edges = np.linspace(0, len(x), BINS + 1).astype(int)
    kept = [int(k) for a, b in itertools.pairwise(edges) for k in _extremes(y, a, b)]
    return x[kept], y[kept]


def _extremes(y: Array, a: int, b: int) -> list[int]:
    return sorted({a + int(np.argmin(y[a:b])), a + int(np.argmax(y[a:b]))})


def _polyline(part: tuple[Array, Array], line: Line, box: tuple[float, float, float, float]) -> Markup:
    x = np.rint(WIDTH * (part[0] - box[0]) / (box[1] - box[0])).astype(int)
    y = np.rint([_y(value, box) for value in part[1]]).astype(int)
    points = " ".join(f"{a},{b}" for a, b in zip(x.tolist(), y.tolist(), strict=True))
    return tag("polyline", points=points, stroke=line.colour, stroke_width=line.width)


def _segment(x1: float, y1: float, x2: float, y2: float, kind: str) -> Markup:
    return tag("line", x1=f"{x1:.0f}", y1=f"{y1:.0f}", x2=f"{x2:.0f}", y2=f"{y2:.0f}", class_=kind)


def _band(band: tuple[float, float], box: tuple[float, float, float, float]) -> dict[str, str]:
    start, end = (WIDTH * (np.clip(t, box[0], box[1]) - box[0]) / (box[1] - box[0]) for t in band)
    return {"x": f"{start:.0f}", "y": "0", "width": f"{end - start:.0f}", "height": str(HEIGHT)}


def _y(value: float, box: tuple[float, float, float, float]) -> float:
    return HEIGHT * (box[3] - value) / (box[3] - box[2])
