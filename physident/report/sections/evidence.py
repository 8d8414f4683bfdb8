"""How strong the evidence is: every finding's gain beside the gate it had to pass, and the placebos that must not."""

from __future__ import annotations

import math

from physident.diagnosis.result.saved import Contents
from physident.diagnosis.result.wording import cause
from physident.graphics.style import effect_colour
from physident.report.chart import swatch
from physident.report.markup import Markup, joined, table, tag
from physident.report.numbers import number

ROOM = 1.08  # of the greatest gain: the scale's end
MARGIN = 3  # %: a mark at the scale's end stays on it


def evidence(c: Contents) -> list[Markup]:
    """A scale with the gate, the placebos and the findings, and the same as numbers."""
    if not c.placebos:
        return []
    gate = c.placebos[0].threshold
    best = max(p.gain for p in c.placebos)
    passed = sum(p.passed for p in c.placebos)
    text = (
        "Evidence is what an effect explains on rows that were left out of the fit, in units of the noise. The gate is what"
        " the luckiest effect of the whole catalogue reaches, in 99 of 100 cases at most, when the residual keeps its"
        " spectrum but loses its relation to the motion. Placebos are columns that cannot be a cause; they must fail. A finding on several joints has the sum of theirs."
    )
    head = ["", "evidence", "times the gate"]
    rows: list[list[str]] = [
        [
            joined(swatch(effect_colour(f.effect)), cause(f.effect, f.joints)),
            number(f.evidence),
            number(f.evidence / gate, 2) if gate > 0 else "–",
        ]
        for f in c.findings
    ]
    rows += [
        ["the gate", number(gate), "1"],
        [
            f"best of {len(c.placebos)} placebos ({passed} passed)",
            number(best),
            number(best / gate, 2) if gate > 0 else "–",
        ],
    ]
    return [tag("section", tag("h2", "Evidence"), tag("p", text), _scale(c, gate), table(head, rows, class_="numbers"))]


def _scale(c: Contents, gate: float) -> Markup:
    """Marks on a scale whose distances are square roots, so that placebos near zero and strong findings both show."""
    top = ROOM * max(gate, 1.0, *(f.evidence for f in c.findings), *(p.gain for p in c.placebos))

    def at(value: float) -> str:
        return f"left:{MARGIN + (100 - 2 * MARGIN) * math.sqrt(max(value, 0.0) / top):.1f}%"

    marks = [tag("b", "×", style=at(p.gain)) for p in c.placebos]
    marks += [tag("i", style=f"{at(f.evidence)};background:{effect_colour(f.effect)}") for f in c.findings]
    labels = [tag("span", number(x), style=at(x)) for x in _round(top, gate)]
    return tag(
        "div",
        tag("div", tag("u", style=at(gate)), *marks, class_="marks"),
        tag("div", *labels, tag("span", "gate", style=at(gate), class_="gate"), class_="columns"),
        tag("div", "evidence [noise units], square-root scale; × placebo (below zero drawn at zero), ● finding", class_="below"),
        class_="scale",
        role="img",
        aria_label="evidence of findings and placebos beside the gate",
    )  # fmt: skip


def _round(top: float, gate: float) -> list[float]:
    """Zero and some round numbers that keep clear of the gate's label and of one another."""
    chosen = [0.0]
    for power in range(-1, 12):
        for value in (1.0 * 10**power, 3.0 * 10**power):
            clear = all(
                abs(math.sqrt(value) - math.sqrt(max(other, 0.0))) > 0.14 * math.sqrt(top) for other in (*chosen, gate)
            )
            if value < top and clear:
                chosen.append(value)
    return chosen
