"""Expectations as rows of a table: questions that differ only in their joint are one row."""

from __future__ import annotations

from collections.abc import Sequence

from physident.effects.catalogue import effect_label
from physident.effects.effect import Effect
from physident.excitation.session.questions import Expectation

ENDINGS = {"unseen": "is it there?", "parameter": "how large?"}
GROUPED = (*ENDINGS, "range")  # kinds of questions that are asked of many places at once
NEVER = 1e3  # times the assumed size: no arm has that


def expected_rows(expectations: Sequence[Expectation]) -> list[tuple[str, str]]:
    """Power and question of each row: of findings first, one by one; then effects that were not seen, and ranges, by name."""
    single = [one for one in expectations if one.kind not in GROUPED]
    rows = [
        (_percent([one.power]), f"{one.question}{f' ({one.detail})' if one.detail else ''}")
        for one in sorted(single, key=lambda one: -one.power)
    ]
    groups: dict[str, list[Expectation]] = {}
    for one in expectations:
        if one.kind in ENDINGS:
            groups.setdefault(f"{effect_label(one.effect)}: {ENDINGS[one.kind]}", []).append(one)
        elif one.kind == "range":
            groups.setdefault(
                f"{one.question.split(' range')[0].removeprefix('the ')} range, share of what is wanted", []
            ).append(one)
    rows += [
        (_percent([one.power for one in same]), _group_text(name, same))
        for name, same in sorted(groups.items(), key=lambda item: -max(one.power for one in item[1]))
    ]
    return rows


def hidden_text(hidden: Sequence[Effect]) -> str:
    """The effects that no motion shows, and where."""
    places: dict[str, list[str]] = {}
    for one in hidden:
        places.setdefault(effect_label(one.name), []).append("-".join(map(str, one.joints or ())))
    words = [f"{name} ({', '.join(joints)})" if any(joints) else name for name, joints in places.items()]
    return f"no motion within the limits shows, by joint: {', '.join(words)}"


def _group_text(name: str, same: Sequence[Expectation]) -> str:
    """One row for an effect that could be at several places."""
    if len(same) == 1 and same[0].kind in ENDINGS:
        return f"{same[0].question}{f' ({same[0].detail})' if same[0].detail else ''}"
    places = [one.joints for one in same if one.joints]
    if not places:
        return name
    joints = ", ".join("-".join(map(str, joints)) for joints in places)
    never = [one for one in same if one.kind in ENDINGS and one.smallest > NEVER]
    hidden = f"; no motion shows it on {', '.join('-'.join(map(str, one.joints)) for one in never)}" if never else ""
    return f"{name} (joints {joints}{hidden})"


def _percent(powers: Sequence[float]) -> str:
    low, high = (f"{100 * max(0.0, p):.0f}" for p in (min(powers), max(powers)))
    return f"{high} %" if low == high else f"{low} to {high} %"
