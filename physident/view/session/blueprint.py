"""How a session opens: the arm on the left, its joints on the right, tabs for charts, diagnosis and design."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.view.session import design as session_design
from physident.view.session.chart import BOUNDS, LEGEND_ROW, LEGEND_STEP
from physident.view.session.log import TIMELINE, path_part
from physident.view.session.range import Range

Array = NDArray[np.float64]
FOUND_SHOWN = 3
VIEW_FROM = np.array([0.7, -0.95, 0.45])  # from the front right, a little above


@dataclass(frozen=True, eq=False)
class Look:
    """Where an arm moves, ``centre`` (3,) and ``reach`` [m], and what stands above it."""

    centre: Array
    reach: float
    title: str

    @staticmethod
    def at(been: Array, title: str) -> Look:
        """A look that holds the base and where an arm has been (P, 3) [m]."""
        points = np.vstack([been, np.zeros(3)])
        centre = (points.max(axis=0) + points.min(axis=0)) / 2
        return Look(centre, max(float(np.ptp(points, axis=0).max()), 0.1), title)


@dataclass(frozen=True, eq=False)
class Contained:
    """What a session holds, so that no view opens empty: joint names, whether they are prismatic, the ``first`` model and the
    one whose effects are shown; how many ``models`` and ``effects``; joints (from 1) that are ``found`` to lack something; the ``end`` [s] of the recordings and of the design; whether there are models, a diagnosis, a plan, and of it a design and its progress; how to look at the ``arm`` and
    at the ``planned`` motion; the ``ranges`` of each joint's plots."""

    joints: tuple[str, ...]
    prismatic: tuple[bool, ...]
    first: str | None
    effects_of: str | None
    models: int
    effects: int
    found: tuple[int, ...]
    end: float
    design_end: float
    recorded: bool
    diagnosed: bool
    planning: bool
    designed: bool
    progress: bool
    arm: Look
    planned: Look
    ranges: dict[str, tuple[Range | None, ...]] = field(default_factory=dict)


def make_blueprint(c: Contained) -> Any:
    """The blueprint of a session, time paused at its start."""
    import rerun.blueprint as rrb

    right: Any = rrb.Tabs(*_tabs(c), active_tab=0)
    if c.recorded:
        bands = rrb.StateTimelineView(origin="/bands", name="recordings and contacts", time_view=_whole(c.end))
        right = rrb.Vertical(right, bands, row_shares=[6, 1])
    left: Any = _arm(c.arm, "/robot") if c.recorded else _arm(c.planned, "/design/robot")
    if c.recorded:
        left = rrb.Vertical(left, rrb.TextDocumentView(origin="/summary", name="summary"), row_shares=[5, 3])
    return rrb.Blueprint(
        rrb.Horizontal(left, right, column_shares=[1, 2]),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="paused"),
    )


def _tabs(c: Contained) -> list[Any]:

    tabs: list[Any] = []
    models = ("/legend/models", 1 + c.models)
    if c.recorded:
        tabs.append(_with_legend(_curves(c, "torque"), *models, "torque"))
        if c.effects_of is not None:
            effects = (f"/legend/effects/{path_part(c.effects_of)}", c.effects)
            tabs.append(_with_legend(_curves(c, "residual"), "/legend/residual", c.models, "residual"))
            tabs.append(
                _with_legend(_curves(c, f"effects/{path_part(c.effects_of)}"), *effects, f"effects of {c.effects_of}")
            )
            for part in ("velocity", "position"):
                tabs.append(_with_legend(_charts(c, part), "/legend/residual", c.models, f"residual against {part}"))
        tabs.append(_with_legend(_curves(c, "motion"), "/legend/motion", 2, "motion"))
    if c.diagnosed:
        tabs.append(_diagnosis(c))
    if c.planning:
        tabs.append(_design(c))
    return tabs


def _diagnosis(c: Contained) -> Any:
    """The findings in words, beside the residuals of the joints they name first."""
    import rerun.blueprint as rrb

    text = rrb.TextDocumentView(origin="/diagnosis", name="findings")
    if not c.recorded or not c.found:
        return rrb.Vertical(text, name="diagnosis")
    plots = [
        _plot(f"/joints/{j}", ["$origin/residual/**"], f"residual of {j} {_titled(c, j)}", True, c.end)
        for j in c.found[:FOUND_SHOWN]
    ]
    return rrb.Horizontal(text, rrb.Vertical(*plots), column_shares=[3, 2], name="diagnosis")


def _titled(c: Contained, joint: int) -> str:
    """A joint's (from 1) name and the unit of what drives it."""
    return f"{c.joints[joint - 1]} [{'N' if c.prismatic[joint - 1] else 'N m'}]"


def _arm(look: Look, origin: str) -> Any:
    import rerun.blueprint as rrb

    eye = rrb.EyeControls3D(position=look.centre + look.reach * VIEW_FROM, look_target=look.centre, eye_up=[0, 0, 1])
    return rrb.Spatial3DView(origin=origin, name=look.title, eye_controls=eye)


def _curves(c: Contained, what: str) -> Any:
    """A plot for each joint."""
    views = []
    for j, joint in enumerate(c.joints):
        length, effort = ("m", "N") if c.prismatic[j] else ("rad", "N m")
        unit = f"{length}, {length}/s" if what == "motion" else effort
        parts = ("velocity", "position") if what == "motion" else (what,)
        contents = [f"$origin/{p}/**" for p in parts]
        held = c.ranges.get(what.split("/")[0])
        views.append(
            _plot(f"/joints/{j + 1}", contents, f"{j + 1} {joint} [{unit}]", False, c.end, held[j] if held else None)
        )
    return _grid(views, what)


def _plot(origin: str, contents: Sequence[str], name: str, legend: bool, end: float, held: Range | None = None) -> Any:
    import rerun.blueprint as rrb

    return rrb.TimeSeriesView(
        origin=origin, contents=list(contents), name=name, axis_x=_whole(end),
        axis_y=None if held is None else rrb.ScalarAxis(range=held),
        plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop, visible=legend),
    )  # fmt: skip


def _with_legend(grid: Any, origin: str, count: int, name: str, row: int = LEGEND_ROW) -> Any:
    """Plots under a strip that says what their colours mean."""
    import rerun.blueprint as rrb

    rows = -(-count // row)
    bounds = rrb.VisualBounds2D(x_range=(-1.0, row * LEGEND_STEP), y_range=(-0.7, rows - 0.3))
    strip = rrb.Spatial2DView(origin=origin, name="colours", visual_bounds=bounds, titlebar=False)
    return rrb.Vertical(strip, grid, row_shares=[0.55 * rows, 10], name=name)


def _whole(end: float) -> Any:
    """A time axis that opens on everything from 0 to an end [s]; zoomed, all plots of a session go together."""
    import rerun as rr
    import rerun.blueprint as rrb

    whole = rr.TimeRange(
        start=rr.TimeRangeBoundary.absolute(seconds=0.0), end=rr.TimeRangeBoundary.absolute(seconds=end)
    )
    return rrb.TimeAxis(view_range=whole, link=rrb.components.LinkAxis.Independent)


def _charts(c: Contained, part: str) -> Any:
    views = [
        _chart(f"/charts/{j + 1}/{part}", f"{j + 1} {joint}, points: {c.first}, lines: medians")
        for j, joint in enumerate(c.joints)
    ]
    return _grid(views, part)


def _chart(origin: str, name: str) -> Any:
    import rerun.blueprint as rrb

    bounds = rrb.VisualBounds2D(x_range=BOUNDS[0], y_range=BOUNDS[1])
    return rrb.Spatial2DView(origin=origin, name=name, visual_bounds=bounds)


def _design(c: Contained) -> Any:
    import rerun.blueprint as rrb

    length = "rad, m" if any(c.prismatic) else "rad"
    units = {"position": length, "velocity": f"{length}/s", "acceleration": f"{length}/s²"}
    curves = [
        _plot(f"/design/{part}", ["$origin/**"], f"planned {part} [{unit}]", False, c.design_end)
        for part, unit in units.items()
    ]
    side = [_chart("/design/progress", "condition number, iteration by iteration")] if c.progress else []
    robot = [_arm(c.planned, "/design/robot")] if c.recorded else []
    side += [rrb.TextDocumentView(origin="/design/limits", name="limits, the nearest first")] if c.designed else []
    stacked = _with_legend(rrb.Vertical(*curves), "/legend/joints", len(c.joints), "design", session_design.LEGEND_ROW)
    return rrb.Horizontal(rrb.Vertical(*robot, *side), stacked, name="design") if robot or side else stacked


def _grid(views: Sequence[Any], name: str) -> Any:
    import rerun.blueprint as rrb

    return rrb.Grid(*views, grid_columns=1 if len(views) < 3 else 2, name=name)
