"""Colours and settings of all figures and sessions; colour-blind readers can distinguish them (Okabe and Ito, 2008)."""

from __future__ import annotations

from typing import Any

from physident.effects.catalogue import CATALOGUE
from physident.effects.classification import Family

FORMATS = (".png", ".pdf", ".svg")
# one colour for each role, in figures, sessions and reports: black is measured, orange the model as it was, blue the extended
# model, green what belongs to neither
MEASURED, AS_IT_WAS, EXTENDED, OTHER = "#000000", "#D55E00", "#0072B2", "#009E73"
RESIDUAL = AS_IT_WAS  # of a link: that of the model as it was
# on the viewer's background, which may be black or white: grey where figures have black, and one colour for each model
SESSION_MEASURED = "#8C8C8C"
MODELS = ("#E8772E", "#3D9BE0", "#1FB58A", "#CC79A7", "#B4A54B")
POSITION, VELOCITY = "#1FB58A", "#3D9BE0"
JOINTS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
# one colour for each effect of the catalogue, the same in every figure, session and report: as different as 32 colours can
# be for normal, protan and deutan eyes, and visible on a black and on a white background; the default effects and the most
# frequent causes come first and differ most
EFFECTS = {
    "rigid_body": "#56B4E9",
    "rotor_inertia": "#2DE187",
    "viscous_friction": "#E69F00",
    "coulomb_friction": "#D2003C",
    "torque_offset": "#693CFF",
    "payload": "#D200B4",
    "load_dependent_friction": "#6978FF",
    "stribeck_friction": "#A5D2B4",
    "friction_asymmetry": "#C32D0F",
    "presliding_hysteresis": "#5A875A",
    "nonlinear_viscous_friction": "#D2874B",
    "contact": "#A5E169",
    "torque_constant": "#00D2D2",
    "torque_scale": "#F0C300",
    "torque_crosstalk": "#E178B4",
    "gravity_tilt": "#69A5FF",
    "gravity_magnitude": "#78A596",
    "link_inertia": "#A54B69",
    "warm_up": "#A51ED2",
    "friction_level": "#5AD269",
    "joint_spring": "#875A87",
    "joint_zero_offset": "#3CF03C",
    "coupled_friction": "#4BB478",
    "joint_elasticity": "#A569D2",
    "torque_ripple": "#3CA5B4",
    "torque_delay": "#695AFF",
    "time_delay": "#B4D2FF",
    "learned_position": "#E1691E",
    "learned_position_friction": "#0069A5",
    "learned_velocity": "#FF4B69",
    "learned_load": "#877887",
    "learned_torque": "#18C0D8",
    "learned_time": "#875A3C",
    "learned_temperature": "#F0964B",
}
# for effects without a colour of their own
FAMILIES = {
    Family.INERTIA: "#8795A0",
    Family.FRICTION: "#B98A5A",
    Family.TRANSMISSION: "#7D8F6A",
    Family.MEASUREMENT: "#5F8F9B",
    Family.MOUNTING: "#9B7FA0",
    Family.CONTACT: "#A0A05F",
    Family.LEARNED: "#8C7B6B",
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
    """The colour "#RRGGBB" of an effect by its name in the catalogue, that of its family where it has none.

    Raises KeyError for a name that the catalogue does not have.
    """
    return EFFECTS[name] if name in EFFECTS else FAMILIES[CATALOGUE[name].family]


def figure(rows: int, columns: int = 1, size: tuple[float, float] = (9.0, 2.0), **options: Any) -> tuple[Any, Any]:
    """A matplotlib figure that needs no screen, and its axes (rows, columns); ``size`` [inch] is that of one cell."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with mpl.rc_context(SETTINGS):
        fig = Figure(figsize=(size[0] * columns, size[1] * rows), layout="constrained")
        FigureCanvasAgg(fig)
        return fig, fig.subplots(rows, columns, squeeze=False, **options)


def save(fig: Any, path: Any) -> None:
    """Write a figure whole or not at all, in the format of the path's ending; raises InputError for an unknown ending."""
    from pathlib import Path

    from physident.errors import InputError
    from physident.files import VERSION
    from physident.outputs import write_with

    if Path(path).suffix.lower() not in FORMATS:
        raise InputError(f"plot {str(path)!r} has no known ending, expected one of {', '.join(FORMATS)}")
    field = "Software" if Path(path).suffix.lower() == ".png" else "Creator"  # as the format calls its maker
    write_with(path, lambda temporary: fig.savefig(temporary, metadata={field: f"physident {VERSION}"}))
