"""The page of a fleet: which arms need attention and why, with a figure each; it needs no network."""

from __future__ import annotations

import base64
import io
from datetime import date
from pathlib import Path
from typing import Any

from markupsafe import Markup

from physident.files import VERSION
from physident.fleet.drift.alarms import Alarm, Drift, alarm_text
from physident.fleet.drift.conditions import REFERENCE
from physident.graphics.style import MEASURED, OTHER, RESIDUAL, SETTINGS
from physident.outputs import write_with
from physident.report.markup import table, tag
from physident.report.stylesheet import STYLE

MOST_BROKEN = 50  # files that are listed


def write_page(drift: Drift, path: Path) -> None:
    """Write the page, whole or not at all."""
    text = "<!doctype html>\n" + str(page(drift))
    write_with(path, lambda file: file.write_text(text, encoding="utf-8"))


def page(drift: Drift) -> Markup:
    """The page as HTML."""
    count, bad = len(drift.arms), len(drift.alarms)
    verdict = f"{bad} of {count} arms need attention" if bad else f"none of {count} arms needs attention"
    parts = [
        tag("h1", f"Fleet: {verdict}"),
        tag(
            "p",
            f"Each parameter of each arm is compared with the arm's own first {REFERENCE} recordings, after what temperature and load explain."
            f" The limits allow at most {drift.rate:g} false alarms for each arm and year, over all its parameters together.",
            class_="lead",
        ),
    ]
    if drift.alarms:
        head = ["arm", "first shown", "since about", "cause", "strength"]
        rows = [
            [a.arm, str(a.day), str(a.since), alarm_text(a), f"{a.strength:.1f} (chance: {a.limit:.1f})"]
            for a in drift.alarms
        ]
        parts += [table(head, rows), *(_figure(drift, alarm) for alarm in drift.alarms)]
    if drift.young:
        parts += [tag("h2", "Not watched yet"), tag("p", f"Too few recordings: {', '.join(drift.young)}.")]
    if drift.broken:
        rows = [[one.arm, one.file, one.reason] for one in drift.broken[:MOST_BROKEN]]
        parts += [tag("h2", f"Files that cannot be used: {len(drift.broken)}"), table(["arm", "file", "reason"], rows)]
    head_part = tag(
        "head",
        tag("meta", charset="utf-8"),
        tag("meta", name="viewport", content="width=device-width, initial-scale=1"),
        tag("meta", name="generator", content=f"physident {VERSION}"),
        tag("title", f"Fleet: {verdict}"),
        tag("style", Markup(STYLE)),
    )
    return tag("html", head_part, tag("body", tag("main", *parts)), lang="en")


def _figure(drift: Drift, alarm: Alarm) -> Markup:
    image = base64.b64encode(draw(drift, alarm)).decode()
    return tag(
        "article",
        tag("h3", f"{alarm.arm}: {alarm.words}"),
        tag("img", src=f"data:image/png;base64,{image}", alt=alarm_text(alarm), style="max-width:100%"),
    )


def draw(drift: Drift, alarm: Alarm) -> bytes:
    """A figure of an alarm as PNG: the parameter with its band, as measured and without what conditions explain, and the temperature."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    shown, history = alarm.shown, alarm.shown.history
    days: list[Any] = [date.fromordinal(int(day)) for day in history.day]
    with plt.rc_context(SETTINGS):
        figure, (top, bottom) = plt.subplots(2, 1, figsize=(9, 4.6), sharex=True, height_ratios=(3, 1))
        band = 1.96 * shown.size
        top.fill_between(days, -band, band, color=OTHER, alpha=0.15, label="chance, 95 %")
        top.plot(days, history.change, "o", color="#9a9a9a", markersize=3, label="change since the baseline")
        top.errorbar(
            days, shown.rest, 1.96 * history.std, fmt="o-", color=MEASURED, markersize=3, linewidth=0.8,
            label="without temperature and load" if shown.conditions else "without the reference's mean",
        )  # fmt: skip
        first: Any = alarm.day
        top.axvline(first, color=RESIDUAL, linewidth=1.2, label="first shown")
        seen = days.index(first)
        top.plot([first], [shown.rest[seen]], "o", color=RESIDUAL, markersize=8, fillstyle="none")
        top.set_ylabel(f"{history.parameter} [{history.unit}]")
        top.legend(fontsize=7, ncols=2)
        bottom.plot(days, history.temperature, "o-", markersize=2, linewidth=0.8, color="#D55E00")
        bottom.set_ylabel("[degC]")
        figure.tight_layout()
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", metadata={"Software": None})
        plt.close(figure)
    return buffer.getvalue()
