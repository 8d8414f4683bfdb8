"""The histories of a fleet as a session for the rerun viewer: parameters with bands, findings and temperature over the days."""

from __future__ import annotations

from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from physident.fleet.drift.alarms import Alarm, Drift, alarm_text
from physident.graphics.session.axis_ranges import extent, in_title, with_margin
from physident.graphics.session.log import path_part, rgb
from physident.graphics.session.write import check_session_path
from physident.graphics.style import EXTENDED, OTHER, RESIDUAL, SESSION_MEASURED
from physident.outputs import write_with

if TYPE_CHECKING:
    import rerun as rr

Array = NDArray[np.float64]
TIMELINE = "day"
EPOCH = date(1970, 1, 1).toordinal()
DAY = 86400.0  # s
SHOWN = 20  # alarms that have a tab of their own
BESIDE = 5  # parameters of an arm that are shown beside its cause
CHANCE = 1.96  # standard deviations: 95 %


def write_drift_session(drift: Drift, path: Path) -> None:
    """Write the session, whole or not at all; raises InputError for a path that does not end in .rrd."""
    check_session_path(path)
    write_with(path, lambda file: _write(drift, file))


def _write(drift: Drift, path: Path) -> None:
    import rerun as rr

    rec = rr.RecordingStream("physident", recording_id="fleet", send_properties=False)
    memory = rec.memory_recording()
    rec.send_recording_name(f"fleet of {len(drift.arms)} arms")
    rec.log("summary", rr.TextDocument(_summary(drift), media_type="text/markdown"), static=True)
    for course in drift.courses:
        colour = RESIDUAL if any(alarm.arm == course.arm for alarm in drift.alarms) else SESSION_MEASURED
        _curve(rec, f"shifts/{path_part(course.arm)}", course.day, course.share, course.arm, colour)
    if drift.courses:
        ends = extent([course.day for course in drift.courses]) or (0.0, 1.0)
        _curve(rec, "shifts/limit", np.array(ends), np.ones(2), "what chance reaches", OTHER)
    for alarm in drift.alarms[:SHOWN]:
        _log_alarm(rec, drift, alarm)
    rec.send_blueprint(_blueprint(drift))
    rec.flush()
    session = memory.drain_as_bytes()
    rec.disconnect()
    path.write_bytes(session)


def _log_alarm(rec: rr.RecordingStream, drift: Drift, alarm: Alarm) -> None:
    import rerun as rr

    root, shown = f"arms/{path_part(alarm.arm)}", alarm.shown
    history, band = shown.history, CHANCE * shown.size
    _points(rec, f"{root}/cause/measured", history.day, history.change, "as measured", SESSION_MEASURED)
    without = "without temperature and load" if shown.conditions else "without the reference's mean"
    _curve(rec, f"{root}/cause/rest", history.day, shown.rest, without, EXTENDED)
    _curve(rec, f"{root}/cause/band/high", history.day, band, "upper end of chance, 95 %", OTHER)
    _curve(rec, f"{root}/cause/band/low", history.day, -band, "lower end of chance, 95 %", OTHER)
    first = np.flatnonzero(history.day == alarm.day.toordinal())
    _points(rec, f"{root}/cause/first", history.day[first], shown.rest[first], "first shown", RESIDUAL)
    for one in _beside(drift, alarm):
        place = f"{root}/others/{path_part(one.history.parameter)}"
        _curve(rec, place, one.history.day, one.rest / one.size, one.history.parameter, None)
    if np.isfinite(history.temperature).any():
        _curve(rec, f"{root}/temperature", history.day, history.temperature, "temperature", RESIDUAL)
    for one in drift.histories:
        if one.history.candidate == history.candidate:
            for k in np.flatnonzero(one.history.found).tolist():
                rec.set_time(TIMELINE, timestamp=_seconds(one.history.day[k]))
                text = f"{one.history.words}: {one.history.parameter} {one.history.change[k]:+.3g} {one.history.unit_text}".rstrip()
                rec.log(f"{root}/findings", rr.TextLog(text, level=rr.TextLogLevel.INFO))
    rec.set_time(TIMELINE, timestamp=_seconds(alarm.day.toordinal()))
    rec.log(f"{root}/findings", rr.TextLog(f"alarm: {alarm_text(alarm)}", level=rr.TextLogLevel.WARN))
    rec.reset_time()


def _beside(drift: Drift, alarm: Alarm) -> list[Any]:
    """The parameters of an arm that moved most, in standard deviations."""
    own = [one for one in drift.histories if one.history.arm == alarm.arm]
    return sorted(own, key=lambda one: -float(np.abs(one.rest / one.size).max()))[:BESIDE]


def _summary(drift: Drift) -> str:
    lines = [f"# {len(drift.alarms)} of {len(drift.arms)} arms need attention", ""]
    if drift.alarms:
        lines += ["| arm | first shown | cause |", "|---|---|---|"]
        lines += [f"| {alarm.arm} | {alarm.day} | {alarm_text(alarm)} |" for alarm in drift.alarms]
    lines += ["", f"At most {drift.rate:g} false alarms for each arm and year."]
    if drift.young:
        lines.append(f"\nNot watched yet, too few recordings: {', '.join(drift.young)}.")
    if drift.broken:
        lines.append(f"\n{len(drift.broken)} files cannot be used, such as {drift.broken[0].file}.")
    return "\n".join(lines)


def _blueprint(drift: Drift) -> Any:
    import rerun.blueprint as rrb

    days = extent([one.history.day for one in drift.histories]) or (0.0, 1.0)
    tabs: list[Any] = [
        _plot("/shifts", "largest shift of each arm, over what chance reaches", days, None, legend=False)
    ]
    tabs += [_tab(alarm, days) for alarm in drift.alarms[:SHOWN]]
    summary = rrb.TextDocumentView(origin="/summary", name="fleet")
    return rrb.Blueprint(
        rrb.Horizontal(summary, rrb.Tabs(*tabs, active_tab=min(1, len(tabs) - 1)), column_shares=[1, 2]),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="paused"),
    )


def _tab(alarm: Alarm, days: tuple[float, float]) -> Any:
    import rerun.blueprint as rrb

    root, shown = f"/arms/{path_part(alarm.arm)}", alarm.shown
    history = shown.history
    ends = extent([history.change, shown.rest, CHANCE * shown.size, -CHANCE * shown.size])
    cause = f"{alarm.words}: change of {history.parameter}, {in_title(ends, history.unit_text)}"
    views: list[Any] = [
        _plot(f"{root}/cause", cause, days, ends),
        _plot(f"{root}/others", "parameters that moved most, in standard deviations", days, None),
    ]
    shares = [3.0, 2.0]
    if (warm := extent([history.temperature])) is not None:
        views.append(_plot(f"{root}/temperature", f"temperature, {in_title(warm, 'degC')}", days, warm, legend=False))
        shares.append(1.2)
    findings = rrb.TextLogView(origin=f"{root}/findings", name="findings up to the day of the timeline")
    return rrb.Vertical(*views, findings, row_shares=[*shares, 1.2], name=alarm.arm)


def _plot(
    origin: str, name: str, days: tuple[float, float], ends: tuple[float, float] | None, legend: bool = True
) -> Any:
    import rerun as rr
    import rerun.blueprint as rrb

    whole = rr.TimeRange(
        start=rr.TimeRangeBoundary.absolute(seconds=_seconds(days[0])),
        end=rr.TimeRangeBoundary.absolute(seconds=_seconds(days[1])),
    )
    return rrb.TimeSeriesView(
        origin=origin, name=name, axis_x=rrb.TimeAxis(view_range=whole, link=rrb.components.LinkAxis.Independent),
        axis_y=None if ends is None else rrb.ScalarAxis(range=with_margin(ends)),
        plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop, visible=legend),
    )  # fmt: skip


def _seconds(day: float) -> float:
    """Seconds since 1970 of a day since the year 1."""
    return (float(day) - EPOCH) * DAY


def _times(day: Array) -> Any:
    import rerun as rr

    return rr.TimeColumn(TIMELINE, timestamp=(np.asarray(day) - EPOCH) * DAY)


def _curve(rec: rr.RecordingStream, path: str, day: Array, values: Array, name: str, colour: str | None) -> None:
    import rerun as rr

    colours = None if colour is None else [rgb(colour)]
    rec.log(path, rr.SeriesLines(colors=colours, names=[name], widths=[1.5]), static=True)
    rec.send_columns(path, [_times(day)], rr.Scalars.columns(scalars=values))


def _points(rec: rr.RecordingStream, path: str, day: Array, values: Array, name: str, colour: str) -> None:
    import rerun as rr

    rec.log(path, rr.SeriesPoints(colors=[rgb(colour)], names=[name], marker_sizes=[3.0]), static=True)
    rec.send_columns(path, [_times(day)], rr.Scalars.columns(scalars=values))
