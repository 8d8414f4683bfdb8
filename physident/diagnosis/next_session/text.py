"""What a session settled, in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from physident.diagnosis.next_session.settled import Answer
from physident.diagnosis.result.text import diagnosis_text
from physident.diagnosis.result.wording import numbered
from physident.effects.catalogue import effect_label
from physident.excitation.session.outlook_text import ENDINGS, GROUPED


def resumed_text(resumed: Any) -> str:
    """The diagnosis, what was settled and what was not, and whether another session pays."""
    said: tuple[Answer, ...] = resumed.answers
    rows = [diagnosis_text(resumed.diagnosis), ""]
    rows.append(
        f"Session: {resumed.settled} of {len(said)} questions settled (one question for each joint of an effect), {resumed.expected:.1f} were"
        f" expected; {resumed.pooled} earlier recordings counted as well"
    )
    for heading, settled in (("settled", True), ("not settled", False)):
        chosen = [one for one in said if one.settled == settled]
        rows += [f"{heading}:", *_rows(chosen)] if chosen else []
    return "\n".join([*rows, f"verdict: {_verdict(resumed)}"])


def _rows(said: Sequence[Answer]) -> list[str]:
    """One row for each question about a finding; effects that were not seen and ranges by name."""
    rows = [f"  {one.question.question} {one.text}" for one in said if one.question.kind not in GROUPED]
    groups: dict[tuple[str, str], list[int]] = {}
    for one in said:
        question = one.question
        if question.kind in ENDINGS:
            groups.setdefault((effect_label(question.effect), one.text), []).extend(question.joints)
        elif question.kind == "range":
            name = question.question.split(" range")[0].removeprefix("the ") + " range"
            groups.setdefault((name, "recorded as planned" if one.settled else "not shown as wanted"), []).extend(
                question.joints
            )
    for (name, text), joints in groups.items():
        rows.append(f"  {name}{f' ({numbered(joints)})' if joints else ''}: {text}")
    return rows


def _verdict(resumed: Any) -> str:
    """Whether another session pays, with the expected gain against its minutes."""
    following = resumed.next
    if following is None or following.outlook is None:
        return "nothing is open that another session could settle"
    outlook = following.outlook
    total, minutes = len(outlook.expectations), following.duration / 60
    curve = ", ".join(f"{value:.1f} after {m:.1f} min" for m, value in outlook.curve[1:])
    pays = "pays" if resumed.pays else "does not pay"
    lowered = (
        ", less than planned because this session settled less than it promised"
        if resumed.promised < outlook.settled
        else ""
    )
    return (
        f"another session of {minutes:.1f} minutes {pays}: it is expected to settle {resumed.promised:.1f} of {total} open questions"
        f"{lowered} (planned: {curve} of fitted motion)"
    )
