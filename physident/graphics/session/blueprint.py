"""The layout of a session: the arm on the left, its joints on the right, tabs for charts, diagnosis and design."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.graphics.labels import VIEW_FROM
from physident.graphics.session import design as session_design
from physident.graphics.session.axis_ranges import LEGEND_ROOM, Range, in_title, with_margin
from physident.graphics.session.chart import BOUNDS, LEGEND_ROW, LEGEND_STEP
from physident.graphics.session.log import TIMELINE, path_part

Array = NDArray[np.float64]
JOINTS_BESIDE_DIAGNOSIS = 3  # whose residuals are shown beside the findings


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera on a space of ``reach`` [m] about a ``centre`` (3,) [m], and the title above its view."""

    centre: Array
    reach: float
    title: str

    @staticmethod
    def around(points: Array, title: str) -> Camera:
        """A camera on the base and on points (P, 3) [m]."""
        points = np.vstack([points, np.zeros(3)])
        centre = (points.max(axis=0) + points.min(axis=0)) / 2
        return Camera(centre, max(float(np.ptp(points, axis=0).max()), 0.1), title)


@dataclass(frozen=True, eq=False, kw_only=True)
class Outline:
    """What a session contains; views are laid out for this only, so that none opens empty.

    ``joints`` are names. ``first_model`` is shown as points in the charts, and the effects of ``last_model`` are shown;
    ``models`` and ``effects`` are their numbers. ``joints_beside`` (from 1) are those whose residuals are shown beside the findings. ``end`` and
    ``design_end`` [s] are the ends of the recordings and of the planned motion. ``arm`` and ``planned`` are the cameras of
    both. ``moving`` (start, end) [s] is the part of the recordings with curves. ``extents`` are the vertical extents of
    each joint's plots, by the name of the plot, ``learned`` the titles of learned curves.
    """

    joints: tuple[str, ...]
    prismatic: tuple[bool, ...]
    first_model: str | None
    last_model: str | None
    models: int
    effects: int
    joints_beside: tuple[int, ...]
    end: float
    design_end: float
    has_recordings: bool
    has_diagnosis: bool
    has_plan: bool
    has_design: bool
    has_progress: bool
    arm: Camera
    planned: Camera
    moving: Range = (0.0, 0.0)
    extents: dict[str, tuple[Range | None, ...]] = field(default_factory=dict)
    learned: tuple[str, ...] = ()


def make_blueprint(c: Outline) -> Any:
    """The blueprint of a session, which opens paused at its first instant, on the diagnosis if there is one."""
    import rerun.blueprint as rrb

    right: Any = rrb.Tabs(*_tabs(c), active_tab=0)
    if c.has_recordings:
        bands = rrb.StateTimelineView(
            origin="/bands", name="recordings and contacts", time_view=_time_axis((0.0, c.end))
        )
        right = rrb.Vertical(right, bands, row_shares=[6, 1])
    left: Any = _arm(c.arm, "/robot") if c.has_recordings else _arm(c.planned, "/design/robot")
    if c.has_recordings:
        left = rrb.Vertical(left, rrb.TextDocumentView(origin="/summary", name="summary"), row_shares=[5, 3])
    return rrb.Blueprint(
        rrb.Horizontal(left, right, column_shares=[1, 2]),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="paused"),
    )


def _tabs(c: Outline) -> list[Any]:
    tabs: list[Any] = [_diagnosis(c)] if c.has_diagnosis else []
    models = ("/legend/models", 1 + c.models)
    if c.has_recordings:
        tabs.append(_with_legend(_curves(c, "torque"), *models, "torque"))
        if c.last_model is not None:
            effects = (f"/legend/effects/{path_part(c.last_model)}", c.effects + 1)
            tabs.append(_with_legend(_curves(c, "residual"), "/legend/residual", c.models, "residual"))
            tabs.append(
                _with_legend(_curves(c, f"effects/{path_part(c.last_model)}"), *effects, f"effects of {c.last_model}")
            )
            for part in ("velocity", "position"):
                tabs.append(_with_legend(_charts(c, part), "/legend/residual", c.models, f"residual against {part}"))
        tabs.append(_with_legend(_curves(c, "motion"), "/legend/motion", 2, "motion"))
    if c.learned:
        tabs.append(_grid([_chart(f"/learned/{k}", title) for k, title in enumerate(c.learned, 1)], "learned curves"))
    if c.has_plan:
        tabs.append(_design(c))
    return tabs


def _diagnosis(c: Outline) -> Any:
    """The findings in words, beside the residuals of the joints that they explain."""
    import rerun.blueprint as rrb

    text = rrb.TextDocumentView(origin="/diagnosis", name="findings")
    if not c.joints_beside:
        return rrb.Vertical(text, name="diagnosis")
    plots = [
        _plot(c, f"/joints/{j}", ["$origin/residual/**"], "residual", j, place == 0)
        for place, j in enumerate(c.joints_beside[:JOINTS_BESIDE_DIAGNOSIS])
    ]
    return rrb.Horizontal(text, rrb.Vertical(*plots), column_shares=[3, 2], name="diagnosis")


def _arm(camera: Camera, origin: str) -> Any:
    import rerun.blueprint as rrb

    eye = rrb.EyeControls3D(
        position=camera.centre + camera.reach * VIEW_FROM, look_target=camera.centre, eye_up=[0, 0, 1]
    )
    return rrb.Spatial3DView(origin=origin, name=camera.title, eye_controls=eye)


def _curves(c: Outline, what: str) -> Any:
    """A plot of one quantity for each joint."""
    parts = ("velocity", "position") if what == "motion" else (what,)
    contents = [f"$origin/{p}/**" for p in parts]
    views = [
        _plot(c, f"/joints/{j}", contents, what.split("/")[0], j, legend=False) for j in range(1, len(c.joints) + 1)
    ]
    return _grid(views, what)


def _plot(c: Outline, origin: str, contents: Sequence[str], what: str, joint: int, legend: bool) -> Any:
    """The plot of a quantity of a joint (from 1), with its extent in the title."""
    length, effort = ("m", "N") if c.prismatic[joint - 1] else ("rad", "N m")
    found = c.extents[what][joint - 1] if what in c.extents else None
    title = in_title(found, f"{length}, {length}/s" if what == "motion" else effort)
    of = "residual of " if legend else ""
    return _time_series(origin, contents, f"{of}{joint} {c.joints[joint - 1]}, {title}", legend, c.moving, found)


def _time_series(
    origin: str, contents: Sequence[str], name: str, legend: bool, time: Range, found: Range | None = None
) -> Any:
    import rerun.blueprint as rrb

    y_range = None if found is None else with_margin(found, LEGEND_ROOM if legend else 0.0)
    return rrb.TimeSeriesView(
        origin=origin, contents=list(contents), name=name, axis_x=_time_axis(time),
        axis_y=None if y_range is None else rrb.ScalarAxis(range=y_range),
        plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop, visible=legend),
    )  # fmt: skip


def _with_legend(grid: Any, origin: str, count: int, name: str, row: int = LEGEND_ROW) -> Any:
    """Plots under a legend of their colours."""
    import rerun.blueprint as rrb

    rows = -(-count // row)
    bounds = rrb.VisualBounds2D(x_range=(-1.0, row * LEGEND_STEP), y_range=(-0.7, rows - 0.3))
    strip = rrb.Spatial2DView(origin=origin, name="colours", visual_bounds=bounds, titlebar=False)
    return rrb.Vertical(strip, grid, row_shares=[0.55 * rows, 10], name=name)


def _time_axis(shown: Range) -> Any:
    """A time axis from a start to an end [s]."""
    import rerun as rr
    import rerun.blueprint as rrb

    whole = rr.TimeRange(
        start=rr.TimeRangeBoundary.absolute(seconds=shown[0]), end=rr.TimeRangeBoundary.absolute(seconds=shown[1])
    )
    return rrb.TimeAxis(view_range=whole, link=rrb.components.LinkAxis.Independent)


def _charts(c: Outline, part: str) -> Any:
    views = [
        _chart(f"/charts/{j + 1}/{part}", f"{j + 1} {joint}, points: {c.first_model}, lines: medians")
        for j, joint in enumerate(c.joints)
    ]
    return _grid(views, part)


def _chart(origin: str, name: str) -> Any:
    import rerun.blueprint as rrb

    bounds = rrb.VisualBounds2D(x_range=BOUNDS[0], y_range=BOUNDS[1])
    return rrb.Spatial2DView(origin=origin, name=name, visual_bounds=bounds)


def _design(c: Outline) -> Any:
    import rerun.blueprint as rrb

    length = "rad, m" if any(c.prismatic) else "rad"
    units = {"position": length, "velocity": f"{length}/s", "acceleration": f"{length}/s²"}
    curves = [
        _time_series(f"/design/{part}", ["$origin/**"], f"planned {part} [{unit}]", False, (0.0, c.design_end))
        for part, unit in units.items()
    ]
    side = [_chart("/design/progress", "condition number, iteration by iteration")] if c.has_progress else []
    robot = [_arm(c.planned, "/design/robot")] if c.has_recordings else []
    side += [rrb.TextDocumentView(origin="/design/limits", name="limits, the nearest first")] if c.has_design else []
    stacked = _with_legend(rrb.Vertical(*curves), "/legend/joints", len(c.joints), "design", session_design.LEGEND_ROW)
    return rrb.Horizontal(rrb.Vertical(*robot, *side), stacked, name="design") if robot or side else stacked


def _grid(views: Sequence[Any], name: str) -> Any:
    import rerun.blueprint as rrb

    return rrb.Grid(*views, grid_columns=1 if len(views) < 3 else 2, name=name)
