"""What these recordings could not show, and what remains without a name."""

from __future__ import annotations

from physident.diagnosis.result.saved import Contents
from physident.diagnosis.result.wording import effect_words, numbered
from physident.graphics.figures.residual import torque_units
from physident.report.markup import Markup, joined, table, tag
from physident.report.numbers import SPACE, number, quantity

NO_TORQUE, NONE_OF_ITS_OWN = "shows no torque", "shows no torque of its own"
IN_MODEL = "in the model already, which was fitted to these recordings"


def limits(c: Contents) -> Markup:
    """Unseen effects by reason, parameters that were never identified, and the residual that is no noise."""
    parts = _unseen(c) + _held(c) + _incomplete(c) + _remainder(c)
    return tag("section", tag("h2", "What could not be seen"), *(parts or [tag("p", "Nothing of the catalogue.")]))


def by_reason(c: Contents) -> dict[str, dict[str, list[int]]]:
    """Unseen effects with their joints, under the reason why."""
    own = {effect.name for effect in c.model.effects}
    found: dict[str, dict[str, list[int]]] = {}
    for one in c.unseen:
        reason = (
            IN_MODEL
            if c.question == "missing" and one.effect in own
            else one.reason.replace(NO_TORQUE, NONE_OF_ITS_OWN)
        )
        joints = found.setdefault(reason, {}).setdefault(one.effect, [])
        joints += [j for j in one.joints if j not in joints]
    return found


def _unseen(c: Contents) -> list[Markup]:
    parts = []
    if c.unseen:
        parts.append(
            tag("p", "For these the honest answer is “cannot tell here”: neither present nor absent is proved.")
        )
    for reason, effects in by_reason(c).items():
        rows = [[effect_words(name), _where(name, joints, c)] for name, joints in effects.items()]
        parts += [
            tag("h3", f"{reason[0].upper()}{reason[1:]}" if reason else "No reason given"),
            _grid(rows),
        ]
    return parts


def _grid(rows: list[list[str]]) -> Markup:
    """Effects and their joints, as many beside one another as the page is wide."""
    return tag("ul", *(tag("li", tag("strong", name), f" {where}") for name, where in rows), class_="grid")


def _where(name: str, joints: list[int], c: Contents) -> str:
    if not joints:
        return "the whole arm"
    word = "link" if name == "link_inertia" else "joint"
    every = len(joints) == c.model.robot.n > 1
    return f"every {word}" if every else f"{word}{'s' if len(joints) > 1 else ''} {numbered(joints)}"


def _held(c: Contents) -> list[Markup]:
    if not c.held:
        return []
    return [tag("p", tag("strong", "Never identified, held as they are: "), joined(", ".join(c.held)))]


def _incomplete(c: Contents) -> list[Markup]:
    if not c.incomplete:
        return []
    where = f"joint{'s' if len(c.incomplete) > 1 else ''} {numbered(list(c.incomplete))}"
    text = (
        f"the model left more than noise of its own recordings on {where}; what it lacks shows here as if it were new."
    )
    return [tag("p", tag("strong", "Doubtful as a difference: "), text)]


def _remainder(c: Contents) -> list[Markup]:
    left = c.structured
    if not left:
        return [tag("p", "What remains of the torque has no more memory than noise through the same filter.")]
    units = torque_units(c.model.robot)
    head = ["", "RMS", "memory", "noise's memory", "looks"]
    rows = [
        [
            f"joint {r.joint}", quantity(r.rms, units[r.joint - 1]), f"{number(r.memory, 2)}{SPACE}s",
            f"{number(r.white_memory, 2)}{SPACE}s", r.looks,
        ]
        for r in left
    ]  # fmt: skip
    return [tag("h3", "Remains, is no noise, and has no name"), table(head, rows, class_="numbers")]
