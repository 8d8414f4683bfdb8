"""What would separate a finding from its rivals: the words of its signature, and the command that designs the motion."""

from __future__ import annotations

from collections.abc import Sequence

from physident.diagnosis.problem.question import Question
from physident.diagnosis.result.findings import Rival
from physident.effects.catalogue import CATALOGUE


def advice(question: Question, name: str, joints: Sequence[int], rivals: Sequence[Rival]) -> str:
    """What would separate the first rival that is another effect."""
    other = next((r for r in rivals if r.effect != name), None)
    return separation_advice(question, name, joints, other) if other is not None else ""


def separation_advice(question: Question, name: str, joints: Sequence[int], other: Rival) -> str:
    """What separates an effect on some joints from another one: its signature's words where the catalogue has them, and the
    command that designs the motion."""
    signatures = ((other.effect, CATALOGUE[name].mistaken_for), (name, CATALOGUE[other.effect].mistaken_for))
    words = [f"{text}. " for rival, text in signatures if rival in text][:1]
    common = [j for j in joints if j in other.joints]
    joint = f" --joint {common[0]}" if common else ""
    # a design needs to know the noise, which a nominal model does not
    model = "EXTENDED" if question == "nominal" else "MODEL"
    command = f"physident design --model {model} --discriminate {name} {other.effect}{joint} --out motion.json"
    return f"{words[0] if words else ''}Design a motion that separates them with: {command}"
