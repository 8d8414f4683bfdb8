"""Measured and predicted torque of the diagnosed and of the extended model, and the residual of both, joint by joint."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from physident.diagnosis.result.record import DiagnosisRecord
from physident.diagnosis.result.wording import AS_IT_WAS, EXTENDED, listed
from physident.effects.contact import Contact
from physident.errors import InputError
from physident.graphics import style
from physident.report.chart import Line, legend, line_chart
from physident.report.markup import tag
from physident.report.numbers import arrow, change, percent
from physident.report.reread import Reread
from physident.validation.comparison import Pair, predict_pair

MAX_DRAWN = 2  # recordings


def torques(c: DiagnosisRecord, recordings: Sequence[Reread]) -> Markup:
    """Charts of the recordings that could be read again, and a note for each other one."""
    drawn = _chosen(c, recordings)
    lost = [one for one in recordings if one.recording is None]
    notes = []
    if lost:
        missing = listed([f"{c.short_name(one.used.path)} ({one.status})" for one in lost])
        notes.append(tag("p", f"Curves are missing of {missing}."))
    if more := [c.short_name(one.used.path) for one in recordings if one not in drawn and one not in lost]:
        notes.append(tag("p", f"Read again but not drawn: {', '.join(more)}.", class_="fine"))
    if not drawn:
        notes.insert(0, tag("p", tag("strong", "No torque is drawn: none of the recordings could be read again.")))
    charts = [part for one in drawn for part in _charts(c, one)]
    return tag("section", tag("h2", "Torque, measured and predicted"), *charts, *notes)


def _chosen(c: DiagnosisRecord, recordings: Sequence[Reread]) -> list[Reread]:
    """The recordings to draw: first those with a contact that was found, then the holdouts, then one diagnosed recording."""
    with_contact = {e.recording for e in (c.extended.effects if c.extended else ()) if isinstance(e, Contact)}
    available = [one for one in recordings if one.recording is not None and one.used.role != "before"]
    rank = sorted(available, key=lambda one: (one.used.sha256 not in with_contact, one.used.role != "holdout"))
    wanted = [one for one in rank if one.used.sha256 in with_contact or one.used.role == "holdout"]
    return (wanted or rank[:1])[:MAX_DRAWN]


def _charts(c: DiagnosisRecord, one: Reread) -> list[Markup]:
    assert one.recording is not None
    head = tag("h3", c.short_name(one.used.path))
    try:
        pair = predict_pair(c.model, c.extended, [one.recording], c.filter, c.drive_gains)
    except InputError as error:
        return [head, tag("p", f"Read again, but its torque cannot be predicted: {error}.")]
    names = [("measured", style.MEASURED), (AS_IT_WAS, style.AS_IT_WAS)]
    if pair.after is not None:
        names.append((EXTENDED, style.EXTENDED))
    text = "that no model was fitted to" if one.used.role == "holdout" else "that was diagnosed"
    bands = _bands(c, one.used.sha256)
    shaded = " Shaded: contact." if bands else ""
    start = float(one.recording.time[0])
    return [
        head,
        tag("p", f"A recording {text}. The torque is low-passed and shown where the arm moves.{shaded}"),
        legend(names),
        tag("div", *(_joint(c, pair, j, start, bands) for j in range(c.model.robot.n)), class_="joints"),
    ]


def _bands(c: DiagnosisRecord, sha256: str) -> list[tuple[float, float]]:
    effects = c.extended.effects if c.extended is not None else ()
    found = [e for e in effects if isinstance(e, Contact) and e.recording in ("", sha256)]
    return [interval for effect in found for interval in effect.intervals]


def _joint(c: DiagnosisRecord, pair: Pair, j: int, start: float, bands: Sequence[tuple[float, float]]) -> Markup:
    unit, robot = c.model.robot.torque_units[j], c.model.robot
    rows = np.flatnonzero(pair.before.counted[:, j])
    title = f"Joint {j + 1}, {robot.joint_names[j]}"
    if not len(rows):
        return tag("figure", tag("figcaption", f"{title}: no row with motion"))
    time = pair.before.time[rows] - start
    looks = ((AS_IT_WAS, style.AS_IT_WAS, 2.0), (EXTENDED, style.EXTENDED, 1.0))  # coinciding lines lie in one another
    predicted, residuals = [], []
    for p, (name, colour, width) in zip(pair.both, looks, strict=False):
        predicted.append(Line(name, time, (p.measured - p.residual)[rows, j], colour, width))
        residuals.append(Line(name, time, p.residual[rows, j], colour, width))
    measured = Line("measured", time, pair.before.measured[rows, j], style.MEASURED, 3.0)
    sizes = [float(p.rms[j]) for p in pair.both]
    text = arrow(sizes, unit)
    changed = f" ({percent(change(sizes[0], sizes[-1]), sign=True)})" if len(sizes) > 1 else ""
    return tag(
        "figure",
        tag("figcaption", tag("strong", title), f" residual {text} RMS{changed}"),
        line_chart([measured, *predicted], unit, "torque", bands),
        line_chart(residuals, unit, "residual", bands),
    )
