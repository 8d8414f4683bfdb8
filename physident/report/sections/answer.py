"""The answer: the verdict in words, the gain, and how far both can be trusted."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import date

import numpy as np
from markupsafe import Markup

from physident.diagnosis.result.record import DiagnosisRecord
from physident.diagnosis.result.wording import (
    SET_UP_FIRST,
    cause,
    incomplete_words,
    listed,
    parts_of,
    placebos_in_words,
    wrong_unseen_sentence,
)
from physident.report.markup import joined, tag
from physident.report.numbers import SPACE, change, number, percent, quantity
from physident.report.reread import Reread
from physident.report.sections.arm import arm_picture
from physident.report.sections.practice import OLD, UNCHANGED, UNSETTLED, WITHOUT_CAUSE, practice

GOOD = ("explained", "nothing has changed", "nothing is missing")  # outcomes that ask for nothing
WORSE = 1.0  # %: a smaller rise is not mentioned


def answer(c: DiagnosisRecord, recordings: Sequence[Reread], day: date) -> Markup:
    """The head of the page: the answer in words, what to do, and the arm with the joints of each cause."""
    doubtful = c.verdict != "unexplained" and c.outcome not in GOOD  # it is not marked as good
    mark = tag("b", c.outcome, class_="partly_explained" if doubtful else c.verdict)
    text = tag(
        "div",
        tag("p", f"Diagnosis of {c.model.robot.name}, {day.day} {day:%B %Y}", " ", mark, class_="mark"),
        tag("h1", c.headline),
        *_practice(c),
        tag("p", *_gains(c), c.remainder, class_="lead"),
        *_cautions(c),
    )
    return tag("header", text, arm_picture(c, recordings))


def _practice(c: DiagnosisRecord) -> list[Markup]:
    """One sentence for each cause, or for the verdict where there is none: what it means, and what to do."""
    if c.grown:
        joints = f"joint{'s' if len(c.grown) > 1 else ''} {listed([one.joint for one in c.grown])}"
        when = " at the times that stand under “What could not be seen”" if any(one.bursts for one in c.grown) else ""
        far = (
            "" if c.compared else ", and at whether this motion goes where none of the model's own recordings has been"
        )
        return [tag("p", f"Look at {joints}{when}{far}.", class_="practice")]
    if not c.causes:
        lesser = bool(parts_of(c.findings))
        if c.verdict == "nothing_missing" and c.question == "different" and not lesser:
            said = UNCHANGED if c.unchanged else UNSETTLED
            return [tag("p", said, OLD if c.missing_since_before else "", class_="practice")]
        said = WITHOUT_CAUSE["partly_explained" if lesser else c.verdict]
        return [tag("p", said, class_="practice")]
    items = [
        tag(
            "li",
            tag("strong", f"{name[0].upper()}{name[1:]}. "),
            practice(f.effect, [r.effect for r in f.rivals if r.inseparable]),
        )
        for f in c.causes
        if (name := cause(f.effect, f.joints))
    ]
    return [tag("ul", *items, class_="practice")]


def judged_on(c: DiagnosisRecord) -> str:
    """The rows that the errors before and after are computed on."""
    if c.scored_on != "holdout":
        return "rows of the diagnosed recordings that were left out while fitting"
    files = [c.short_name(used.path) for used in c.recordings if used.role == "holdout"]
    return f"{listed(files) if len(files) < 4 else f'{len(files)} recordings'}, which no model was fitted to"


def _gains(c: DiagnosisRecord) -> list[str]:
    if not c.findings:
        return []
    if c.extended is None:
        if any(not f.handed_on for f in c.findings):
            return [f"On {judged_on(c)}, the extended model would err more, so there is none. "]
        return ["What was found is not certain enough to be added to the model. "]
    units, before, after = c.model.robot.torque_units, c.before.rms, c.after.rms
    moved = np.array([change(b, a) for b, a in zip(before, after, strict=True)])
    best = int(np.argmin(moved))
    if moved[best] >= 0:
        return [f"On {judged_on(c)}, the extended model is no better on any joint. "]
    text = (
        f"On {judged_on(c)}, the torque error of joint{SPACE}{best + 1} falls by {percent(-moved[best])},"
        f" from {number(before[best])} to {quantity(after[best], units[best])} RMS"
    )
    others = [f"{j + 1} (by {percent(-m)})" for j, m in enumerate(moved) if m < -5 and j != best]
    text += f", and of joint{'s' if len(others) > 1 else ''} {listed(others)}." if others else "."
    worse = [f"{j + 1} (by {percent(m)})" for j, m in enumerate(moved) if m > WORSE]
    rises = [f"It rises on joint{'s' if len(worse) > 1 else ''} {listed(worse)}."] if worse else []
    return [" ".join([text, *rises, *_counted(c)]) + " "]


def _counted(c: DiagnosisRecord) -> list[str]:
    """What else the errors before and after hold."""
    touched = c.scored_on != "holdout" and any(f.intervals for f in c.findings)
    contact = (
        "Only the first of these errors holds the rows of the contact, whose force no other recording can predict."
    )
    old = "Their difference holds what the model lacked before, too."
    return [text for text, holds in ((contact, touched), (old, c.missing_since_before)) if holds]


def _cautions(c: DiagnosisRecord) -> list[Markup]:
    """Warnings that belong before the answer."""
    unseen = [wrong_unseen_sentence(c.wrong_unseen)] if c.wrong_unseen else []
    warnings = [f"{text[0].upper()}{text[1:]}." for text in (*c.warnings, *unseen)]
    if c.warnings and c.causes:
        warnings.append(f"{SET_UP_FIRST[0].upper()}{SET_UP_FIRST[1:]}.")
    if c.passed:
        means = placebos_in_words(c.findings, c.no_more_than_placebos)
        warnings.append(
            f"{len(c.passed)} of {len(c.placebos)} placebos, which are columns that cannot be a cause, exceed the threshold, too:"
            f" {means}."
        )
    if c.wrong_baseline:
        warnings.append(c.wrong_baseline_sentence)
    if c.incomplete and c.findings:
        warnings.append(
            f"The model's residual on its own training recordings is still autocorrelated: {incomplete_words(c.controlled)}."
        )
    if unsure := [place for place, f in enumerate(c.findings, 1) if f.rivals]:
        warnings.append(
            f"Finding{'s' if len(unsure) > 1 else ''} {listed(unsure)} could have another cause, which these recordings"
            " cannot separate from it; see below."
        )
    return [tag("p", joined(tag("strong", "Note: "), " ".join(warnings)), class_="caution")] if warnings else []
