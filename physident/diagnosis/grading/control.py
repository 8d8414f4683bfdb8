"""The control of a change: the recordings that the model was fitted to, diagnosed in the same way.

A model that is wrong is wrong before and after. An effect is a change only where its size differs between the control and
the new recordings by more than both leave open. Both are fitted at once: every parameter of the extended model is common, and
the effects' sizes may differ in the new recordings. What is tested is by how much of itself an effect differs: one number, which a
few blocks can decide where they leave the ten of a payload open.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.grading.as_others_show import as_others_show, dense
from physident.diagnosis.grading.members import is_shown_by_comparison
from physident.diagnosis.grading.scatter import ALIKE, Scatter, block_variances, scatter_between
from physident.diagnosis.grading.smooth_parts import SmoothParts, smooth_parts
from physident.diagnosis.search.contact_scan import CONTACT
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.normal_equations import pseudo_inverse
from physident.diagnosis.statistics.stored_products import Key
from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor, build_regressor
from physident.estimation.dry_friction.row_weights import row_weights
from physident.estimation.weighting import weight_rows
from physident.identifiability.base_parameters import find_base_parameters
from physident.recordings.signals import Filter, Signals

Array = NDArray[np.float64]
CERTAIN = 0.01  # how often noise makes a change of one of the effects that did not change
UNUSUAL = 0.05  # how often healthy recordings differ so, where few say by how much: of three, 0.01 would ask for ten standard deviations
MOSTLY = 0.5  # of an effect: where the control shows the larger part of it, it was there before
UNSEEN = 0.05  # of an effect's torque in the new recordings, below which the control says nothing of it
ENOUGH = 4  # differences, as from five recordings of two times: 0.01 then asks for six standard deviations


def with_temperatures(control: Sequence[Signals], signals: Sequence[Signals]) -> tuple[list[Signals], tuple[str, ...]]:
    """The control's signals, those without a temperature at the one where new ``signals`` begin, and what was assumed in words.

    What follows a measured temperature is then nothing in them, as where nobody measured it.
    """
    new = [one.temperature for one in signals if one.temperature is not None]
    without = [one for one in control if one.temperature is None]
    if not without or len(new) < len(signals):
        return list(control), ()
    start = np.mean([temperature[0] for temperature in new], axis=0)
    text = (
        f"{without[0].source}{' and others' if len(without) > 1 else ''}, from before, without a temperature, which the new"
        f" recordings have: taken to be as warm as where these begin, {start.mean():.1f} degC; record temperatures both times"
    )
    return [
        replace(one, temperature=np.tile(start, (len(one.time), 1))) if one.temperature is None else one
        for one in control
    ], (text,)


@dataclass(frozen=True, kw_only=True)
class Change:
    """By how much of itself an effect differs from the control, its ``size``, zero where that is no proven change, and whether it is then
    ``mostly_new`` all the same."""

    size: float
    mostly_new: bool = False


def changes_since(hypothesis: Hypothesis, control: Sequence[Signals]) -> dict[Key, Change]:
    """What has changed of each accepted effect; nothing without a control, and no contact, which belongs to one recording.

    What compared recordings decide is a change: the control was taken off them.
    """
    tested = [
        i
        for i, one in enumerate(hypothesis.accepted)
        if one.candidate is not CONTACT and not is_shown_by_comparison(hypothesis, i)
    ]
    if not control or not tested:
        return {}
    changes = changes_of(hypothesis, control, tested)
    return {hypothesis.accepted[i].candidate.key: change for i, change in zip(tested, changes, strict=True)}


def changes_of(hypothesis: Hypothesis, control: Sequence[Signals], tested: Sequence[int]) -> tuple[Change, ...]:
    """By how much of itself each of some accepted effects (their indices) differs in the new recordings from the control.

    The effect whose difference is the least certain is taken for alike, and the others are judged again, until all that are left
    are certain: two effects that resemble each other would otherwise hide each other's change. Effects that the model did not
    have go first, because a value that changed is a shorter story than an effect that appeared. The more effects are tested, the more
    certain each must be (Bonferroni). A difference must also be larger than those among the control's recordings and among the new ones,
    and be most of the effect: bristles that were there before, of which a tenth is gone, have not appeared.
    """
    joint = _joint_fit(hypothesis, control, tested)
    known = set(range(len(hypothesis.problem.model.theta)))
    new = {k for k, i in enumerate(tested) if not known & {*hypothesis.extension.places[i].tolist()}}
    left, size = list(range(len(tested))), dict[int, float]()
    while left:
        doubt, size = dict[int, float](), dict[int, float]()
        for k, one in zip(left, joint.differences(left), strict=True):
            beyond_usual = one.usual * len(left) / CERTAIN if joint.scatter(k).count >= ENOUGH else one.usual / UNUSUAL
            doubt[k], size[k] = max(one.noise * len(left) / CERTAIN, beyond_usual), one.size
        doubtful = [k for k in left if doubt[k] >= 1 or size[k] <= MOSTLY]
        if not doubtful:
            doubt = _doubt_without_each_other(joint, left)
            doubtful = [k for k in left if k in new and doubt[k] > UNUSUAL]
        if not doubtful:
            break
        left.remove(max(doubtful, key=lambda k: (k in new, doubt[k], -size[k])))
    return tuple(
        Change(size=size[k]) if k in left else Change(size=0.0, mostly_new=_is_mostly_new(_beside(joint, k, left)))
        for k in range(len(tested))
    )


def _doubt_without_each_other(joint: _JointFit, left: Sequence[int]) -> dict[int, float]:
    """How often noise alone makes the difference of each effect that is ``left`` beside those that differ by themselves: of which nothing differs
    unless another one does, that differs no more by itself, share one torque otherwise than before."""
    alone = {k: _beside(joint, k, ()).noise for k in left}
    own = [k for k in left if alone[k] <= UNUSUAL]
    return alone | {k: _beside(joint, k, own).noise for k in left if k not in own}


def _beside(joint: _JointFit, k: int, others: Sequence[int]) -> Difference:
    """The difference of one effect where some others differ, too, and all the rest is alike."""
    return joint.differences([*others, k])[-1]


def _is_mostly_new(one: Difference) -> bool:
    """Whether noise alone makes no such difference, and it is most of the effect."""
    return one.noise <= CERTAIN and one.size > MOSTLY


@dataclass(frozen=True, kw_only=True)
class Difference:
    """By how much of itself an effect differs in the new recordings, its ``size``, and how often ``noise`` alone, and how often a healthy
    arm as is ``usual``, makes one as large."""

    size: float
    noise: float
    usual: float


@dataclass(frozen=True, kw_only=True, eq=False)
class _JointFit:
    """Control and new recordings in one fit: ``columns`` (M, common + k) and ``torque`` (M,) of each joint in units of its noise.
    The first ``common`` values hold for all rows, each of the others is by how much of itself an effect differs in the new
    ones - those that are ``unseen`` in the control always do -, beside what ``smooth`` functions of the joint's position and velocity explain before and after. ``segment`` (M,) labels contiguous
    rows, ``parts`` are the control and the new recordings, in order. The effects have the columns ``shown`` (M, k) in all rows, and their
    sizes ``scatter`` between the recordings of either part."""

    columns: tuple[Array, ...]
    torque: tuple[Array, ...]
    smooth: tuple[SmoothParts, ...]
    common: int
    segment: NDArray[np.intp]
    parts: tuple[Regressor, Regressor]
    shown: tuple[Array, ...]
    unseen: frozenset[int] = frozenset()
    known: dict[int, Scatter] = field(default_factory=dict, init=False)  # what scatter has computed

    @cached_property
    def rows(self) -> list[tuple[Array, Array]]:
        """Columns and torque of each joint less what the smooth functions explain."""
        each = zip(self.smooth, self.columns, self.torque, strict=True)
        return [(one.taken_off(A), one.taken_off(y)) for one, A, y in each]

    @cached_property
    def products(self) -> tuple[Array, Array]:
        """The normal matrix of all values, and what the torque is worth to them."""
        return np.sum([A.T @ A for A, _ in self.rows], axis=0), np.sum([A.T @ y for A, y in self.rows], axis=0)

    def differences(self, left: Sequence[int]) -> list[Difference]:
        """The differences of the effects that are ``left``, all others being alike, or new where they are unseen in the control."""
        differing = [*left, *sorted(self.unseen - set(left))]
        kept = np.concatenate([np.arange(self.common), self.common + np.asarray(differing, dtype=np.intp)])
        normal, slope = self.products
        inverse = pseudo_inverse(normal[np.ix_(kept, kept)])
        x = inverse @ slope[kept]
        residual = [y - A[:, kept] @ x for A, y in self.rows]
        result = []
        for at, k in enumerate(left, self.common):
            push = sum(A[:, kept] @ inverse[:, at] * r for (A, _), r in zip(self.rows, residual, strict=True))
            size = float(x[at])
            noise, usual = (self._chance(size, np.asarray(push), one) for one in (ALIKE, self.scatter(k)))
            result.append(Difference(size=size, noise=noise, usual=usual))
        return result

    def scatter(self, k: int) -> Scatter:
        """By how much the size of an effect (its place among those tested) differs between a recording before and one after, by
        what the recordings of either time differ among themselves."""
        if k not in self.known:
            effect = [c[:, k] for c in self.shown]
            # what else may have changed is let change, or a recording would show it as this effect
            self.known[k] = scatter_between(self.parts, self.segment, self.columns, self.torque, effect)
        one = self.known[k]
        means = sum(1 / len(np.unique(part.recording)) for part in self.parts)
        return replace(one, variance=one.variance * means)

    def _chance(self, x: float, push: Array, scatter: Scatter) -> float:
        """How often chance makes a difference as large as ``x``, to which each row adds ``push`` (M,), by Student's test over blocks
        and recordings: of blocks of every length the least certain answer counts."""
        from scipy.stats import t

        found = []
        for variance, blocks in block_variances(push, self.segment, self.parts):
            both = max(variance + scatter.variance, 1e-300)
            # degrees of freedom of the sum of two variances (Welch, 1947)
            parts = variance**2 / max(blocks - 1, 1) + scatter.variance**2 / max(scatter.count - 1, 1)
            found.append(float(2 * t.sf(abs(x) / np.sqrt(both), both**2 / max(parts, 1e-300))))
        # an effect that makes no torque in these rows has no size that could be told
        return max(one if np.isfinite(one) else 1.0 for one in found)


def _joint_fit(hypothesis: Hypothesis, control: Sequence[Signals], tested: Sequence[int]) -> _JointFit:
    problem, model = hypothesis.problem, hypothesis.extension.model
    (before, old_weights), (after, new_weights) = (
        rows_of_model(one, signals, problem.filter)
        for one, signals in ((_as_before(hypothesis), control), (model, problem.signals))
    )
    smooth = smooth_parts(model.robot, [(control, old_weights), (problem.signals, new_weights)], problem.filter)
    own = as_others_show(hypothesis, tested, before, after)
    unseen = _unseen(before, after, own.values)
    behind = {int(c) for k in unseen for c in hypothesis.extension.places[tested[k]]}
    common = [c for c in find_base_parameters(model.robot, model.effects).independent if int(c) not in behind]
    columns, torque, shown = [], [], []
    for j in range(model.robot.n):
        old, new = dense(before, j), dense(after, j)
        effects = old @ own.values, own.torque(new, after.recording)
        A = np.block([[old[:, common], np.zeros_like(effects[0])], [new[:, common], effects[1]]])
        y = np.concatenate([before.torque[:, j], after.torque[:, j]])
        sigma = noise_of(A, y)
        columns.append(A / sigma)
        torque.append(y / sigma)
        shown.append(np.concatenate(effects) / sigma)
    return _JointFit(
        columns=tuple(columns),
        torque=tuple(torque),
        smooth=tuple(smooth),
        common=len(common),
        segment=np.concatenate([before.segment, after.segment + before.segment.max() + 1]),
        parts=(before, after),
        shown=tuple(shown),
        unseen=unseen,
    )


def _as_before(hypothesis: Hypothesis) -> Model:
    """The extended model with the values from before, by which its own recordings were loaded: a payload that is new loaded no gear then."""
    model, known = hypothesis.extension.model, hypothesis.problem.model.theta
    return replace(model, theta=np.concatenate([known, np.zeros(len(model.theta) - len(known))]))


def _unseen(before: Regressor, after: Regressor, values: Array) -> frozenset[int]:
    """Which effects, of ``values`` (p, k), hardly act in the control: as a temperature that nobody measured then, they can only be new."""
    power = [
        np.sum([np.mean((dense(rows, j) @ values) ** 2, axis=0) for j in range(len(rows.joints))], axis=0)
        for rows in (before, after)
    ]
    return frozenset(np.flatnonzero(power[0] < UNSEEN**2 * power[1]).tolist())


def rows_of_model(model: Model, signals: Sequence[Signals], filter: Filter) -> tuple[Regressor, Array]:
    """The regressor of the extended model, its rows weighted by what dry friction leaves open, and the weights (M, n)."""
    regressor = build_regressor(model.robot, model.effects, signals, filter, model=model)
    weights = row_weights(model.robot, model.effects, regressor, signals, filter)
    return weight_rows(regressor, weights), weights * regressor.counted


def noise_of(columns: Array, torque: Array) -> float:
    """Standard deviation [N m|N] of what one joint's columns leave of its torque."""
    scale = np.linalg.norm(columns, axis=0)
    used = columns[:, scale > 0] / scale[scale > 0]
    residual = torque - used @ np.linalg.lstsq(used, torque, rcond=1e-9)[0]
    return max(float(np.sqrt(np.mean(residual**2))), 1e-9 * max(1.0, float(np.abs(torque).max())))
