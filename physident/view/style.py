"""One look for every figure: colours that colour-blind readers tell apart (Okabe and Ito, 2008), units on every axis."""

from __future__ import annotations

from typing import Any

FORMATS = (".png", ".pdf", ".svg")
MEASURED, PREDICTED, RESIDUAL, SECOND = "#000000", "#0072B2", "#D55E00", "#009E73"
JOINTS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
# one colour for each effect of the catalogue, the same in every figure, session and report: as far apart as 22 colours can
# be for normal, protan and deutan eyes, neither too dark for a black background nor too light for a white one; the default
# effects and those found most come first and lie farthest apart
EFFECTS = {
    "rigid_body": "#56B4E9",
    "rotor_inertia": "#2DE187",
    "viscous_friction": "#E69F00",
    "coulomb_friction": "#C3003C",
    "torque_offset": "#6900FF",
    "payload": "#CC79A7",
    "load_dependent_friction": "#5A69F0",
    "stribeck_friction": "#96D2B4",
    "friction_asymmetry": "#A51E78",
    "presliding_hysteresis": "#00784B",
    "nonlinear_viscous_friction": "#B4A54B",
    "contact": "#FF0078",
    "torque_constant": "#3CD2E1",
    "gravity_tilt": "#5A96FF",
    "link_inertia": "#874B00",
    "warm_up": "#D200B4",
    "joint_spring": "#4B3CE1",
    "joint_zero_offset": "#4BE13C",
    "coupled_friction": "#B4875A",
    "joint_elasticity": "#961EC3",
    "torque_ripple": "#5A961E",
    "time_delay": "#FFA578",
}
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


def effect_colour(name: str) -> str:
    """The colour "#RRGGBB" of an effect by its name in the catalogue; raises KeyError for one that has none."""
    return EFFECTS[name]


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
