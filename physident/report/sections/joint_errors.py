"""The error of each joint before and after, as bars on one scale and as numbers."""

from __future__ import annotations

import numpy as np
from markupsafe import Markup

from physident.diagnosis.result.record import DiagnosisRecord
from physident.diagnosis.result.wording import AS_IT_WAS, EXTENDED
from physident.graphics import style
from physident.report.chart import legend
from physident.report.markup import tag
from physident.report.numbers import SPACE, arrow, change, percent, quantity
from physident.report.sections.answer import judged_on

FLOOR = " The floor is the part of the torque that differs between repetitions of the same motion: no model can get far below it."


def joint_errors(c: DiagnosisRecord) -> Markup:
    """A row for each joint: relative error as bars, RMS in the unit of its torque."""
    largest = float(max(np.max(c.before.relative), np.max(c.after.relative))) or 1.0
    names = [(AS_IT_WAS, style.AS_IT_WAS)]
    if c.extended is not None:
        names.append((EXTENDED, style.EXTENDED))
    return tag(
        "section",
        tag("h2", "Each joint before and after" if c.extended is not None else "The error of each joint"),
        tag(
            "p",
            f"On {judged_on(c)}. The bars show the relative error, 100 |measured − predicted| / |measured|,"
            f" after a low-pass at {c.filter.cutoff:g}{SPACE}Hz on both sides.",
            FLOOR if c.noise_floor is not None else "",
        ),
        *([] if c.simulated is None else [tag("p", f"{c.simulated.sentence[:1].upper()}{c.simulated.sentence[1:]}.")]),
        legend(names),
        tag("div", *(_row(c, j, largest) for j in range(c.model.robot.n)), class_="levels"),
    )


def _row(c: DiagnosisRecord, j: int, largest: float) -> Markup:
    unit = c.model.robot.torque_units[j]
    shown = [(c.before, style.AS_IT_WAS), (c.after, style.EXTENDED)][: 2 if c.extended is not None else 1]
    bars = [
        tag("div", tag("i", style=f"width:{100 * x.relative[j] / largest:.1f}%;background:{colour}"), class_="bar")
        for x, colour in shown
    ]
    relative = " → ".join(percent(x.relative[j]).removesuffix(f"{SPACE}%") for x, _ in shown) + f"{SPACE}%"
    rms = arrow([x.rms[j] for x, _ in shown], unit)
    changed = percent(change(c.before.rms[j], c.after.rms[j]), sign=True)
    return tag(
        "div",
        tag("div", tag("strong", f"Joint {j + 1}"), f" {c.model.robot.joint_names[j]}", class_="name"),
        tag("div", *bars, class_="bars"),
        tag("div", relative, class_="cell"),
        tag(
            "div",
            rms,
            " RMS",
            *([f" ({changed})"] if c.extended is not None else []),
            *_floor(c, j, unit),
            class_="cell",
        ),
        class_="level",
    )


def _floor(c: DiagnosisRecord, j: int, unit: str) -> list[Markup]:
    return [] if c.noise_floor is None else [tag("div", f"floor {quantity(c.noise_floor[j], unit)}", class_="fine")]
