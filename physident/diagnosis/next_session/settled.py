"""Which questions of a session its recordings have settled, by the diagnosis of all recordings together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from physident.diagnosis.next_session.saved_session import SavedExpectation
from physident.diagnosis.result.diagnosis import Diagnosis
from physident.diagnosis.result.findings import Finding, ParameterValue
from physident.diagnosis.result.wording import cause
from physident.effects.catalogue import CATALOGUE
from physident.estimation.estimate import Estimate
from physident.excitation.session.evidence import HALF, SMALLEST_POWER
from physident.excitation.session.questions import VAGUE
from physident.excitation.session.ranges import QUANTITIES, Ranges

REACHED = 0.9  # of a planned range: a controller rounds the corners


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What recordings said to a question: whether it is ``settled``, and the answer in words."""

    question: SavedExpectation
    settled: bool
    text: str


def answers(
    questions: Sequence[SavedExpectation],
    found: Diagnosis,
    estimate: Estimate | None,
    planned: Ranges,
    shown: Ranges,
) -> tuple[Answer, ...]:
    """The answer to each question; ``planned`` and ``shown`` are the ranges of the session's motions and of its recordings,
    ``estimate`` is the identified model."""
    return tuple(
        _of_parameter(one, estimate) if one.kind == "parameter" else _answer(one, found, planned, shown)
        for one in questions
    )


def _of_parameter(question: SavedExpectation, estimate: Estimate | None) -> Answer:
    """A parameter is known where half of its interval is smaller than the size that was asked for, or than a tenth of it."""
    unknown = Answer(question=question, settled=False, text="not identified by itself")
    if estimate is None:
        return unknown
    names = [c.name for c in estimate.model.columns if c.effect == question.effect and c.joint in question.joints]
    base = estimate.base
    at = [
        k
        for k, i in enumerate(base.independent)
        if estimate.model.columns[i].name in names and np.abs(base.beta[k]).max(initial=0.0) < 1e-9
    ]
    if not names or not at:
        return unknown
    half, value = HALF * float(np.sqrt(estimate.covariance[at[0], at[0]])), estimate[names[0]]
    settled = half <= max(question.size, VAGUE * abs(value))
    return Answer(question=question, settled=settled, text="known" if settled else "wider than was asked for")


def _answer(question: SavedExpectation, found: Diagnosis, planned: Ranges, shown: Ranges) -> Answer:
    if question.kind == "range":
        return _of_range(question, planned, shown)
    named = _finding(found, question.effect, question.joints)
    if question.kind == "unseen":
        return _of_unseen(question, found, named)
    if named is None:
        return _of_missing(question, found)
    if question.kind == "doubt":
        settled = named.grade == "cause"
        return Answer(question=question, settled=settled, text=_is(named) if settled else f"still a {named.grade}")
    if question.kind == "rival":
        open_still = any(r.effect == question.rival and not r.inseparable for r in named.rivals)
        text = f"still not told from {CATALOGUE[question.rival].name.replace('_', ' ')}" if open_still else _is(named)
        return Answer(question=question, settled=not open_still, text=text)
    if question.kind == "shape":
        at_end = any(p.at_end for p in _own(named, question))
        return Answer(
            question=question, settled=not at_end, text="still at an end of its range" if at_end else _is(named)
        )
    values = [p for p in _own(named, question) if p.name not in _shapes(question.effect)]
    if question.parameter >= len(values):
        return Answer(question=question, settled=False, text="it has no value")
    value = values[question.parameter]
    half = (value.interval95[1] - value.interval95[0]) / 2
    settled = half <= VAGUE * abs(value.value)
    text = f"{value.value:.4g} +- {half:.2g} {value.unit}"
    return Answer(question=question, settled=settled, text=text if settled else f"{text}, wider than a tenth")


def _of_range(question: SavedExpectation, planned: Ranges, shown: Ranges) -> Answer:
    quantity = next(k for k, name in enumerate(QUANTITIES) if question.question.startswith(f"the {name}"))
    joint = question.joints[0] - 1
    share = float(shown.size[quantity, joint] / max(float(planned.size[quantity, joint]), 1e-12))
    settled = share >= REACHED and question.power >= 1
    return Answer(question=question, settled=settled, text=f"{100 * share:.0f} % of what was planned was recorded")


def _of_unseen(question: SavedExpectation, found: Diagnosis, named: Finding | None) -> Answer:
    if named is not None:
        return Answer(question=question, settled=True, text=_is(named))
    hidden = any(
        one.effect == question.effect and (not one.joints or set(question.joints) <= set(one.joints))
        for one in found.unseen
    )
    if hidden or question.power < SMALLEST_POWER:
        return Answer(question=question, settled=False, text="still could not be seen")
    return Answer(question=question, settled=True, text="not there, in the size that was asked for")


def _of_missing(question: SavedExpectation, found: Diagnosis) -> Answer:
    """The effect that was asked about was not found: its rival may have been."""
    if question.kind == "doubt":
        enough = question.power >= SMALLEST_POWER
        return Answer(
            question=question, settled=enough, text="not found any more" if enough else "not found, and hardly shown"
        )
    rival = _finding(found, question.rival, question.rival_joints) if question.rival else None
    if rival is not None and rival.grade == "cause":
        return Answer(question=question, settled=True, text=_is(rival))
    if rival is not None:  # a little of what neither is; it stands for it no more than the other did
        text = f"with all recordings neither is a cause, and {cause(rival.effect, rival.joints)} is a {rival.grade}"
        return Answer(question=question, settled=False, text=text)
    return Answer(question=question, settled=False, text="with all recordings, nothing of the kind is found")


def _finding(found: Diagnosis, effect: str, joints: tuple[int, ...]) -> Finding | None:
    """The finding of an effect at a place, unless it is a hint."""
    return next(
        (
            f
            for f in found.findings
            if f.effect == effect and f.grade != "hint" and set(joints) <= set(f.joints or joints)
        ),
        None,
    )


def _own(finding: Finding, question: SavedExpectation) -> list[ParameterValue]:
    """A finding's parameters at the place of a question."""
    single = CATALOGUE[question.effect].scope.name == "JOINT"
    return [p for p in finding.parameters if not single or p.joint in question.joints]


def _shapes(effect: str) -> set[str]:
    return {shape.field for shape in CATALOGUE[effect].shape_parameters}


def _is(finding: Finding) -> str:
    return f"it is {cause(finding.effect, finding.joints)}"


def expected(questions: Sequence[SavedExpectation]) -> float:
    """How many questions were expected to be settled."""
    return float(np.sum([one.power >= 1 if one.kind == "range" else one.power for one in questions]))
