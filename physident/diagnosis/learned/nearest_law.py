"""The law of the catalogue that comes nearest to a learned curve: how much of the curve it takes on left-out rows."""

from __future__ import annotations

from dataclasses import dataclass, replace

from physident.diagnosis.problem.candidates import AcceptedEffect, Candidate
from physident.diagnosis.search.acceptance import contradiction
from physident.diagnosis.search.hypothesis import Hypothesis, state_hypothesis
from physident.diagnosis.search.left_out_costs import left_out_costs
from physident.diagnosis.search.shape_refinement import refine_shape
from physident.diagnosis.statistics.left_out_gains import left_out_gains
from physident.effects.classification import Detection
from physident.effects.learned.curve import LearnedCurve
from physident.effects.scales.shared_scale import SharedScale

SAME_SHAPE = 15.0  # % of a curve's RMS: a law that is nearer describes it as well as values are asked to be known
AS_MUCH = 1 - (SAME_SHAPE / 100) ** 2  # of a curve's power
NEARLY = 0.9  # of a curve's power: a law that takes as much may be the whole truth where a model errs
TOGETHER = 2  # laws of the model whose values may have changed: of dry and of viscous friction
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


@dataclass(frozen=True, kw_only=True, eq=False)
class NearLaw:
    """A law beside a curve: the ``share`` that it takes of the curve's power on left-out rows, and whether that ``is_enough`` for it to be the law."""

    law: Candidate
    share: float
    is_enough: bool


def laws_by_share(rest: Hypothesis, curve: Candidate) -> list[NearLaw]:
    """The laws of a curve's joint, beside a hypothesis without both, those first that take most of the curve.

    A law is enough where it takes as much as values are asked to be known, or nearly all, and what it leaves of the curve is no larger than what
    the model may err by on new recordings of a healthy arm: that much shape is no change.
    """
    (joint,), laws = curve.joints, laws_of_joint(rest, curve.joints)
    data = replace(rest.data, candidates=(curve, *laws))
    taken = left_out_gains(data, rest.baseline, rest.fit, products=rest.products).gain.sum(axis=1)[:, joint - 1, 0]
    most, usual = max(float(taken[0]), 1e-300), rest.usual_power(joint)
    found = [
        NearLaw(law=law, share=float(power) / most, is_enough=_is_enough(float(power), most, usual))
        for law, power in zip(laws, taken[1:], strict=True)
    ]
    return sorted(found, key=lambda one: -one.share)


def _is_enough(power: float, most: float, usual: float) -> bool:
    """Whether a law takes as much ``power`` as a curve, whose is ``most``, or nearly, and what it leaves of that is ``usual``."""
    return power >= AS_MUCH * most or (power >= NEARLY * most and most - power <= usual)


def changed_laws(rest: Hypothesis, curve: Candidate) -> tuple[AcceptedEffect, ...]:
    """The law that the model has, or the two of them, that take as much as a curve of their joint, beside a hypothesis without all three; empty
    where there are none. More dry and less viscous friction bend no curve: both of the model's values have changed."""
    joint, now, found, weights = curve.joints[0] - 1, rest, (), rest.fit.weights
    before = left_out_costs(rest, None, weights)[:, joint].sum()
    most = before - left_out_costs(rest, curve, weights)[:, joint].sum()
    for _ in range(TOGETHER):
        laws = [near.law for near in laws_by_share(now, curve) if near.law.key in rest.problem.present]
        possible = [law for law in laws if law.joints == curve.joints and contradiction(now, law) is None]
        if not possible:
            return ()
        found = (*found, AcceptedEffect(possible[0], refine_shape(now, possible[0])))
        now = state_hypothesis(rest.problem, (*rest.accepted, *found), rest.model, rest.data)
        taken = before - left_out_costs(now, None, weights)[:, joint].sum()
        if _is_enough(float(taken), float(most), rest.usual_power(joint + 1)):
            return found
    return ()


def nearest_law(hypothesis: Hypothesis, accepted: AcceptedEffect) -> str:
    """A sentence on the law of the same joint that takes most of what a curve takes on left-out rows, of those that the arm can have;
    empty for another effect."""
    if not isinstance(accepted.effect, LearnedCurve):
        return ""
    others = [one for one in hypothesis.accepted if one is not accepted]
    rest = state_hypothesis(hypothesis.problem, others, hypothesis.model, hypothesis.data)
    said = "no effect of the catalogue has this shape"
    for near in laws_by_share(rest, accepted.candidate):
        if near.share < LEAST:
            break
        if contradiction(rest, near.law) is not None:
            continue
        if near.is_enough:
            return f"{near.law.name} takes as much of it."
        return f"{said}; nearest: {near.law.name}, {100 * min(near.share, 1.0):.0f} % of it."
    return f"{said}, and none takes {100 * LEAST:.0f} % of it."
