"""One look for every figure: colours that colour-blind readers tell apart (Okabe and Ito, 2008), units on every axis."""

from __future__ import annotations

from typing import Any

FORMATS = (".png", ".pdf", ".svg")
MEASURED, PREDICTED, RESIDUAL, SECOND = "#000000", "#0072B2", "#D55E00", "#009E73"
JOINTS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
SETTINGS: Any = {
    "figure.dpi": 110,
    "font.size": 9,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "lines.linewidth": 1.1,
    "savefig.bbox": "tight",
}


def figure(rows: int, columns: int = 1, size: tuple[float, float] = (9.0, 2.0), **options: Any) -> tuple[Any, Any]:
    """A matplotlib figure without a screen and its axes (rows, columns); ``size`` [inch] of one cell."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with mpl.rc_context(SETTINGS):
        fig = Figure(figsize=(size[0] * columns, size[1] * rows), layout="constrained")
        FigureCanvasAgg(fig)
        return fig, fig.subplots(rows, columns, squeeze=False, **options)


def save(fig: Any, path: Any) -> None:
    """Write a figure whole or not at all, in the format of the path's ending; raises InputError for an unknown one."""
    from pathlib import Path

    from physident.errors import InputError
    from physident.files import write_with

    if Path(path).suffix.lower() not in FORMATS:
        raise InputError(f"plot {str(path)!r} has no known ending, expected one of {', '.join(FORMATS)}")
    write_with(path, lambda temporary: fig.savefig(temporary))
