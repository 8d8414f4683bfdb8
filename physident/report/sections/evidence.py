"""The strength of the evidence: each finding beside the threshold, and the placebos, which must stay below it."""

from __future__ import annotations

import math

from markupsafe import Markup

from physident.diagnosis.result.record import DiagnosisRecord
from physident.diagnosis.result.wording import cause
from physident.graphics.style import effect_colour
from physident.report.chart import swatch
from physident.report.markup import joined, table, tag
from physident.report.numbers import number

SCALE_END = 1.08  # of the largest evidence
MARGIN = 3  # % of the scale, so that a mark at its end is visible


def evidence(c: DiagnosisRecord) -> list[Markup]:
    """A scale with the threshold, the placebos and the findings, and a table of the same numbers."""
    if not c.placebos:
        return []
    threshold = c.placebos[0].threshold
    best = max(p.gain for p in c.placebos)
    passed = sum(p.passed for p in c.placebos)
    text = (
        "Evidence is what an effect explains on rows that were left out of the fit, in units of the noise. The threshold is"
        " what the best effect of the whole catalogue exceeds in at most 1 of 100 cases on phase-randomised copies of the"
        " residual, which have its spectrum but no relation to the motion. Placebos are columns that cannot be a cause, so"
        " they must stay below the threshold. The evidence of a finding on several joints is a sum over them."
    )
    head = ["", "evidence", "times the threshold"]
    rows: list[list[str]] = [
        [
            joined(swatch(effect_colour(f.effect)), cause(f.effect, f.joints)),
            number(f.evidence),
            number(f.evidence / threshold, 2) if threshold > 0 else "–",
        ]
        for f in c.findings
    ]
    rows += [
        ["threshold", number(threshold), "1"],
        [
            f"best of {len(c.placebos)} placebos ({passed} above the threshold)",
            number(best),
            number(best / threshold, 2) if threshold > 0 else "–",
        ],
    ]
    return [
        tag("section", tag("h2", "Evidence"), tag("p", text), _scale(c, threshold), table(head, rows, class_="numbers"))
    ]


def _scale(c: DiagnosisRecord, threshold: float) -> Markup:
    """Marks on a square-root scale, on which placebos near zero and strong findings are both visible."""
    top = SCALE_END * max(threshold, 1.0, *(f.evidence for f in c.findings), *(p.gain for p in c.placebos))

    def at(value: float) -> str:
        return f"left:{MARGIN + (100 - 2 * MARGIN) * math.sqrt(max(value, 0.0) / top):.1f}%"

    marks = [tag("b", "×", style=at(p.gain)) for p in c.placebos]
    marks += [tag("i", style=f"{at(f.evidence)};background:{effect_colour(f.effect)}") for f in c.findings]
    labels = [tag("span", number(x, 1), style=at(x)) for x in _round_numbers(top, threshold)]
    return tag(
        "div",
        tag("div", tag("u", style=at(threshold)), *marks, class_="marks"),
        tag("div", *labels, tag("span", "threshold", style=at(threshold), class_="threshold"), class_="columns"),
        tag("div", "evidence [noise units], square-root scale; × placebo (negative ones are drawn at zero), ● finding", class_="below"),
        class_="scale",
        role="img",
        aria_label="evidence of findings and placebos beside the threshold",
    )  # fmt: skip


def _round_numbers(top: float, threshold: float) -> list[float]:
    """Zero and some round numbers whose labels overlap neither the threshold's nor one another."""
    chosen = [0.0]
    for power in range(-1, 12):
        for value in (1.0 * 10**power, 3.0 * 10**power):
            clear = all(
                abs(math.sqrt(value) - math.sqrt(max(other, 0.0))) > 0.14 * math.sqrt(top)
                for other in (*chosen, threshold)
            )
            if value < top and clear:
                chosen.append(value)
    return chosen
