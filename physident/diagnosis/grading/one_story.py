"""One cause for all curves of a joint: together they are one torque that no law describes.

A sum of curves, each over one quantity, is what a torque of several quantities looks like: a tight spot that drags as in oil is a curve
over position, and what that leaves is one over velocity. Only the curve that says most by itself tells where to look.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from physident.diagnosis.grading.members import members, without_effects
from physident.diagnosis.problem.candidates import AcceptedEffect, prior_precision
from physident.diagnosis.result.findings import Finding
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.effects.learned.curve import LearnedCurve


def one_curve_a_joint(hypothesis: Hypothesis, findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """The findings, of which a curve is a contribution where another one of its joint is a cause and says more by itself."""
    causes = sorted({i for finding in findings if finding.grade == "cause" for i in members(hypothesis, finding)})
    second: set[int] = set()
    for joint in range(1, hypothesis.problem.model.robot.n + 1):
        curves = [i for i in causes if _is_curve_of(hypothesis.accepted[i], joint)]
        if len(curves) > 1:
            second |= set(curves) - {min(curves, key=lambda i: _cost_alone(hypothesis, i, curves))}
    result = [
        replace(f, grade="contribution") if f.grade == "cause" and set(members(hypothesis, f)) <= second else f
        for f in findings
    ]
    return tuple(sorted(result, key=lambda f: f.grade != "cause"))  # each grade stays in its order


def _is_curve_of(one: AcceptedEffect, joint: int) -> bool:
    return isinstance(one.effect, LearnedCurve) and one.candidate.joints == (joint,)


def _cost_alone(hypothesis: Hypothesis, i: int, curves: Sequence[int]) -> float:
    """The squared left-out residual, in units of the noise, with accepted effect i and without the other ``curves``."""
    rest, one = without_effects(hypothesis, curves), hypothesis.accepted[i]
    columns = hypothesis.columns(one.candidate, one.effect)
    squares = rest.left_out_fits.squares_of_blocks(columns, np.full(columns.count, prior_precision(one.effect)))
    return float((hypothesis.fit.weights**2 * squares).sum())
