"""What a diagnosis has left open, as questions that a session can settle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from physident.diagnosis.result.findings import Finding, ParameterValue
from physident.diagnosis.result.record import DiagnosisRecord
from physident.dynamics.model import Model
from physident.effects.catalogue import CATALOGUE
from physident.effects.classification import Detection, Scope
from physident.effects.effect import Effect
from physident.excitation.detectability import Noise
from physident.excitation.session.evidence import HALF
from physident.excitation.session.first import effect_at
from physident.excitation.session.questions import VAGUE, OpenQuestion

SHAPES = 3  # of a rival's grid: its quarters


def current_model(diagnosis: DiagnosisRecord) -> Model:
    """The extended model, or the diagnosed one where nothing was found."""
    return diagnosis.extended or diagnosis.model


def noise_left(diagnosis: DiagnosisRecord) -> Noise:
    """What the diagnosis left unexplained, as noise: its size and its memory on each joint."""
    rms = np.array([one.rms for one in diagnosis.unexplained])
    memory = np.array([one.memory for one in diagnosis.unexplained])
    sigma = np.maximum(rms, 1e-9 * max(float(rms.max(initial=0.0)), 1e-12))
    return Noise(sigma=sigma, worth=1 / np.maximum(memory, 1e-3), filter=diagnosis.filter)


def open_questions(diagnosis: DiagnosisRecord) -> tuple[OpenQuestion, ...]:
    """Rivals of every finding, findings in doubt, shapes at an end of their range, vague values, and effects that could not be
    seen, but for those that no motion can show because the model is refitted and has them."""
    model, found = current_model(diagnosis), []
    for finding in diagnosis.findings:
        if CATALOGUE[finding.effect].detection is not Detection.BY_PLACE:
            continue  # a contact is an event: no other recording shows it again
        for joints in _places(finding.effect, finding.joints):
            found += _of_finding(model, finding, joints)
    for unseen in diagnosis.unseen:
        for joints in _places(unseen.effect, unseen.joints):
            if not _refitted(diagnosis, unseen.effect, joints):
                found.append(OpenQuestion(kind="unseen", effect=effect_at(model, unseen.effect, joints)))
    return tuple(found)


def part_of_model(diagnosis: DiagnosisRecord) -> tuple[str, ...]:
    """Effects that could not be seen and that no motion can show, because the model is refitted and has them."""
    found = [
        u.effect for u in diagnosis.unseen for j in _places(u.effect, u.joints) if _refitted(diagnosis, u.effect, j)
    ]
    return tuple(dict.fromkeys(found))


def _refitted(diagnosis: DiagnosisRecord, name: str, joints: tuple[int, ...]) -> bool:
    """Whether an effect is inside a model that is refitted to the same recordings: as one of its effects, or as a change of its links or friction."""
    if diagnosis.question != "missing":
        return False
    robot = diagnosis.model.robot
    owned = [e for e in diagnosis.model.effects if e.name == name]
    return CATALOGUE[name].within_model or any({j - 1 for j in joints} <= set(e.active(robot)) for e in owned)


def _places(name: str, joints: Sequence[int]) -> list[tuple[int, ...]]:
    """The places of an effect that is named on some joints: each joint for itself, but for pairs and the whole arm."""
    single = CATALOGUE[name].scope in (Scope.JOINT, Scope.LINK)
    return [(joint,) for joint in joints] if single else [tuple(joints)]


def _of_finding(model: Model, finding: Finding, joints: tuple[int, ...]) -> list[OpenQuestion]:
    """What is open about a finding at one place."""
    effect = effect_at(model, finding.effect, joints)
    values = _values(finding, effect, joints)
    sizes = tuple(one.change or one.value for one in values)
    if len(sizes) != len(effect.columns(model.robot)) or not any(sizes):
        return []
    asked = []
    if finding.grade != "cause":
        asked.append(OpenQuestion(kind="doubt", effect=effect, sizes=sizes))
    for rival in finding.rivals:
        variants = [] if rival.inseparable else _variants(model, rival.effect, rival.joints)
        variants = [one for one in variants if (one.name, one.joints) != (effect.name, effect.joints)]
        if variants:
            asked.append(OpenQuestion(kind="rival", effect=effect, rivals=tuple(variants), sizes=sizes))
    if any(p.at_end for p in finding.parameters if not joints or p.joint in joints):
        others = [one for one in _variants(model, effect.name, joints) if one != effect]
        asked.append(OpenQuestion(kind="shape", effect=effect, rivals=tuple(others), sizes=sizes))
    for k, value in enumerate(values):
        if value.std > 0 and HALF * value.std > VAGUE * abs(value.value) and _matters(k, values):
            own = tuple(one.value for one in values)
            asked.append(OpenQuestion(kind="value", effect=effect, sizes=own, parameter=k, std=value.std))
    return asked


def _matters(k: int, values: Sequence[ParameterValue]) -> bool:
    """Whether a parameter is one to know by itself: the only one, or the mass of a body; its moments are small where it is."""
    return len(values) == 1 or k == 0


def _values(finding: Finding, effect: Effect, joints: tuple[int, ...]) -> list[ParameterValue]:
    """The parameters of a finding at one place, without its shapes, in the order of the effect's columns."""
    shapes = {shape.field for shape in effect.shape_parameters}
    own = [one for one in finding.parameters if one.name not in shapes]
    return [one for one in own if one.joint in joints] if effect.scope is Scope.JOINT else own


def _variants(model: Model, name: str, joints: Sequence[int]) -> list[Effect]:
    """A rival at several shapes, on the joints where it was named."""
    cls = CATALOGUE[name]
    if cls.detection is not Detection.BY_PLACE:
        return []
    place = None if cls.scope is Scope.WHOLE_ARM else tuple(joints)
    if (beside := cls.options_beside(model.robot, model.effect_parameters())) is not None:
        return list(beside)
    if not cls.shape_parameters:
        return [cls(place)]
    (shape,) = cls.shape_parameters
    # a grid for each joint: one that slides has lengths in the place of angles
    grids = [cls.search_grid(model.robot, (joint,), shape) for joint in place] if place else [shape.grid]
    steps = [k / (SHAPES + 1) for k in range(1, SHAPES + 1)]
    return [replace(cls(place), **{shape.field: tuple(g[round(at * (len(g) - 1))] for g in grids)}) for at in steps]
