"""The strength of the evidence: each finding in units of what it had to exceed, and the placebos, which must stay below it."""

from __future__ import annotations

import math

from markupsafe import Markup

from physident.diagnosis.result.findings import Finding, Placebo
from physident.diagnosis.result.record import DiagnosisRecord
from physident.diagnosis.result.wording import cause
from physident.graphics.style import effect_colour
from physident.report.chart import swatch
from physident.report.markup import joined, table, tag
from physident.report.numbers import number

SCALE_END = 1.08  # of the strongest finding
MARGIN = 3  # % of the scale, so that a mark at its end is visible


def evidence(c: DiagnosisRecord) -> list[Markup]:
    """A scale with the placebos and the findings in units of their thresholds, and a table of the same numbers."""
    if not c.placebos:
        return []
    nearest = max(c.placebos, key=lambda p: p.gain - p.threshold)
    passed = sum(p.passed for p in c.placebos)
    text = (
        "Evidence is what an effect explains on rows that were left out of the fit, in units of the noise. The threshold is"
        " what the best effect of the whole catalogue exceeds in at most 1 of 100 cases on phase-randomised copies of the"
        " residual, which have its spectrum but no relation to the motion; a contact has its own, and so have the last joints of"
        " an effect that most joints have. Placebos are columns that cannot be a cause, so they must stay below the threshold."
        " Evidence and threshold of a finding on several joints are sums over them."
    )
    head = ["", "evidence", "threshold", "times the threshold"]
    rows: list[list[str]] = [
        [joined(swatch(effect_colour(f.effect)), cause(f.effect, f.joints)), number(f.evidence), *_against(f)]
        for f in c.findings
    ]
    name = f"nearest of {len(c.placebos)} placebos ({passed} above the threshold)"
    rows.append([name, number(nearest.gain), *_against(nearest)])
    return [tag("section", tag("h2", "Evidence"), tag("p", text), _scale(c), table(head, rows, class_="numbers"))]


def _against(one: Finding | Placebo) -> list[str]:
    """The threshold, and the evidence in units of it; dashes where these are not known."""
    times = _times(one)
    known = "–" if one.threshold is None else number(one.threshold)
    return [known, "–" if times is None else number(times, 2)]


def _times(one: Finding | Placebo) -> float | None:
    """Evidence in units of the threshold; None where there is none, as in a file of an earlier version."""
    evidence = one.gain if isinstance(one, Placebo) else one.evidence
    return evidence / one.threshold if one.threshold else None


def _scale(c: DiagnosisRecord) -> Markup:
    """Marks on a square-root scale, on which placebos near zero and strong findings are both visible."""
    placebos = [times for p in c.placebos if (times := _times(p)) is not None]
    findings = [(f, times) for f in c.findings if (times := _times(f)) is not None]
    top = SCALE_END * max(1.0, *(times for _, times in findings), *placebos)

    def at(value: float) -> str:
        return f"left:{MARGIN + (100 - 2 * MARGIN) * math.sqrt(max(value, 0.0) / top):.1f}%"

    marks = [tag("b", "×", style=at(times)) for times in placebos]
    marks += [tag("i", style=f"{at(times)};background:{effect_colour(f.effect)}") for f, times in findings]
    labels = [tag("span", number(x, 1), style=at(x)) for x in _round_numbers(top)]
    return tag(
        "div",
        tag("div", tag("u", style=at(1.0)), *marks, class_="marks"),
        tag("div", *labels, tag("span", "threshold", style=at(1.0), class_="threshold"), class_="columns"),
        tag("div", "evidence [times its threshold], square-root scale; × placebo (negative ones are drawn at zero), ● finding", class_="below"),
        class_="scale",
        role="img",
        aria_label="evidence of findings and placebos beside their thresholds",
    )  # fmt: skip


def _round_numbers(top: float) -> list[float]:
    """Zero and some round numbers whose labels overlap neither the threshold's, which is at 1, nor one another."""
    chosen = [0.0]
    for power in range(-1, 12):
        for value in (1.0 * 10**power, 3.0 * 10**power):
            clear = all(abs(math.sqrt(value) - math.sqrt(other)) > 0.14 * math.sqrt(top) for other in (*chosen, 1.0))
            if value < top and clear:
                chosen.append(value)
    return chosen
