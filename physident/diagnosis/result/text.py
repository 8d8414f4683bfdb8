"""A diagnosis as text on one screen: the answer first, in words."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from physident.diagnosis.remainder.in_words import grown_in_words, no_structure_words, times_own_in_brackets
from physident.diagnosis.result.errors import error_table
from physident.diagnosis.result.findings import Finding, ParameterValue
from physident.diagnosis.result.record import DiagnosisRecord
from physident.diagnosis.result.wording import (
    INSEPARABLE,
    MOTORS_UNKNOWN,
    SET_UP_FIRST,
    curves_in_brief,
    incomplete_words,
    names_of,
    one_of,
    parts_of,
    placebos_in_words,
    repeats_in_words,
    searches_in_words,
    sense_in_words,
    with_joints,
    wrong_unseen_sentence,
)
from physident.effects.learned.one_torque import are_one_torque

ASKED = {
    "missing": "what is missing from the model",
    "different": "what is different from when the model was identified",
    "different_or_missing": "what is different from when the model was identified, or was missing from it already",
    "different_from_before": "what is different from the recordings from before",
    "nominal": "what the nominal model gets wrong",
}
WIDTH = 100  # characters of a line
SHOWN = 8  # findings; the JSON has all
VALUES = 3  # of a finding
COMMAND = "     physident "  # how the row of a command begins


def diagnosis_text(d: DiagnosisRecord) -> str:
    """The printed form of a diagnosis."""
    rows = [f"warning: {text}" for text in d.warnings]
    rows += [f"{ASKED[d.asked]}: {_answer(d)}", f"verdict: {_verdict(d)}", ""]
    rows += error_table(d)
    if d.simulated is not None:
        rows.append(d.simulated.sentence)
    if d.wrong_baseline:
        rows += ["", d.wrong_baseline_sentence]
    paths = {used.sha256: d.short_name(used.path) for used in d.recordings}
    for number, finding in enumerate(d.causes[:SHOWN], 1):
        rows += ["", *_finding(d, number, finding, paths.get(finding.recording, "")), *_separating(d, finding)]
    if len(d.causes) > SHOWN:
        rows.append(f"... and {len(d.causes) - SHOWN} more causes, in the JSON")
    rows += ["", *_minor(d), *_unexplained(d), *_checks(d)]
    if d.recording_offsets:
        rows.append("a constant torque per recording was refitted with the model and is never reported as a cause")
    if d.incomplete:
        rows.append(
            f"the model is incomplete: its residual on its own training recordings is autocorrelated too (joint"
            f" {', '.join(map(str, d.incomplete))}); {incomplete_words(d.controlled)}"
        )
    return "\n".join(part for row in rows for part in wrapped(row))


def wrapped(row: str) -> list[str]:
    """The row in lines that fit a terminal; what it goes on with is set in. A command stays one line, to be copied."""
    if row.startswith(COMMAND):
        return [row]
    inset = " " * (len(row) - len(row.lstrip()) + 5)
    return textwrap.wrap(row, WIDTH, subsequent_indent=inset, break_on_hyphens=False) if len(row) > WIDTH else [row]


def _verdict(d: DiagnosisRecord) -> str:
    doubt = f"; {SET_UP_FIRST}" if d.warnings and d.causes else ""
    return f"{d.outcome}: {d.remainder[0].lower()}{d.remainder[1:].removesuffix('.')}{doubt}"


def _answer(d: DiagnosisRecord) -> str:
    parts = parts_of(d.findings)
    more = f"; {'and' if parts else 'but'} {grown_in_words(d.grown)}" if d.grown else ""
    if parts:
        return f"{'; '.join(names_of(parts[:SHOWN], with_joints))}, but not as the main cause of the error{more}"
    if not d.causes:
        return f"nothing that these recordings can prove{more}"
    return "; ".join(names_of(d.causes[:SHOWN], with_joints))


def _minor(d: DiagnosisRecord) -> list[str]:
    """What was found and is no cause, one line each; and what a change could not be held against."""
    rows = []
    for grade in ("contribution", "hint"):
        for f in (f for f in d.findings if f.grade == grade and not _is_nothing(f)):
            ends = dict.fromkeys(
                f"its {v.name} lies at the end of the range searched" for v in f.parameters if v.at_end
            )
            why = [f"no cause, because {f.no_cause}"] if f.no_cause else []
            doubts = "".join(f"; {doubt}" for doubt in (*ends, *why, *f.doubts))
            rest = "".join(
                f"; what {with_joints(one.effect, one.joints)} leaves of one torque" for one in _told_by(d, f)
            )
            rest += "; without it others take its part" if _is_taken_over(f) else ""
            known = grade == "contribution" or _is_taken_over(f)
            name = one_of([with_joints(one.effect, one.joints) for one in ((f, *f.rivals) if known else (f,))])
            rows.append(
                f"{grade}: {name}{_first_values(f) if known else ''}, {f.gain.reduction_percent:.1f} % less RMS{_balance(f)}{rest}{doubts}"
            )
    rows += _old(d)
    repeated = [one for one in d.recordings if one.repeats is not None]
    if repeated:
        diagnosed = [one for one in d.recordings if one.role == "diagnosed"]
        rows.append(
            f"compared: {len(repeated)} of {len(diagnosed)} recordings repeat a motion {'from before' if d.asked == 'different_from_before' else 'that the model was fitted to'}"
            f" ({repeats_in_words(repeated)}); what the model lacks is in both and was taken off, so that what is left has changed"
        )
    elif d.controlled:
        rows.append(
            "not compared: no recording repeats a motion that the model was fitted to; one that does tells a change apart from what"
            " the model always lacked (physident plan --diagnosis)"
        )
    if d.controlled is False:
        rows.append(
            "no control: the recordings that the model was fitted to are not at hand, so what the model always lacked may"
            " stand here as a change; give them with --before (in Python, before=[...])"
        )
    return rows


def _old(d: DiagnosisRecord) -> list[str]:
    """What the model lacked before, too, and what healthy recordings differ by, the same effects together."""
    whose, rows = (
        "the recordings from before" if d.asked == "different_from_before" else "the model's own recordings",
        [],
    )
    lacked = f"missing since before, for {whose} show it, or differ by as much:"
    differs = f"different here, and no proven change, for {whose} differ by as much:"
    usual = "no more than usual, for healthy recordings may differ by as much among themselves; more of them tell smaller changes:"
    for f in sorted(d.missing_since_before, key=lambda f: (bool(f.confounder), _is_changed(f), f.effect, f.joints)):
        head = usual if f.confounder else differs if _is_changed(f) else lacked
        rows += [] if head in rows else [head]
        rows.append(
            f"  {with_joints(f.effect, f.joints)}{_first_values(f)}{f'; {f.confounder}' if f.confounder else ''}"
        )
    return rows


def _is_changed(f: Finding) -> bool:
    """Whether a finding is another value of what the model has, or an effect of which little was there before."""
    return f.mostly_new or any(v.change != v.value for v in f.parameters)


def _is_nothing(f: Finding) -> bool:
    """Whether a hint is of no effect beside what was found, in the digits that are printed."""
    return _is_needless(f) and not _is_taken_over(f)


def _is_taken_over(f: Finding) -> bool:
    """Whether a hint is of no effect though its values are certainly not zero: the rotor of a joint beside a link behind it."""
    return _is_needless(f) and bool(f.parameters) and all(v.interval95[0] * v.interval95[1] > 0 for v in f.parameters)


def _is_needless(f: Finding) -> bool:
    """Whether errors are as small without a hint, in the digits that are printed."""
    return f.grade == "hint" and abs(f.gain.reduction_percent) < 0.05 and (f.takes_percent or 0.0) < 0.5


def _first_values(f: Finding) -> str:
    """The first values of a finding that is one line; of curves, what they are and where."""
    if f.curves and f.in_words:
        return f": {curves_in_brief(f)}"
    named = f"{f.effect} of " if f.by_joint else f"{f.effect} "  # said already
    shown = [_value(v, f.by_joint).removeprefix(named) for v in f.parameters]
    more = f", and {len(shown) - VALUES} more" if len(shown) > VALUES else ""
    return f": {', '.join(shown[:VALUES])}{more}" if shown else ""


def _told_by(d: DiagnosisRecord, f: Finding) -> list[Finding]:
    """The causes on the joints of a contribution that are one torque with it, which no law describes."""
    if f.grade != "contribution":
        return []
    return [one for one in d.causes if set(f.joints) & set(one.joints) and are_one_torque(one.effect, f.effect)]


def _balance(f: Finding) -> str:
    if f.takes_percent is None or f.leaves_percent is None:
        return ""
    return f" (takes {f.takes_percent:.0f} % of the squared error where it shows, {f.leaves_percent:.0f} % stays unexplained)"


def _finding(d: DiagnosisRecord, number: int, f: Finding, path: str) -> list[str]:
    low, high = f.gain.interval95
    size, scatter = "", f" [{low:.1f}, {high:.1f}]" if high > low else ""  # half a second of contact has none
    if len(f.joints) == 1:
        unit = d.model.robot.torque_units[f.joints[0] - 1]
        size = f"RMS {f.gain.rms_before:.3g} {unit} without it, {f.gain.rms_after:.3g} with it, "
    rows = [
        f"{number}. {with_joints(f.effect, f.joints)}: {size}{f.gain.reduction_percent:.1f} % less RMS on left-out rows{scatter}"
    ]
    rows += [f"   {sense_in_words(f)}"] if f.in_words else []
    shown = f.parameters[: 2 * VALUES]
    texts = [_value(v, f.by_joint) for v in shown]
    rows += [f"   {', '.join(texts[i : i + VALUES])}" for i in range(0, len(texts), VALUES)]
    if len(f.parameters) > len(shown):
        rows[-1] += f", and {len(f.parameters) - len(shown)} more"
    open_ones = [v for v in shown if v.interval95[0] < 0 < v.interval95[1] and v.change == v.value]
    if open_ones and len(open_ones) == len(shown):
        open_words = ("none of its single values is: every interval", "but not how large it is: the interval")
        rows.append(f"   the effect is significant, {open_words[len(shown) == 1]} includes zero")
    elif open_ones:
        rows.append("   the effect is significant as a whole; a value whose interval includes zero may be zero")
    if f.intervals:
        rows.append(
            "   from " + ", ".join(f"{a:.2f} to {b:.2f} s" for a, b in f.intervals) + (f" of {path}" if path else "")
        )
    for inseparable, why in ((False, "these recordings cannot separate them"), (True, INSEPARABLE)):
        if rivals := [with_joints(r.effect, r.joints) for r in f.rivals if r.inseparable is inseparable]:
            rows.append(f"   or {' or '.join(rivals)}: {why}")
    if f.stability is not None:
        rows.append(f"   {searches_in_words(f.stability)}")
    rows += [f"   {text}" for text in (f.confounder, f.advice) if text]
    return rows


def _separating(d: DiagnosisRecord, f: Finding) -> list[str]:
    command = d.command(f)
    if not command:
        return []
    unsaved = d.question == "nominal" and d.extended_file is None
    first = " (first write the extended model: diagnose ... --out extended.json)" if unsaved else ""
    return [f"   design a motion that separates them{first}:", f"{COMMAND}{command.removeprefix('physident ')}"]


def _value(v: ParameterValue, several: bool) -> str:
    place = f" of joint {v.joint}" if several else ""
    end = ", at the end of the range searched" if v.at_end else ""
    unit = "" if v.unit == "1" else f" {v.unit}"
    if v.is_open:
        return f"{v.name}{place} not known"
    low, high = v.change_interval95
    to = "" if v.change == v.value else f" to {v.value:.4g}"
    size = f"{v.value:.4g}" if v.change == v.value else f"changed by {v.change:+.4g}"
    return f"{v.name}{place} {size}{unit} [{low:.3g}, {high:.3g}]{to}{end}"


def _unexplained(d: DiagnosisRecord) -> list[str]:
    unseen = [wrong_unseen_sentence(d.wrong_unseen)] if d.wrong_unseen else []
    of_diagnosed = "of the diagnosed recordings themselves" if unseen else "unexplained"
    head = (
        "unexplained structure in the residual:"
        if d.structured
        else f"{of_diagnosed}: {no_structure_words(d.as_own, d.large_as_usual)}"
    )
    return [*unseen, head] + [
        f"  joint {r.joint}: RMS {r.rms:.3g} {d.model.robot.torque_units[r.joint - 1]}{times_own_in_brackets(r)}, lag-1 correlation {r.lag_one:.2f}, memory {r.memory:.2g} s; {r.description}"
        for r in d.structured or d.may_hide or d.large_as_usual
    ]


def _checks(d: DiagnosisRecord) -> list[str]:
    rows = []
    if d.placebos:
        top = max(d.placebos, key=lambda p: p.gain)
        rows.append(
            f"placebos: {len(d.passed)} of {len(d.placebos)} exceed the threshold (best {top.gain:.1f}, threshold {top.threshold:.1f})"
            + (f"; {placebos_in_words(d.findings, d.no_more_than_placebos)}" if d.passed else "")
        )
    for reason in dict.fromkeys(u.reason for u in d.unseen):
        cells: dict[str, list[int]] = {}
        for u in d.unseen:
            if u.reason == reason:
                cells.setdefault(u.effect, []).extend(u.joints)
        names = "; ".join(_brief(effect, joints) for effect, joints in cells.items())
        rows.append(f"neither confirmed nor ruled out ({reason}): {names}")
    if d.motors_unknown:
        rows.append(MOTORS_UNKNOWN)
    if d.unidentified:
        rows.append(
            f"never identified, kept at their nominal values: {', '.join(d.unidentified[:8])}{' ...' if len(d.unidentified) > 8 else ''}"
        )
    return rows


def _brief(effect: str, joints: Sequence[int]) -> str:
    return effect + (f" {','.join(map(str, dict.fromkeys(joints)))}" if joints else "")
