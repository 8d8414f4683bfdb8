"""The law of the catalogue that comes nearest to a learned curve: how much of the curve it takes on left-out rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect, Candidate
from physident.diagnosis.search.acceptance import contradiction
from physident.diagnosis.search.hypothesis import Hypothesis, state_hypothesis
from physident.diagnosis.statistics.left_out_gains import left_out_gains
from physident.effects.classification import Detection
from physident.effects.learned.curve import LearnedCurve
from physident.effects.scales.shared_scale import SharedScale

Array = NDArray[np.float64]
SAME_SHAPE = 15.0  # % of a curve's RMS: a law that is nearer describes it as well as values are asked to be known
AS_MUCH = 1 - (SAME_SHAPE / 100) ** 2  # of a curve's power
LEAST = 0.05  # of a curve: a law that takes less is not near it


def laws_of_joint(rest: Hypothesis, joints: tuple[int, ...]) -> list[Candidate]:
    """The candidates of a hypothesis that are laws of some joints (from 1), or of the whole arm, which may show on these alone: a load that
    one joint lifts is a function of its position. A scale of all joints is none of one."""
    return [
        c
        for c in rest.data.candidates
        if c.joints in (joints, ())
        and (effect := c.options[0].effect) is not None
        and effect.detection is Detection.BY_PLACE
        and not isinstance(effect, SharedScale)
        and not rest.problem.is_friction_of_resting_joint(c)
    ]


def shares_of_curve(rest: Hypothesis, curve: Candidate, laws: Sequence[Candidate]) -> Array:
    """What each law (L,) takes of the power that a curve takes of its joint beside a hypothesis without both, on left-out rows."""
    (joint,), data = curve.joints, replace(rest.data, candidates=(curve, *laws))
    taken = left_out_gains(data, rest.baseline, rest.fit, products=rest.products).gain.sum(axis=1)[:, joint - 1, 0]
    return taken[1:] / max(float(taken[0]), 1e-300)


def nearest_law(hypothesis: Hypothesis, accepted: AcceptedEffect) -> str:
    """A sentence on the law of the same joint that takes most of what a curve takes on left-out rows, of those that the arm can have;
    empty for another effect."""
    if not isinstance(accepted.effect, LearnedCurve):
        return ""
    others = [one for one in hypothesis.accepted if one is not accepted]
    rest = state_hypothesis(hypothesis.problem, others, hypothesis.model, hypothesis.data)
    laws, said = laws_of_joint(rest, accepted.candidate.joints), "no effect of the catalogue has this shape"
    shares = shares_of_curve(rest, accepted.candidate, laws)
    for share, law in sorted(zip(shares, laws, strict=True), key=lambda pair: -pair[0]):
        if share < LEAST:
            break
        if contradiction(rest, law) is not None:
            continue
        if share >= AS_MUCH:
            return f"{law.name} takes as much of it."
        return f"{said}; nearest: {law.name}, {100 * min(float(share), 1.0):.0f} % of it."
    return f"{said}, and none takes {100 * LEAST:.0f} % of it."
