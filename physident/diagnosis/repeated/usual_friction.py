"""Friction and offsets along a repeated motion that differ from before by no more than they do between recordings of the healthy arm.

A comparison takes off what the model lacks, and sees changes of a per cent. Friction changes by as much from day to day by itself, and so do
the zeros of sensors: by how much, the recordings say that the model was fitted to, of which each is held against the others.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.grading.as_others_show import dense
from physident.diagnosis.grading.control import UNUSUAL, noise_of, rows_of_model
from physident.diagnosis.grading.members import is_shown_by_comparison
from physident.diagnosis.grading.scatter import Scatter, scatter_between
from physident.diagnosis.problem.columns import Columns
from physident.diagnosis.search.contact_scan import CONTACT
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.stored_products import Key
from physident.dynamics.model import Model
from physident.effects.classification import Family
from physident.identifiability.base_parameters import find_base_parameters
from physident.recordings.signals import Filter, Signals

Array = NDArray[np.float64]
FEWEST = 3  # recordings: two say that they differ, and not by how much recordings usually do
LARGEST = 0.1  # of the friction: a larger change is worth a look, however far a few recordings, and what the model lacks, are apart
MADE_OF = 0.8  # of the power of an effect's torque: what friction of its joint and an offset make as well is a change of these


@dataclass(frozen=True, kw_only=True)
class UsualFriction:
    """By which share of its friction a ``joint`` of a healthy arm differs at most between the recordings before and now, and the whole
    ``arm``, all joints of which differ alike: one of twenty healthy arms differs by more on any joint; at most a tenth. ``offset`` is the most of
    a joint's torque offset, as a share of the RMS of its friction. ``spread`` and ``offset_spread`` are standard deviations of a joint's shares."""

    joint: float
    arm: float
    offset: float
    spread: float
    offset_spread: float

    @staticmethod
    def of(model: Model, control: Sequence[Signals], filter: Filter, old: int, new: int) -> UsualFriction:
        """What the ``control`` says of the means of ``old`` recordings before and ``new`` ones."""
        from scipy.stats import t

        regressor, weights = rows_of_model(model, control, filter)
        n, values = model.robot.n, np.sum(friction_values(model), axis=0)
        common = list(find_base_parameters(model.robot, model.effects).independent)
        columns, torque, friction, constant = [], [], [], []
        for j in range(n):
            every, y = dense(regressor, j), regressor.torque[:, j]
            sigma = noise_of(every[:, common], y)
            columns.append(every[:, common] / sigma)
            torque.append(y / sigma)
            friction.append(every @ values / sigma)
            constant.append(_as_large(weights[:, j], friction[j]))

        def scatter(effect: Sequence[Array], joints: Collection[int]) -> Scatter:
            some = [one if j in joints else np.zeros_like(one) for j, one in enumerate(effect)]
            return scatter_between([regressor], regressor.segment, columns, torque, some)

        means = float(np.sqrt(1 / old + 1 / new))

        def of_joints(effect: Sequence[Array]) -> tuple[float, float]:
            """The most, and the standard deviation, of a joint's share."""
            seen = [one for one in (scatter(effect, [j]) for j in range(n)) if one.count > 1]
            freedom = max(sum(one.count - 1 for one in seen), 1)
            spread = means * np.sqrt(sum(one.variance * (one.count - 1) for one in seen) / freedom)
            return min(LARGEST, float(t.ppf(1 - UNUSUAL / (2 * n), freedom) * spread)), float(spread)

        whole = scatter(friction, range(n))
        arm = t.ppf(1 - UNUSUAL / 2, max(whole.count - 1, 1)) * np.sqrt(whole.variance) * means
        (joint, spread), (offset, offset_spread) = of_joints(friction), of_joints(constant)
        return UsualFriction(
            joint=joint, arm=min(LARGEST, float(arm)), offset=offset, spread=spread, offset_spread=offset_spread
        )


def _as_large(weights: Array, friction: Array) -> Array:
    """A constant in weighted rows (M,) that is as large as the RMS of friction there."""
    rows = float(weights @ weights)
    return weights * (np.linalg.norm(friction) / np.sqrt(rows) if rows else 0.0)


def friction_values(model: Model) -> tuple[Array, Array]:
    """The model's parameters (p,) with those of dry friction alone, and with those of all other friction."""
    parts, at = (np.zeros(len(model.theta)), np.zeros(len(model.theta))), 0
    for effect, values in model.effect_parameters():
        if effect.family is Family.FRICTION:
            parts[0 if effect.dry else 1][at : at + len(values)] = values
        at += len(values)
    return parts


@dataclass(frozen=True, kw_only=True)
class UsualChange:
    """The ``share`` of its friction by which a joint, or the arm, differs, as an ``is_offset`` or by its friction, at most the ``usual`` one, as
    ``recordings`` of them tell."""

    share: float
    usual: float
    recordings: int
    is_offset: bool = False


def usual_in_words(changes: Sequence[UsualChange]) -> str:
    """Why changes are none, and what would tell; empty without any."""
    if not changes:
        return ""
    largest = max(changes, key=lambda one: one.share)
    return (
        f"{'an offset of ' if largest.is_offset else ''}{100 * largest.share:.2g} % of the friction, by which healthy recordings may differ, too"
        f" (up to {100 * largest.usual:.2g} %, as far as {largest.recordings} from before tell; more of them tell smaller changes)"
    )


def usual_friction(hypothesis: Hypothesis, control: Sequence[Signals], old: int) -> UsualFriction | None:
    """By how much friction and offsets differ by themselves, beside a comparison with ``old`` recordings that shows something; None where it shows
    nothing, or too few recordings tell."""
    problem = hypothesis.problem
    if not _shown(hypothesis) or len(control) < FEWEST or not np.any(friction_values(problem.model)):
        return None
    return UsualFriction.of(problem.model, control, problem.filter, old, len(problem.freedom.compared))


def differ_as_usual(hypothesis: Hypothesis, usual: UsualFriction | None, recordings: int) -> dict[Key, UsualChange]:
    """The accepted effects that a comparison shows, and that are friction and offsets as they differ between so many ``recordings`` of the healthy
    arm: what no scale of the joint's dry friction and of its other friction makes is a small part of them, or what these and an offset do not."""
    result = dict[Key, UsualChange]()
    if usual is None:
        return result
    for i in _shown(hypothesis):
        one = hypothesis.accepted[i].candidate
        most = usual.joint if one.joints else usual.arm
        for change in (
            _made_of_friction(hypothesis, i, with_offsets=False),
            _made_of_friction(hypothesis, i, with_offsets=True),
        ):
            if change.share >= MADE_OF:
                if change.size <= most and change.offset <= usual.offset:
                    is_offset = change.offset > change.size
                    share, limit = (change.offset, usual.offset) if is_offset else (change.size, most)
                    result[one.key] = UsualChange(share=share, usual=limit, recordings=recordings, is_offset=is_offset)
                break
    return result


def friction_of_the_day(hypothesis: Hypothesis, usual: UsualFriction | None) -> Columns | None:
    """One standard deviation of what each joint's friction and its offset (M, 2 n) differ by themselves, in the compared rows: what a value along
    a repeated motion is uncertain by beside noise. None where nobody knows."""
    if usual is None:
        return None
    problem, regressor = hypothesis.problem, hypothesis.data.regressor
    rows = np.isin(problem.regressor.recording, sorted(problem.freedom.compared))
    values, joints = np.sum(friction_values(problem.model), axis=0), []
    for j, joint in enumerate(regressor.joints):
        own = joint.columns < len(values)
        friction = rows * (joint.values[:, own] @ values[joint.columns[own]])
        offset = _as_large(rows * problem.weights[:, j], friction)
        both = np.column_stack([usual.spread * friction, usual.offset_spread * offset])
        joints.append((np.array([2 * j, 2 * j + 1]), both))
    return Columns(2 * len(joints), len(rows), tuple(joints))


def _shown(hypothesis: Hypothesis) -> list[int]:
    """Which accepted effects, but contacts, a comparison shows."""
    return [
        i
        for i, one in enumerate(hypothesis.accepted)
        if one.candidate is not CONTACT and is_shown_by_comparison(hypothesis, i)
    ]


@dataclass(frozen=True, kw_only=True)
class _Change:
    """Which ``share`` of the power of an effect's torque its joints' friction and offsets can make, and the ``size`` of the one and of the
    ``offset`` beside all friction."""

    share: float
    size: float
    offset: float


def _made_of_friction(hypothesis: Hypothesis, i: int, with_offsets: bool) -> _Change:
    """The torque of an accepted effect in compared rows, as the dry and the other friction of each joint, where either is scaled, make it, and
    an offset."""
    problem, one = hypothesis.problem, hypothesis.accepted[i]
    torque = hypothesis.columns(one.candidate, one.effect).torque(hypothesis.effect_values[i])
    rows = np.isin(problem.regressor.recording, sorted(problem.freedom.compared))
    parts = np.column_stack(friction_values(problem.model))
    scaled = constant = made = whole = power = 0.0
    for j, (joint, sigma) in enumerate(zip(problem.regressor.joints, hypothesis.fit.sigma, strict=True)):
        wanted = torque[rows, j] / sigma
        power += float(wanted @ wanted)
        own = joint.columns < len(parts)
        friction = joint.values[rows][:, own] @ parts[joint.columns[own]] / sigma
        if not (wanted.any() and friction.any()):
            continue
        columns = np.column_stack([friction, with_offsets * problem.weights[rows, j] / sigma])
        best = columns * np.linalg.lstsq(columns, wanted, rcond=1e-9)[0]
        made += float(np.sum(best.sum(axis=1) ** 2))
        scaled += float(np.sum(best[:, :-1].sum(axis=1) ** 2))
        constant += float(np.sum(best[:, -1] ** 2))
        whole += float(np.sum(friction.sum(axis=1) ** 2))
    sizes = [float(np.sqrt(one / whole)) if whole > 0 else np.inf for one in (scaled, constant)]
    return _Change(share=made / power if power > 0 else 0.0, size=sizes[0], offset=sizes[1])
