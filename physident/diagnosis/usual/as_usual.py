"""Which findings are friction and offsets as they differ between recordings of the healthy arm, and what that leaves open of others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.grading.members import is_shown_by_comparison
from physident.diagnosis.problem.columns import Columns
from physident.diagnosis.remainder.friction_between import moved_friction
from physident.diagnosis.search.contact_scan import CONTACT
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.stored_products import Key
from physident.diagnosis.usual.other_joints import as_other_joints_show
from physident.diagnosis.usual.usual_friction import FEWEST, UsualFriction, as_large
from physident.dynamics.friction_parameters import friction_values
from physident.effects.classification import Family
from physident.effects.measurement import TimeDelay, TorqueDelay
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
TOO_FEW = f"because fewer than {FEWEST} recordings do not tell by how much"
MADE_OF = 0.8  # of the power of an effect's torque: what friction of its joint and an offset make as well is a change of these


@dataclass(frozen=True, kw_only=True)
class UsualChange:
    """The ``share`` of its friction by which a joint, or the arm, differs, as an ``is_offset`` or by its friction, at most the ``usual`` one, as
    ``recordings`` of them tell."""

    share: float
    usual: float
    recordings: int
    is_offset: bool = False


def usual_in_words(changes: Sequence[UsualChange]) -> str:
    """Why changes are none; empty without any."""
    if not changes:
        return ""
    largest = max(changes, key=lambda one: one.share)
    tell = f"as far as {largest.recordings} of them tell" if largest.recordings >= FEWEST else TOO_FEW
    return (
        f"{'an offset of ' if largest.is_offset else ''}{100 * largest.share:.2g} % of the friction, by which healthy recordings may differ, too"
        f" (up to {100 * largest.usual:.2g} %, {tell})"
    )


def usual_friction(hypothesis: Hypothesis, control: Sequence[Signals], partners: int) -> UsualFriction | None:
    """By how much friction and offsets differ by themselves from those of the control, of which so many ``partners`` were taken off the new
    recordings; None where nothing was found that this is asked of, or there is no control."""
    problem = hypothesis.problem
    if problem.question != "different" or not control or not np.any(friction_values(problem.model)):
        return None
    if not any(one.candidate is not CONTACT for one in hypothesis.accepted):
        return None
    if len(control) < FEWEST:
        return UsualFriction.unknown(len(control))
    usual = UsualFriction.of(problem.model, control, problem.filter, partners or len(control))
    return as_other_joints_show(hypothesis, usual)


def differ_as_usual(hypothesis: Hypothesis, usual: UsualFriction | None) -> dict[Key, UsualChange]:
    """The accepted effects that are friction and offsets as they differ between recordings of the healthy arm: what no scale of the joint's
    dry friction and of its other friction makes is a small part of them, and of all that has changed of the joint's friction, or what
    these and an offset do not.

    Along repeated motions an effect is what has changed. Along others the model's parameters have moved as well, and several effects may
    bend a joint's friction where it has only grown: there they are judged together. Everywhere, what several laws of a joint's friction take
    back of each other has not changed.
    """
    if usual is None:
        return {}
    compared, found = compared_rows(hypothesis), dict[Key, UsualChange]()
    alone, together, laws = list[int](), list[int](), {True: list[int](), False: list[int]()}
    for i, one in enumerate(hypothesis.accepted):
        # that all of a late channel lags, and not its friction alone, was seen when it was accepted
        if one.candidate is CONTACT or isinstance(one.effect, TorqueDelay | TimeDelay):
            continue
        shown = is_shown_by_comparison(hypothesis, i)
        if one.effect.family is Family.FRICTION or one.effect.variable == "velocity":
            laws[shown].append(i)
        if shown:
            alone.append(i)
        else:
            change = _made_of_friction(hypothesis, hypothesis.torque_of(i), ~compared, usual.parts, False)
            together += [i] if change.made >= MADE_OF * change.power > 0 else []
    for i in alone:
        found |= _as_usual(hypothesis, i, usual, [i], compared) or _as_usual(
            hypothesis, i, usual, [i], compared, with_offsets=True
        )
    for i in together:
        found |= _as_usual(hypothesis, i, usual, together, ~compared)
    for shown, several in laws.items():
        for i in several if len(several) > 1 else ():
            found |= _as_usual(hypothesis, i, usual, several, compared if shown else ~compared)
    return found


def compared_rows(hypothesis: Hypothesis) -> NDArray[np.bool_]:
    """Which rows (M,) repeat a motion."""
    problem = hypothesis.problem
    return np.isin(problem.regressor.recording, sorted(problem.freedom.compared))


def friction_of_the_day(hypothesis: Hypothesis, usual: UsualFriction | None) -> Columns | None:
    """One standard deviation of what each joint's friction and its offset (M, 2 n) differ by themselves, in the compared rows: what a value along
    a repeated motion is uncertain by beside noise. None where nobody knows, and along other motions, where the model's friction moves."""
    problem, regressor = hypothesis.problem, hypothesis.data.regressor
    if usual is None or not problem.freedom.compared:
        return None
    rows = compared_rows(hypothesis)
    values, joints = np.sum(friction_values(problem.model), axis=0), []
    for j, joint in enumerate(regressor.joints):
        own = joint.columns < len(values)
        friction = rows * (joint.values[:, own] @ values[joint.columns[own]])
        offset = as_large(rows * problem.weights[:, j], friction)
        both = np.column_stack([usual.spread * friction, usual.offset_spread * offset])
        joints.append((np.array([2 * j, 2 * j + 1]), both))
    return Columns(2 * len(joints), len(rows), tuple(joints))


@dataclass(frozen=True, kw_only=True)
class _Change:
    """How much of the ``power`` of a torque, in units of the noise, its joints' friction and offsets ``made``, and the ``size`` of the one
    and of the ``offset`` beside all friction."""

    power: float
    made: float
    size: float
    offset: float


def _as_usual(
    hypothesis: Hypothesis,
    i: int,
    usual: UsualFriction,
    several: Sequence[int],
    rows: NDArray[np.bool_],
    with_offsets: bool = False,
) -> dict[Key, UsualChange]:
    """What an accepted effect changes as usual, as the torque of ``several`` on its joints shows in some ``rows`` (M,), along other motions
    beside what the model's friction has moved by; nothing where it is more, or where friction leaves more than a part of the effect."""
    one, own = hypothesis.accepted[i].candidate, hypothesis.torque_of(i)
    moved = 0.0 if is_shown_by_comparison(hypothesis, i) else moved_friction(hypothesis)
    whole = (moved + sum(hypothesis.torque_of(k) for k in several)) * np.any(own != 0, axis=0)
    change = _made_of_friction(hypothesis, whole, rows, usual.parts, with_offsets)
    most = usual.joint if one.joints else usual.arm
    least = max(change.power, float(np.sum((own[rows] / hypothesis.fit.sigma) ** 2)))
    if change.made < change.power - (1 - MADE_OF) * least or change.size > most or change.offset > usual.offset:
        return {}
    is_offset = change.offset > change.size
    share, limit = (change.offset, usual.offset) if is_offset else (change.size, most)
    return {one.key: UsualChange(share=share, usual=limit, recordings=usual.recordings, is_offset=is_offset)}


def _made_of_friction(
    hypothesis: Hypothesis, torque: Array, rows: NDArray[np.bool_], how_many: int, with_offsets: bool
) -> _Change:
    """A torque (M, n), as the dry and the other friction of each joint, where either is scaled, make it, or as all of it makes it (``how_many``
    parts, one or two), and an offset, in some ``rows`` (M,)."""
    problem = hypothesis.problem
    parts = np.column_stack(friction_values(problem.model))
    parts = parts if how_many > 1 else parts.sum(axis=1, keepdims=True)
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
    return _Change(power=power, made=made, size=sizes[0], offset=sizes[1])
