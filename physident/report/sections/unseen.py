"""Effects that these recordings could not show, and unexplained structure of the residual."""

from __future__ import annotations

from markupsafe import Markup

from physident.diagnosis.remainder.in_words import no_structure_words
from physident.diagnosis.result.findings import UnseenReason
from physident.diagnosis.result.record import DiagnosisRecord
from physident.diagnosis.result.wording import incomplete_words, numbered
from physident.effects.catalogue import effect_label, effect_scope
from physident.report.markup import joined, table, tag
from physident.report.numbers import SPACE, number, quantity

# how the page words each reason; one that is asked of an effect in the fitted model has an answer before
WORDED: dict[UnseenReason, str] = {
    "shows no torque": "shows no torque of its own",
    "inside what the baseline may take up": "inside what the baseline may take up",
    "of a joint that does not move": "of a joint that does not move",
    "of a joint that moves too little": "of a joint that moves too little to show what it is",
}
IN_MODEL = "in the model already, which was fitted to these recordings"


def unseen(c: DiagnosisRecord) -> Markup:
    """Unseen effects by reason, parameters that were never identified, and the unexplained residual."""
    parts = _effects(c) + _unidentified(c) + _incomplete(c) + _remainder(c)
    return tag(
        "section",
        tag("h2", "What could not be seen"),
        *(parts or [tag("p", "Every effect of the catalogue could be seen.")]),
    )


def by_reason(c: DiagnosisRecord) -> dict[str, dict[str, list[int]]]:
    """Unseen effects with their joints, by reason."""
    in_model = {effect.name for effect in c.model.effects}
    found: dict[str, dict[str, list[int]]] = {}
    for one in c.unseen:
        reason = IN_MODEL if c.question == "missing" and one.effect in in_model else WORDED[one.reason]
        joints = found.setdefault(reason, {}).setdefault(one.effect, [])
        joints += [j for j in one.joints if j not in joints]
    return found


def _effects(c: DiagnosisRecord) -> list[Markup]:
    parts = []
    if c.unseen:
        parts.append(tag("p", "These recordings can neither confirm nor rule out the following effects."))
    for reason, effects in by_reason(c).items():
        rows = [[effect_label(name), _where(name, joints, c)] for name, joints in effects.items()]
        parts += [
            tag("h3", f"{reason[0].upper()}{reason[1:]}" if reason else "No reason given"),
            _grid(rows),
        ]
    return parts


def _grid(rows: list[list[str]]) -> Markup:
    """A grid of effects and their joints, with as many columns as the page is wide."""
    return tag("ul", *(tag("li", tag("strong", name), f" {where}") for name, where in rows), class_="grid")


def _where(name: str, joints: list[int], c: DiagnosisRecord) -> str:
    if not joints:
        return "the whole arm"
    word = effect_scope(name).noun
    every = len(joints) == c.model.robot.n > 1
    return f"every {word}" if every else f"{word}{'s' if len(joints) > 1 else ''} {numbered(joints)}"


def _unidentified(c: DiagnosisRecord) -> list[Markup]:
    if not c.unidentified:
        return []
    return [
        tag("p", tag("strong", "Never identified, kept at their nominal values: "), joined(", ".join(c.unidentified)))
    ]


def _incomplete(c: DiagnosisRecord) -> list[Markup]:
    if not c.incomplete:
        return []
    where = f"joint{'s' if len(c.incomplete) > 1 else ''} {numbered(list(c.incomplete))}"
    text = (
        f"the model's residual on its own training recordings is still autocorrelated on {where};"
        f" {incomplete_words(c.controlled)}."
    )
    return [tag("p", tag("strong", "Changes that may not be new: "), text)]


def _remainder(c: DiagnosisRecord) -> list[Markup]:
    left = c.structured or c.may_hide or c.large_as_usual
    as_own = [] if c.structured else [tag("p", f"Unexplained: {no_structure_words(c.as_own, c.large_as_usual)}.")]
    if not left:
        return as_own
    units = c.model.robot.torque_units
    head = ["", "RMS", "memory", "noise's memory", "description"]
    rows = [
        [
            f"joint{SPACE}{r.joint}", quantity(r.rms, units[r.joint - 1]), f"{number(r.memory, 2)}{SPACE}s",
            f"{number(r.white_memory, 2)}{SPACE}s", r.description,
        ]
        for r in left
    ]  # fmt: skip
    return [*as_own, tag("h3", "Unexplained structure"), table(head, rows, class_="numbers")]
