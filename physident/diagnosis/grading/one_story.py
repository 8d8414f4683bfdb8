"""One cause for all parts of a torque: the curves of a joint with the laws that these hold a part of, and a law that another one has replaced.

A tight spot that drags as in oil is a curve over position, and what that leaves is one over velocity; a cable that stiffens is a curve and
a spring. Only the part that says most by itself tells where to look, or the laws that say as much together.
Dry friction that builds up over a distance takes the place of dry friction that turns at once: that the model has less of this one than before is no news.
Where both are in the model and one has gained what the other has lost, only both together say anything.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from physident.diagnosis.grading.members import members, without_effects
from physident.diagnosis.result.findings import Finding
from physident.diagnosis.rivals.successors import counterpart, is_less_than_none, is_succeeded
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.intervals import Uncertainty
from physident.effects.classification import Family
from physident.effects.learned.one_torque import are_one_torque

REPLACED = "friction that builds up over a distance stands in its place: both together are nearly what the model had"
CANCELLED = (
    "friction that builds up over another distance cancels more than half of it: only together they are what differs"
)
OVERTAKEN = "friction that builds up over a distance stands in its place: only both together are what the joint has"


def one_cause_a_torque(
    hypothesis: Hypothesis, findings: Sequence[Finding], uncertainty: Uncertainty
) -> tuple[Finding, ...]:
    """The findings, of which one is a contribution where another one of its joint is a cause, both are parts of one torque, and the other
    one says more by itself, or stands in its place."""
    causes = sorted({i for finding in findings if finding.grade == "cause" for i in members(hypothesis, finding)})
    lesser: set[int] = set()
    for joint in range(1, hypothesis.problem.model.robot.n + 1):
        parts = _parts(hypothesis, [i for i in causes if hypothesis.accepted[i].candidate.joints == (joint,)])
        if len(parts) > 1:
            lesser |= set(parts) - set(_story(hypothesis, parts))
    result = [
        replace(f, grade="contribution") if f.grade == "cause" and set(members(hypothesis, f)) <= lesser else f
        for f in findings
    ]
    result = [_beside_its_successor(hypothesis, f, uncertainty) if f.grade == "cause" else f for f in result]
    return tuple(sorted(result, key=lambda f: f.grade != "cause"))  # each grade stays in its order


def _beside_its_successor(hypothesis: Hypothesis, cause: Finding, uncertainty: Uncertainty) -> Finding:
    """A cause, as a contribution where another effect has taken the place of its law on each joint, or cancels most of it."""
    at = members(hypothesis, cause)
    if all(is_succeeded(hypothesis, i, uncertainty) for i in at):
        return replace(cause, grade="contribution", no_cause=REPLACED)
    if all(is_succeeded(hypothesis, i, uncertainty) or is_less_than_none(hypothesis, i) for i in at):
        return replace(cause, grade="contribution", no_cause=OVERTAKEN)
    return replace(cause, grade="contribution", no_cause=CANCELLED) if is_cancelled(hypothesis, at) else cause


def is_cancelled(hypothesis: Hypothesis, group: Sequence[int]) -> bool:
    """Whether each of some changed values that the model has (accepted effects, their indices) is a part of dry friction whose other part changes
    the other way - one turns at once, the other builds up over a distance -, and both together come to less than half of it."""
    known = len(hypothesis.problem.model.theta)
    if hypothesis.problem.question != "different":
        return False
    for i in group:
        k = counterpart(hypothesis, i)
        if k is None or max(hypothesis.extension.places[one].max() for one in (i, k)) >= known:
            return False
        own, other = (hypothesis.torque_of(one) for one in (i, k))
        if 4 * float(np.sum((own + other) ** 2)) >= float(np.sum(own**2)):
            return False
    return True


def _parts(hypothesis: Hypothesis, group: Sequence[int]) -> list[int]:
    """Those accepted effects of a joint (their indices) that are one torque with one of its curves."""
    names = {i: hypothesis.accepted[i].candidate.name for i in group}
    return [i for i in group if any(i != k and are_one_torque(names[i], names[k]) for k in group)]


def _story(hypothesis: Hypothesis, parts: Sequence[int]) -> list[int]:
    """The part that says most by itself; or all laws among them, where these together say as much: each is a name, and a curve is none."""
    first = min(parts, key=lambda i: _cost_with(hypothesis, [i], parts))
    laws = [i for i in parts if hypothesis.accepted[i].effect.family is not Family.LEARNED]
    if first in laws or len(laws) < 2:
        return [first]
    better = _cost_with(hypothesis, laws, parts) <= _cost_with(hypothesis, [first], parts)
    return laws if better else [first]


def _cost_with(hypothesis: Hypothesis, some: Sequence[int], parts: Sequence[int]) -> float:
    """The squared left-out residual, in units of the noise, with ``some`` accepted effects and without the other ``parts``."""
    rest = without_effects(hypothesis, [i for i in parts if i not in some])
    return float((hypothesis.fit.weights**2 * rest.left_out_squares).sum())
