"""A diagnosis in plain words, the same on every page and in every picture."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Literal

from physident.diagnosis.problem.question import Question
from physident.diagnosis.result.findings import SEARCHES, Finding, UsedRecording, Verdict
from physident.effects.catalogue import CATALOGUE, effect_label, effect_scope

# a question, and since when
Asked = Literal["missing", "different", "different_or_missing", "different_from_before", "nominal"]
FOUND: dict[Asked, str] = {
    "missing": "The model lacks",
    "different": "Since the model was identified, this has changed:",
    "different_or_missing": "Since the model was identified, this has changed, or the model lacked it already:",
    "different_from_before": "Since the recordings from before, this has changed:",
    "nominal": "The nominal model gets this wrong:",
}
NOT_FOUND: dict[Asked, str] = {
    "missing": "missing from the model",
    "different": "different from when the model was identified",
    "different_or_missing": "different from when the model was identified, or missing from it already",
    "different_from_before": "different from the recordings from before",
    "nominal": "wrong with the nominal model",
}
INSEPARABLE = "nearly the same torque on any motion within the recorded ranges"
MAX_NAMED = 6  # causes in a sentence
ALIKE = 3  # names of one cause in a sentence
PAIRS = 3  # of repeated motions in a sentence
SET_UP_FIRST = "but a cause may stand for what the warning says, so put that right first"
MOTORS_UNKNOWN = "ripple of the motors behind their gears was not searched: it needs --gear-ratios, which identify and diagnose take with --robot"
AS_IT_WAS, EXTENDED = "model as it was", "extended model"  # the names of the two models, wherever they are drawn


def in_words(text: str) -> str:
    """A text with the public names of effects in it as words, but for those of a command."""
    text, command, rest = text.partition("physident ")
    for name in sorted(CATALOGUE, key=len, reverse=True):
        text = text.replace(name, effect_label(name))
    return text + command + rest


def cause(effect: str, joints: Sequence[int]) -> str:
    """An effect and where it acts: "payload", "Coulomb friction on joints 2 and 3", "link inertia of link 4"."""
    if not joints:
        return effect_label(effect)
    noun = effect_scope(effect).noun
    return f"{effect_label(effect)} {'of' if noun == 'link' else 'on'} {noun}{'s' if len(joints) > 1 else ''} {numbered(joints)}"


def with_joints(effect: str, joints: Sequence[int]) -> str:
    """An effect's public name and where it acts: "payload", "coulomb_friction (joints 2, 3)"."""
    if not joints:
        return effect
    return f"{effect} ({effect_scope(effect).noun}{'s' if len(joints) > 1 else ''} {', '.join(map(str, joints))})"


def wrong_baseline_sentence(
    question: Question,
    joints: Sequence[int],
    causes: Sequence[Finding],
    controlled: bool | None = None,
    alone: bool = False,
    confirmed: bool = False,
) -> str:
    """What to do where a search was stopped because it found more than a handful; a ``controlled`` one has asked already what the
    model lacked before. The extended model may carry the cause ``alone``, or all of it, ``confirmed`` by a holdout."""
    first = {
        "different": "identify the model again from these recordings, and ask what is missing from it"
        if controlled
        else "first ask what is missing, on the recordings that the model was fitted to, or record better",
        "missing": "the extended model holds on the holdout, so ask of that one what is still missing"
        if confirmed
        else "record a richer motion or better signals",
        "nominal": "first identify the model from recordings",
    }[question]
    several = [cause(f.effect, f.joints) for f in causes if not f.intervals]
    best = (
        (
            f"what can be named is {listed(several)}"
            if len(several) > 1
            else f"the best single cause is {cause(causes[0].effect, causes[0].joints)}"
        )
        + (", which alone the extended model carries, because no unseen recording confirms the others" if alone else "")
        if causes
        else "no single cause stands out"
    )
    where = f"on joint{'s' if len(joints) > 1 else ''} {numbered(joints)}"
    return f"The baseline is wrong {where}, and a longer list of causes would prove nothing: {first}; {best}."


def wrong_unseen_sentence(joints: Sequence[int]) -> str:
    """What it means that an extended model errs on the holdout by far more than noise."""
    where = f"joint{'s' if len(joints) > 1 else ''} {numbered(joints)}"
    return f"on the holdout {where} err{'s' if len(joints) == 1 else ''} more than twice what is left of the diagnosed recordings and the model's values leave open: that is no noise"


def incomplete_words(controlled: bool | None) -> str:
    """What it means for changes that a model is incomplete: where its own recordings were ``controlled``, what they show was told apart."""
    if controlled:
        return (
            "what its own recordings show stands apart, as missing since before; what they do not tell may still stand here as a"
            " change, and hides smaller ones"
        )
    return "an effect it lacks shows here as if it were new: ask first what is missing from it, of its own recordings"


def searches_in_words(stability: float) -> str:
    """How many of the searches on halves of the recordings found something, from their share."""
    return f"found in {round(SEARCHES * stability)} of {SEARCHES} searches on halves of the recordings"


def sense_in_words(finding: Finding) -> str:
    """What its values mean: of a finding with rivals, what they mean if it is this one."""
    if not finding.rivals or not finding.in_words or finding.curves:
        return finding.in_words
    words = finding.in_words
    return f"If it is {effect_label(finding.effect)}: {words[0].lower()}{words[1:]}"


def curves_in_brief(finding: Finding) -> str:
    """What the curves of a finding are and where they are largest, without the laws that are near them."""
    each = [text.partition(";")[0] for text in re.split(r"(?<=[.]) (?=joint \d)", finding.in_words)]
    return each[0].removeprefix(f"joint {finding.joints[0]}: ") if len(each) == 1 else "; ".join(each)


def trust_in_words(finding: Finding) -> str:
    """A sentence with the grade of what is no cause, why, and how many searches on halves found it; empty where nothing is to be said."""
    searches = [] if finding.stability is None else [searches_in_words(finding.stability)]
    reasons = ", ".join(dict.fromkeys([*filter(None, [finding.no_cause]), *finding.doubts, *searches]))
    grade = "" if finding.grade == "cause" else f"A {finding.grade}, no cause"
    text = ": ".join(filter(None, [grade, reasons]))
    return f"{text[0].upper()}{text[1:]}." if text else ""


def numbered(joints: Sequence[int]) -> str:
    """Joint numbers as a sentence lists them, three and more in a row as a range: "1 to 3 and 6"."""
    runs: list[list[int]] = []
    for joint in sorted(set(joints)):
        if runs and joint == runs[-1][-1] + 1:
            runs[-1].append(joint)
        else:
            runs.append([joint])
    texts = [[f"{run[0]} to {run[-1]}"] if len(run) > 2 else [str(joint) for joint in run] for run in runs]
    return listed([text for run in texts for text in run])


def listed(items: Sequence[object]) -> str:
    """Items as a sentence lists them: "1", "1 and 2", "1, 2 and 3"."""
    texts = [str(item) for item in items]
    return " and ".join([", ".join(texts[:-1]), texts[-1]] if len(texts) > 1 else texts)


def parts_of(findings: Sequence[Finding]) -> list[Finding]:
    """The contributions, where no finding is a cause: proved, and not the most of any joint's error. What left-out rows may be predicted as
    well without is not proved; no other row knows of a contact."""
    lesser = [f for f in findings if f.grade == "contribution" and (f.intervals or f.gain.interval95[0] > 0)]
    return [] if any(f.grade == "cause" for f in findings) else lesser


def headline(asked: Asked, verdict: Verdict, findings: Sequence[Finding]) -> str:
    """The answer in one sentence to what was ``asked``: the causes, or, where there is none, the contributions."""
    causes = [f for f in findings if f.grade == "cause"]
    if causes:
        return " ".join([*_properties_sentence(asked, causes), *_contacts_sentence(causes)])
    if parts := parts_of(findings):
        return (
            f"Found to be {NOT_FOUND[asked]}, but not as the main cause of the error: {_few(names_of(parts, cause))}."
        )
    if verdict == "nothing_missing":
        return f"Nothing is {NOT_FOUND[asked]}, as far as these recordings can tell."
    return f"These recordings prove nothing that is {NOT_FOUND[asked]}, and do not rule it out: the residual has structure."


def placebos_in_words(findings: Sequence[Finding], weak: Sequence[Finding]) -> str:
    """What it means for ``findings``, of which some are ``weak``, that a column that cannot be a cause passed as one."""
    if weak:
        return f"distrust what has no more evidence: {_few([cause(f.effect, f.joints) for f in weak])}"
    return "all that was found has more evidence" if findings else "nothing was found beside it"


def _properties_sentence(asked: Asked, findings: Sequence[Finding]) -> list[str]:
    """A sentence of what the arm is like, where anything of that was found."""
    found = names_of([f for f in findings if not f.intervals], cause)
    return [f"{FOUND[asked]} {_few(found)}."] if found else []


def names_of(findings: Sequence[Finding], name: Callable[[str, Sequence[int]], str]) -> list[str]:
    """What each finding is, and what it could also be; those that one effect could stand for together are named once, and it first."""
    groups: list[tuple[list[tuple[str, tuple[int, ...]]], list[Finding]]] = []
    for f in findings:
        same = [(one.effect, one.joints) for one in f.rivals if one.inseparable]
        for shared, group in groups:
            if common := [key for key in shared if key in same]:
                group.append(f)
                shared[:] = common
                break
        else:
            groups.append((same, [f]))
    return [
        one_of([name(one.effect, one.joints) for one in (group[0], *group[0].rivals)])
        if len(group) == 1
        else one_of([name(*shared[0]), " with ".join(name(f.effect, f.joints) for f in group)])
        for shared, group in groups
    ]


def one_of(names: Sequence[str]) -> str:
    """What a finding is, and what it could also be: three names, and that there are more."""
    return " or ".join([*names[:ALIKE], *(["others"] if len(names) > ALIKE else [])])


def _few(causes: Sequence[str]) -> str:
    """Causes in a sentence, the last of many as a number."""
    more = [f"{len(causes) - MAX_NAMED} more"] if len(causes) > MAX_NAMED else []
    return "; ".join([*causes[:MAX_NAMED], *more])


def _contacts_sentence(findings: Sequence[Finding]) -> list[str]:
    """A sentence of what happened to the arm, where anything did."""
    times = [f"from {start:.2f} to {end:.2f} s" for f in findings for start, end in f.intervals]
    more = [f"{len(times) - MAX_NAMED} times more"] if len(times) > MAX_NAMED else []
    return [f"The tool was in contact with something {listed([*times[:MAX_NAMED], *more])}."] if times else []


def repeats_in_words(repeated: Sequence[UsedRecording]) -> str:
    """Which recordings repeat which, the first of many."""
    pairs = [f"{Path(one.path).name} that of {Path(str(one.repeats)).name}" for one in repeated]
    return ", ".join([*pairs[:PAIRS], *([f"{len(pairs) - PAIRS} more"] if len(pairs) > PAIRS else [])])
