"""What would tell more of a finding: what separates it from its rivals, and where its curve was not recorded."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from functools import cache

from physident.diagnosis.result.findings import Finding, Rival
from physident.dynamics.model import Model
from physident.effects.catalogue import CATALOGUE, effects_from
from physident.effects.classification import Detection
from physident.errors import InputError
from physident.excitation.limits.capsules import collision_geometry
from physident.robots.robot import Robot


def other_rival(name: str, rivals: Sequence[Rival]) -> Rival | None:
    """The first rival that is another effect, and that a motion can separate: no motion is designed for a curve without a law."""
    if CATALOGUE[name].detection is Detection.AFTER_LAWS:
        return None
    laws = [one for one in rivals if CATALOGUE[one.effect].detection is not Detection.AFTER_LAWS]
    return next((rival for rival in laws if rival.effect != name and not rival.inseparable), None)


def separating_words(name: str, other: str) -> str:
    """What separates two effects, in the catalogue's words; empty where it has none."""
    signatures = ((other, CATALOGUE[name].mistaken_for), (name, CATALOGUE[other].mistaken_for))
    return next((text for rival, text in signatures if rival in text), "")


def beyond_range_words(name: str, share: float, handed_on: bool) -> str:
    """What it means that unseen recordings leave the range in which the curve of an effect was learned, for a share of their time, and
    whether the extended model holds it."""
    designed = CATALOGUE[name].variable in ("position", "velocity", "load", "torque")
    how = "; physident design --cover plans a motion that goes there" if designed else ""
    return (
        f"For {100 * share:.0f} % of their time the unseen recordings are beyond the range in which this curve was learned, where it stays"
        f" constant and was not judged{how}."
        + ("" if handed_on else " With it they are predicted worse as a whole, so the extended model goes without it.")
    )


def own_notes(finding: Finding) -> str:
    """The advice of a finding but for what separates it from its first rival."""
    other = other_rival(finding.effect, finding.rivals)
    return finding.advice.removesuffix(separating_words(finding.effect, other.effect) if other else "").strip()


def design_command(model: Model, model_file: str, name: str, joints: Sequence[int], other: Rival) -> str:
    """The command that designs a motion which separates an effect on some joints from a rival, as it can be typed."""
    words = ["physident", "design", "--model", model_file, "--discriminate", name, other.effect]
    common = [joint for joint in joints if joint in other.joints]
    words += ["--joint", str(common[0])] if common else []
    words += [] if _has_shapes(model.robot) else ["--limits", "joint"]
    words += effects_from([name, other.effect, *(effect.name for effect in model.effects)])
    return shlex.join([*words, "--out", "motion.json"])


@cache
def _has_shapes(robot: Robot) -> bool:
    """Whether the links' shapes can be read, without which only the joints' limits can be checked."""
    try:
        collision_geometry(robot)
    except InputError:
        return False
    return True
