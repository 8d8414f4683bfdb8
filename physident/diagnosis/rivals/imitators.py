"""What imitates a cause though nobody may name it: leaks between channels, lags of friction, and friction that differs from day to day."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import Candidate, prior_precision
from physident.diagnosis.problem.columns import Columns, joined_columns
from physident.diagnosis.problem.folds import leaves_out_recordings
from physident.diagnosis.remainder.friction_between import friction_torque
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.search.left_out_costs import RIVAL_STANDARD_ERRORS, is_worth_naming, left_out_costs
from physident.diagnosis.search.physical_signs import FREE
from physident.diagnosis.search.shape_refinement import refine_shape
from physident.diagnosis.statistics.left_out_residuals import standard_error
from physident.diagnosis.statistics.normal_equations import pseudo_inverse
from physident.effects.catalogue import effect_scope
from physident.effects.classification import Scope
from physident.effects.effect import Effect
from physident.effects.learned.curve import LearnedCurve
from physident.effects.learned.curves import LearnedTorque
from physident.effects.measurement import (
    LateFriction,
    LeakingChannels,
    TimeDelay,
    TorqueConstant,
    TorqueCrosstalk,
    TorqueDelay,
)
from physident.effects.scales.friction_level import FrictionLevel
from physident.effects.scales.torque_scale import TorqueScale
from physident.identifiability.visibility import VISIBLE

Array = NDArray[np.float64]


def is_not_imitated(hypothesis: Hypothesis, candidate: Candidate) -> bool:
    """Whether a candidate is no leak between channels, no lag of friction alone, no scale of friction alone, not how friction turns, and not
    by how much friction differs between recordings."""
    return (
        lags_as_a_whole(hypothesis, candidate)
        and scales_as_a_whole(hypothesis, candidate)
        and acts_while_sliding(hypothesis, candidate)
        and holds_against_leaks(hypothesis, candidate)
        and holds_beside_the_friction_of_each_recording(hypothesis, candidate)
    )


def lags_as_a_whole(hypothesis: Hypothesis, candidate: Candidate) -> bool:
    """Whether late channels predict left-out rows better than a lag of friction alone, by more than its standard error over blocks: friction
    that builds up over a distance lags, too, and what a joint carries does not. True of any other candidate."""
    effect = candidate.options[0].effect
    if not isinstance(effect, TorqueDelay | TimeDelay):
        return True
    joints = effect.joints if isinstance(effect, TorqueDelay) else None  # each of them by a lag of its own
    gain = (_cost_of(hypothesis, LateFriction(joints)) - left_out_costs(hypothesis, candidate)).sum(axis=1)
    return bool(gain.sum() > standard_error(gain))


def scales_as_a_whole(hypothesis: Hypothesis, candidate: Candidate) -> bool:
    """Whether a scale of all torque predicts left-out rows better than one of friction alone, each joint by a share of its own, by more than its
    standard error over blocks: friction differs from day to day by itself, and on each joint otherwise. True of any other candidate."""
    options = (one.options[0].effect for one in hypothesis.problem.candidates)
    level = next((one for one in options if isinstance(one, FrictionLevel)), None)
    if not isinstance(scale := candidate.options[0].effect, TorqueScale) or level is None:
        return True
    friction, whole = (_cost_of(hypothesis, replace(one, uneven_percent=FREE, held=())) for one in (level, scale))
    gain = (friction - whole).sum(axis=1)
    return bool(gain.sum() > standard_error(gain))


def acts_while_sliding(hypothesis: Hypothesis, candidate: Candidate) -> bool:
    """Whether a curve over the torque predicts left-out rows better than one that acts about reversals alone, by more than its standard error over
    blocks: the torque of dry friction passes values there that it has at no other time, however slowly it turns. True of any other candidate."""
    (option, *_) = candidate.options
    if not isinstance(option.effect, LearnedTorque):
        return True
    reversals = option.effect.at_reversals(hypothesis.problem.model.robot)
    gain = _cost_of(hypothesis, reversals, option.prior) - left_out_costs(hypothesis, candidate)
    return bool(gain.sum() > standard_error(gain.sum(axis=1)))


def holds_against_leaks(hypothesis: Hypothesis, candidate: Candidate) -> bool:
    """Whether what couples two joints acts on both alike, and what scales a joint's torque, or is a curve over its position or load, belongs
    to its own channel: torque that leaks from one channel into another predicts left-out rows no better beyond the scatter over blocks, or by
    less than is worth naming of the error that the candidate is to explain, or takes on no joint more than it leaves of what that leaves."""
    alike = hypothesis.columns(candidate, refine_shape(hypothesis, candidate))
    leaking = _with_leaks(hypothesis, candidate, alike)
    if leaking is None:
        return True
    weights, squares = hypothesis.fit.weights**2, hypothesis.left_out_fits.squares_of_blocks
    law, free = (weights * squares(columns, np.zeros(columns.count)) for columns in (alike, leaking))
    gain = (law - free).sum(axis=1)
    worth = is_worth_naming(hypothesis, law, free, whole=left_out_costs(hypothesis, None))
    worth &= bool(np.any(law.sum(axis=0) > 2 * free.sum(axis=0)))  # else most of what is left is no leak either
    return not (worth and gain.sum() > RIVAL_STANDARD_ERRORS * standard_error(gain))


def _with_leaks(hypothesis: Hypothesis, candidate: Candidate, alike: Columns) -> Columns | None:
    """The columns of leaking channels that a candidate may be mistaken for: with values of its own on each joint for what couples two
    of them, with a share of every joint's torque for a gain or a curve that follows what the arm carries; None for any other candidate, and
    where torques are computed from motor currents, which do not leak."""
    if effect_scope(candidate.name) is Scope.NEIGHBOURS:
        return alike.joint_by_joint()
    if any(one.from_currents for one in hypothesis.problem.signals):
        return None
    effect = candidate.options[0].effect
    if isinstance(effect, TorqueConstant) or (
        isinstance(effect, LearnedCurve) and effect.variable in ("position", "load", "torque")
    ):
        assert effect.joints is not None
        return hypothesis.problem.fresh_columns(LeakingChannels(effect.joints), hypothesis.model)
    return None


def holds_beside_the_friction_of_each_recording(hypothesis: Hypothesis, candidate: Candidate) -> bool:
    """Whether a candidate is worth naming, beyond its scatter over blocks, where the friction of its joints, dry and other, may have a size of its
    own in each recording: many a law makes up what a few days' friction differs by, and left-out rows of a motion that repeats show the same.

    True of a single recording, of what is such a size or follows a measured temperature, and, but for the shares of what several joints carry,
    which are as many numbers as there are days, where recordings are left out as a whole.
    """
    recording, effect = hypothesis.problem.regressor.recording, candidate.options[0].effect
    numbers = np.unique(recording)
    unseen = leaves_out_recordings(hypothesis.data.fold, recording) and not isinstance(effect, TorqueCrosstalk)
    if len(numbers) < 2 or unseen or (effect is not None and effect.needs_temperature):
        return True
    joints = [j - 1 for j in candidate.joints] or range(len(hypothesis.fit.sigma))
    parts, inside = friction_torque(hypothesis), recording[:, None] == numbers
    days = Columns.of(
        [np.hstack([part[:, [j]] * inside * (j in joints) for part in parts]) for j in range(len(hypothesis.fit.sigma))]
    )
    refined = refine_shape(hypothesis, candidate)
    own = hypothesis.columns(candidate, refined)
    if _share_outside(own, days) < VISIBLE:
        return True
    weights, squares = hypothesis.fit.weights**2, hypothesis.left_out_fits.squares_of_blocks
    free = np.zeros(days.count)
    without = weights * squares(days, free)
    beside = weights * squares(joined_columns([days, own]), np.concatenate([free, prior_precision(refined, own.count)]))
    gain = (without - beside).sum(axis=1)
    worth = is_worth_naming(hypothesis, without, beside, whole=left_out_costs(hypothesis, None))
    return worth and bool(gain.sum() > RIVAL_STANDARD_ERRORS * standard_error(gain))


def _share_outside(own: Columns, others: Columns) -> float:
    """The share of the squares of some columns that no sum of others has."""
    left, whole = 0.0, 0.0
    for mine, other in zip(own, others, strict=True):
        inside = mine - other @ (pseudo_inverse(other.T @ other) @ (other.T @ mine))
        left, whole = left + float(np.sum(inside**2)), whole + float(np.sum(mine**2))
    return left / max(whole, 1e-300)


def _cost_of(hypothesis: Hypothesis, effect: Effect, prior: Array | None = None) -> Array:
    """Squared left-out residual (G, n) of each block with an effect whose values have a ``prior`` precision (k,), by default none, in units of
    the hypothesis' noise."""
    columns = hypothesis.problem.fresh_columns(effect, hypothesis.model)
    held = np.zeros(columns.count) if prior is None else prior
    return hypothesis.fit.weights**2 * hypothesis.left_out_fits.squares_of_blocks(columns, held)
