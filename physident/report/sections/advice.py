"""What to record next, as far as it follows from this diagnosis."""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup

from physident.diagnosis.result.advice import separating_words
from physident.diagnosis.result.findings import Finding, Rival
from physident.diagnosis.result.record import DiagnosisRecord
from physident.diagnosis.result.wording import INSEPARABLE, MOTORS_UNKNOWN, cause, in_words, listed, numbered
from physident.effects.catalogue import effect_label
from physident.report.markup import joined, tag
from physident.report.numbers import number
from physident.report.sections.unseen import IN_MODEL, WORDED, by_reason

SLOW = 0.5  # of the residual's power below 0.2 Hz
SHARE = 0.1  # of the residual's power: a weaker dependence gives no advice
LEADS = {
    "velocity": "move at several constant speeds in both directions",
    "position": "move each joint alone and slowly through its whole range, in both directions",
    "load": "record the same motion with and without a known load",
    "time": "record the same motion again later in the same session",
}


def advice(c: DiagnosisRecord) -> Markup:
    """A list, or the statement that nothing more is needed."""
    items = [
        *_incomplete(c),
        *_again(c),
        *_rivals(c),
        *_holdout(c),
        *_wrong_unseen(c),
        *_uncertain(c),
        *_remainder(c),
        *_unseen(c),
        *([f"{MOTORS_UNKNOWN[0].upper()}{MOTORS_UNKNOWN[1:]}."] if c.motors_unknown else []),
        *_unidentified(c),
    ]
    if not items:
        items = ["Nothing more is needed for this answer."]
    return tag("section", tag("h2", "What to record next"), tag("ul", *(tag("li", item) for item in items)))


def _incomplete(c: DiagnosisRecord) -> list[str]:
    if not c.incomplete or c.controlled:  # then they have been asked
        return []
    return ["First find what the model lacks: diagnose the recordings that it was fitted to."]


def _again(c: DiagnosisRecord) -> list[str]:
    if not c.controlled or any(used.repeats is not None for used in c.recordings):
        return []
    return [
        "Record a motion of the model's own recordings again: compared row by row, what the model always lacked cancels, and what has"
        " changed is left. physident plan --diagnosis writes such a motion."
    ]


def _wrong_unseen(c: DiagnosisRecord) -> list[str]:
    if not c.wrong_unseen:
        return []
    where = f"joint{'s' if len(c.wrong_unseen) > 1 else ''} {numbered(c.wrong_unseen)}"
    return [
        f"Record more motions like the holdout's, and diagnose them, too: the extended model does not predict {where} there."
    ]


def _rivals(c: DiagnosisRecord) -> list[Markup]:
    return [
        joined(f"To separate {cause(f.effect, f.joints)} from {cause(r.effect, r.joints)}: ", _separating(c, f, r))
        for f in c.findings
        for r in f.rivals
    ]


def _separating(c: DiagnosisRecord, f: Finding, r: Rival) -> Markup:
    """The motion that separates a rival, and the command that designs it."""
    if r.inseparable:
        return joined(f"they make {INSEPARABLE}; move farther, or look at the arm")
    if r.effect == f.effect:
        return joined("move these joints one at a time")
    words = in_words(separating_words(f.effect, r.effect))
    unsaved = c.question == "nominal" and c.extended_file is None
    first = " after diagnose has written the extended model (--out extended.json)" if unsaved else ""
    return joined(
        f"{words}. " if words else "",
        f"Design a motion that separates them{first}:",
        tag("pre", tag("code", c.command(f, r))),
    )


def _holdout(c: DiagnosisRecord) -> list[str]:
    if not c.findings or c.scored_on == "holdout":
        return []
    return [
        "Record another motion, use it neither for identify nor for diagnose, and pass it to diagnose as --holdout: the"
        " gains on this page are those of left-out rows of the diagnosed recordings."
    ]


def _uncertain(c: DiagnosisRecord) -> list[str]:
    # one value that is known will do: a load's products of inertia, or the share of a joint that leaks nothing, may well be zero
    known: dict[str, bool] = {}
    for f in c.findings:
        for v in f.parameters:
            name = f"{effect_label(f.effect)}{f' of joint {v.joint}' if f.joints or f.by_joint else ''}"
            known[name] = known.get(name, False) or not v.interval95[0] < 0 < v.interval95[1]
    wide = [name for name, some in known.items() if not some]
    if not wide or any(f.effect == "contact" for f in c.findings):
        return []
    return [f"Record longer or more often: the intervals include zero for {listed(wide)}."]


def _remainder(c: DiagnosisRecord) -> list[str]:
    left = c.structured
    if not left:
        return []
    items = []
    if c.noise_floor is None:
        within = any(used.repeats is not None for used in c.recordings)
        where = "None was repeated within these recordings." if within else "No motion was repeated here."
        items.append(
            f"Record one motion twice: the part of the residual on {_joints([r.joint for r in left])} that repeats belongs"
            f" to the arm, and the rest is noise. {where}"
        )
    if slow := [r.joint for r in left if r.slow > SLOW]:
        items.append(
            f"The residual of {_joints(slow)} is mostly slower than 0.2 Hz: repeat a motion cold and warm, with"
            " temperature_1.. if the controller measures them."
        )
    if between := {r.joint: r.friction_between for r in left if r.friction_between}:
        most = max(between, key=lambda joint: between[joint].share)
        if between[most].share > SHARE:
            items.append(
                f"Friction differs from one recording to the next, on joint {most} by up to {number(between[most].percent, 2)} %: record"
                " temperature_1.. if the controller measures them, or warm the arm up in the same way before each recording."
            )
    for key, text in LEADS.items():
        if joints := [r.joint for r in left if getattr(r, key) > SHARE]:
            items.append(f"The residual of {_joints(joints)} depends on {key}: {text}.")
    return items


def _unseen(c: DiagnosisRecord) -> list[str]:
    items = []
    reasons = by_reason(c)
    # no motion shows the zero offset of a joint about a vertical axis
    if still := [name for name in reasons.get(WORDED["shows no torque"], {}) if name != "joint_zero_offset"]:
        items.append(
            f"Record motions that excite {listed([effect_label(name) for name in still])}: here they caused no torque of their own."
        )
    if IN_MODEL in reasons:
        items.append(
            "Record the same arm again, without fitting the model to it: only a new recording shows whether a parameter"
            " that the model already has changed."
        )
    return items


def _unidentified(c: DiagnosisRecord) -> list[str]:
    if not c.unidentified:
        return []
    return [
        "Some parameters were never identified: physident inspect with --robot and --effects all shows for every effect and"
        " joint whether recordings contain it."
    ]


def _joints(joints: Sequence[int]) -> str:
    return f"joint{'s' if len(joints) > 1 else ''} {numbered(joints)}"
