"""Each finding: the effect, its gain, its parameters with intervals and units, and its rivals."""

from __future__ import annotations

import inspect

import numpy as np
from markupsafe import Markup

from physident.diagnosis.result.advice import own_notes
from physident.diagnosis.result.findings import CurveBand, Finding, ParameterValue, Rival
from physident.diagnosis.result.record import DiagnosisRecord
from physident.diagnosis.result.wording import cause, in_words, listed, sense_in_words, trust_in_words
from physident.effects.catalogue import CATALOGUE, effect_label
from physident.graphics.style import OTHER, effect_colour
from physident.report.chart import Line, line_chart
from physident.report.markup import joined, table, tag
from physident.report.numbers import number, percent, quantity


def causes(c: DiagnosisRecord) -> list[Markup]:
    """One card for each finding, in the order of the diagnosis."""
    if not c.findings:
        return []
    cards = [_card(c, n, finding) for n, finding in enumerate(c.findings, 1)]
    return [tag("section", tag("h2", "What was found"), tag("div", *cards, class_="cards"))]


def lacked_before(c: DiagnosisRecord) -> list[Markup]:
    """What the model's own recordings show too, or differ by: no change that is shown, and a part of the extended model."""
    if not c.missing_since_before:
        return []
    items = [tag("li", _lacked(f)) for f in c.missing_since_before]
    why = "The model's own recordings show this, or differ among themselves by as much: nothing shows that it has changed."
    return [tag("section", tag("h2", "What the model lacked before, too"), tag("p", why), tag("ul", *items))]


def _lacked(f: Finding) -> Markup:
    title, words = cause(f.effect, f.joints), in_words(f.in_words)
    new = "less than half of it was there before, but this is no proven change" if f.mostly_new else ""
    more = [one for one in (f.confounder, new) if one]
    reasons = "; ".join(filter(None, [words.removesuffix(".") if more else words, *more]))
    return joined(tag("strong", f"{title[0].upper()}{title[1:]}"), f": {reasons}" if reasons else "")


def _card(c: DiagnosisRecord, n: int, f: Finding) -> Markup:
    effect = CATALOGUE[f.effect]
    equation = (inspect.getdoc(effect) or "").split("\n\n")[0].replace("``", "")
    joints = [c.model.robot.joints[j - 1] for j in f.joints]
    if joints and all(joint.kind == "prismatic" for joint in joints):
        equation = joints[0].unit(equation)
    title = cause(f.effect, f.joints)
    return tag(
        "article",
        tag("h3", f"{n}. {title[0].upper()}{title[1:]}"),
        *([tag("p", f"How it shows: {effect.signature}.")] if effect.signature else []),
        *([tag("p", f"{words[0].upper()}{words[1:]}")] if (words := in_words(sense_in_words(f))) else []),
        *(_curve(c, curve) for curve in f.curves),
        tag("p", *_gain(c, f)),
        *([tag("p", f"It lasts {_times(f)} by the clock of {_recording(c, f)}.")] if f.intervals else []),
        *_trust(f),
        *_parameters(f),
        *_rivals(f),
        *([tag("p", in_words(notes))] if (notes := own_notes(f)) else []),
        tag("p", tag("code", f.effect), f": {equation}", class_="fine"),
        style=f"border-color:{effect_colour(f.effect)}",
    )


def _curve(c: DiagnosisRecord, curve: CurveBand) -> Markup:
    """A learned curve with the ends of its 95 % band."""
    x, unit = np.array(curve.x), c.model.robot.torque_units[curve.joint - 1]
    ends = [Line("95 % band", x, np.array(values), "#999999", 0.8) for values in (curve.low, curve.high)]
    middle = Line("learned", x, np.array(curve.torque), OTHER, 1.6)
    title = f"Joint {curve.joint}: learned torque with its 95 % band"
    return line_chart([*ends, middle], unit, title, over=f"{curve.quantity} [{curve.unit}]")


def _gain(c: DiagnosisRecord, f: Finding) -> list[str]:
    units = {c.model.robot.torque_units[j - 1] for j in f.joints} or {*c.model.robot.torque_units}
    unit, (low, high) = " or ".join(sorted(units)), f.gain.interval95
    return [
        "On rows that were left out of the fit, it reduces the noise-weighted error where it shows from ",
        f"{number(f.gain.rms_before)} to {quantity(f.gain.rms_after, unit)} RMS: ",
        tag("strong", f"{percent(f.gain.reduction_percent)} less"),
        f" (95 % interval {percent(low)} to {percent(high)}).",
    ]


def _trust(f: Finding) -> list[Markup]:
    """The grade of what is no cause and why, how stable the finding is, and what else could be behind it."""
    text = trust_in_words(f)
    rows = [tag("p", text)] if text else []
    return [
        *rows,
        *([tag("p", f"{f.confounder[0].upper()}{f.confounder[1:]}.", class_="caution")] if f.confounder else []),
    ]


def _times(f: Finding) -> str:
    return listed([f"from {start:.2f} to {end:.2f} s" for start, end in f.intervals])


def _recording(c: DiagnosisRecord, f: Finding) -> str:
    paths = [used.path for used in c.recordings if used.sha256 == f.recording]
    return c.short_name(paths[0]) if paths else "its recording"


def _parameters(f: Finding) -> list[Markup]:
    if not f.parameters:
        return []
    changed = any(v.change != v.value for v in f.parameters)
    last = ["change", "95 % interval of the change"] if changed else ["95 % interval"]
    head = ["parameter", *(["joint"] if f.joints or f.by_joint else []), "value", *last]
    return [table(head, [_row(f, v, changed) for v in f.parameters], class_="numbers")]


def _row(f: Finding, v: ParameterValue, changed: bool) -> list[str]:
    low, high = v.change_interval95
    row = [effect_label(v.name), *([str(v.joint)] if f.joints or f.by_joint else [])]
    if v.is_open:
        return [*row, "not known", *([""] if changed else []), ""]
    interval = joined(f"{number(low)} to {quantity(high, v.unit)}", *_zero(low, high), *_end(v))
    change = [quantity(v.change, v.unit, sign=True)] if changed else []
    return [*row, quantity(v.value, v.unit), *change, interval]


def _end(v: ParameterValue) -> list[Markup]:
    return [tag("small", " at the end of the search range")] if v.at_end else []


def _zero(low: float, high: float) -> list[Markup]:
    return [tag("small", " includes zero")] if low < 0 < high else []


def _rivals(f: Finding) -> list[Markup]:
    if not f.rivals:
        return []
    others = " or ".join(_instead(f, r) for r in f.rivals)
    return [
        tag(
            "p",
            tag("strong", "It could also be "),
            f"{others}. These recordings cannot separate them.",
            class_="caution",
        )
    ]


def _instead(f: Finding, r: Rival) -> str:
    """A rival, with a note where it could replace a part of the finding only."""
    part = len(r.joints) < len(f.joints) and set(r.joints) < set(f.joints)
    return cause(r.effect, r.joints) + (", for that part of the finding" if part else "")
