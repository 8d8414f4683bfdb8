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


def with_own_width(hypothesis: Hypothesis, candidate: Candidate, curve: LearnedCurve) -> LearnedCurve:
    """A curve of friction with the width of its sign, where rows tell it from the width of the joint's dry friction."""
    if not isinstance(curve, LearnedPositionFriction):
        return curve
    joint = candidate.joints[0] - 1
    fastest = max(float(np.abs(one.v[:, joint]).max()) for one in hypothesis.problem.signals)
    beside = hypothesis.with_effect(candidate, curve).fit.weights  # what the place leaves open is no noise
    evaluator = GainEvaluator(hypothesis, beside)
    (option,) = candidate.options
    as_it_is = evaluator.gain(hypothesis.data.columns(option.columns))
    tried = [replace(curve, smoothing=(float(width),)) for width in np.geomspace(SLOWEST, 1.0, STEPS) * fastest]
    gains = [evaluator.gain(hypothesis.problem.fresh_columns(one, hypothesis.model)) for one in tried]
    best = int(np.argmax(gains))
    told_apart = gains[best] - as_it_is > TOLD_APART  # gains are those of independent rows
    return tried[best] if told_apart else curve
