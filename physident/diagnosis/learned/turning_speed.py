"""The speed over which friction at a place turns, where it differs from that of the joint's own dry friction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from physident.diagnosis.problem.candidates import Candidate
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.search.shape_refinement import GainEvaluator
from physident.effects.learned.curve import LearnedCurve
from physident.effects.learned.curves import LearnedPositionFriction
from physident.estimation.dry_friction.transition_width import TOLD_APART

SLOWEST = 0.003  # of the fastest speed of the joint: slower is dry
STEPS = 9  # of widths from there to the fastest speed: each is twice the one before
POINTS = 200  # of a curve, of which those near a row have been visited
ROUNDS = 2  # of a width beside the place without friction, and of that place beside the width


def with_own_width(hypothesis: Hypothesis, candidate: Candidate, curve: LearnedCurve) -> LearnedCurve:
    """A curve of friction with the width of its sign, where rows tell it from the width of the joint's dry friction."""
    if not isinstance(curve, LearnedPositionFriction):
        return curve
    joint = candidate.joints[0] - 1
    fastest = max(float(np.abs(one.v[:, joint]).max()) for one in hypothesis.problem.signals)
    widths = np.geomspace(SLOWEST, 1.0, STEPS) * fastest
    beside = hypothesis.with_effect(candidate, curve).fit.weights  # what the place leaves open is no noise
    evaluator = GainEvaluator(hypothesis, beside)
    (option,) = candidate.options
    as_it_is = evaluator.gain(hypothesis.data.columns(option.columns))
    best, gain = replace(curve, zero=(_least(hypothesis, candidate, curve),)), 0.0
    for _ in range(ROUNDS):
        tried = [replace(best, smoothing=(float(width),)) for width in widths]
        gains = [evaluator.gain(hypothesis.problem.fresh_columns(one, hypothesis.model)) for one in tried]
        best, gain = tried[int(np.argmax(gains))], max(gains)
        best = replace(best, zero=(_least(hypothesis, candidate, best),))
    told_apart = gain - as_it_is > TOLD_APART  # gains are those of independent rows
    return best if told_apart else curve


def _least(hypothesis: Hypothesis, candidate: Candidate, curve: LearnedPositionFriction) -> float:
    """The visited position at which a curve, as it is fitted, is least: there friction at a place is none, because it opposes motion
    everywhere else."""
    robot, joint = hypothesis.problem.model.robot, candidate.joints[0] - 1
    x, torque, _ = curve.curve(robot, hypothesis.with_effect(candidate, curve).effect_values[-1])
    q = np.sort(np.concatenate([one.q[:, joint] for one in hypothesis.problem.signals]))
    near = (x[-1] - x[0]) / POINTS
    visited = np.searchsorted(q, x + near) > np.searchsorted(q, x - near)
    return float(x[visited][int(np.argmin(torque[visited]))])
