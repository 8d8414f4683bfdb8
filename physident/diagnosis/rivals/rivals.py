"""Rivals: candidates that could stand in an accepted effect's place as far as the data can tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import AcceptedEffect, Candidate
from physident.diagnosis.rivals.pairs import rivals_of_two
from physident.diagnosis.rivals.refuted import is_refuted
from physident.diagnosis.rivals.whole_friction import WholeFriction
from physident.diagnosis.search.acceptance import MAX_COMPARED, contradiction, is_as_good, makes_redundant
from physident.diagnosis.search.candidate_scores import CandidateScores, contact_thresholds
from physident.diagnosis.search.contact_scan import CONTACT, scan_contacts
from physident.diagnosis.search.hypothesis import Hypothesis, state_hypothesis
from physident.diagnosis.search.left_out_costs import contradicted, left_out_costs
from physident.diagnosis.search.shape_refinement import refine_shape
from physident.diagnosis.statistics.baseline_products import BaselineProducts
from physident.diagnosis.statistics.left_out_gains import left_out_gains
from physident.diagnosis.statistics.normal_equations import pseudo_inverse, whitening
from physident.diagnosis.statistics.stored_products import Key
from physident.processes import mapped

Array = NDArray[np.float64]
CONTAINED = 0.01  # share of an effect's torque outside a larger one's columns: a hundredfold record would not show it


@dataclass(frozen=True, eq=False)
class RivalCheck:
    """An accepted effect beside all others: its left-out ``gain`` and the ``threshold`` of that (None: not asked), the candidates that could stand
    in its place as far as these recordings can tell, those that make the ``same`` torque on any motion, and ``larger`` laws of its joints
    that contain it. ``friction``: the change of all friction of its joint that makes this torque, too; None where none does."""

    accepted: AcceptedEffect
    gain: float
    rivals: tuple[Candidate, ...]
    same: tuple[Candidate, ...] = ()
    larger: tuple[Candidate, ...] = ()
    friction: WholeFriction | None = None
    threshold: float | None = None


def check_every_rival(
    last: CandidateScores, same: Mapping[Key, Sequence[Candidate]], friction: Mapping[Key, WholeFriction]
) -> list[RivalCheck]:
    """Every accepted effect beside all others, on all processors; see ``check_rivals``."""
    hypothesis = last.hypothesis
    candidates = {one.key: one for one in hypothesis.problem.candidates}
    keys = [one.candidate.key for one in hypothesis.accepted]

    # names and places: effects of users cannot be sent between processes
    def found(i: int) -> tuple[float, float | None, list[list[Key]]]:
        check = check_rivals(last, hypothesis.accepted[i], same.get(keys[i], ()))
        names = [[one.key for one in some] for some in (check.rivals, check.same, check.larger)]
        return check.gain, check.threshold, names

    told = zip(hypothesis.accepted, keys, mapped(found, range(len(keys))), strict=True)
    checks = []
    for one, key, (gain, threshold, names) in told:
        some = (tuple(candidates[k] for k in each) for each in names)
        checks.append(RivalCheck(one, gain, *some, friction=friction.get(key), threshold=threshold))
    return checks


def check_rivals(
    last: CandidateScores,
    accepted: AcceptedEffect,
    same: Sequence[Candidate] = (),
) -> RivalCheck:
    """The left-out gain of an accepted effect beside all others, and its rivals; the ``same`` ones where they are possible."""
    hypothesis = last.hypothesis
    others = [a for a in hypothesis.accepted if a is not accepted]
    rest = state_hypothesis(hypothesis.problem, others, hypothesis.model, hypothesis.data)
    if accepted.candidate is CONTACT:
        push = scan_contacts(rest, rest.data.response[:, :, None])
        return RivalCheck(accepted, float(push.evidence[0]), (), threshold=contact_thresholds(rest)[0])
    gains = left_out_gains(rest.data, rest.baseline, rest.fit, products=rest.products).evidence[:, 0]
    candidates, weights = rest.data.candidates, hypothesis.fit.weights
    accepted_candidate = next(c for c in candidates if c.key == accepted.candidate.key)
    rivals, cost = [], left_out_costs(rest, accepted_candidate, weights)
    chi_squared = contradicted(rest, accepted_candidate)
    for index in np.argsort(-gains)[: MAX_COMPARED + 1]:
        other = candidates[int(index)]
        # a rival must itself be evidence, and its place must be free of the effect it would replace
        if other is accepted_candidate or other.placebo or gains[index] < last.threshold:
            continue
        if not is_as_good(rest, other, cost, weights, chi_squared):
            continue
        if other.size > accepted_candidate.size and _contains(rest, other, accepted):
            continue
        if makes_redundant(rest, other, accepted_candidate, last.threshold) and contradiction(rest, other) is None:
            rivals.append(other)
    rivals += [
        one
        for one in rivals_of_two(rest, accepted_candidate, cost, weights, chi_squared, last.threshold)
        if one not in rivals
    ]
    possible = tuple(
        c
        for c in same
        if contradiction(rest, c) is None
        and (_are_dry(c, accepted) or not is_refuted(cost, left_out_costs(rest, c, weights)))
    )
    alike = (c for c, gain in zip(candidates, gains, strict=True) if gain >= last.threshold and _is_larger(c, accepted))
    larger = tuple(c for c in alike if _contains(rest, c, accepted))
    gain = float(gains[candidates.index(accepted_candidate)])
    least = last.threshold_of(accepted.candidate.key, others)
    return RivalCheck(accepted, gain, tuple(rivals), possible, larger, threshold=least)


def _are_dry(other: Candidate, accepted: AcceptedEffect) -> bool:
    """Whether both are dry friction, which differs near reversals alone, where a noisy velocity hardly tells."""
    effect = other.options[0].effect
    return effect is not None and effect.dry and accepted.effect.dry


def _is_larger(other: Candidate, accepted: AcceptedEffect) -> bool:
    """Whether a candidate is of the same family and joints as an accepted effect, and has more numbers."""
    one, effect = accepted.candidate, other.options[0].effect
    larger = other.joints == one.joints and other.size > one.size
    return larger and effect is not None and effect.family is accepted.effect.family


def _contains(rest: Hypothesis, other: Candidate, accepted: AcceptedEffect) -> bool:
    """Whether a larger candidate imitates the accepted effect because it contains it."""
    columns = rest.columns(accepted.candidate, accepted.effect)
    inner, cross, slope = (_weighted(rest, part) for part in rest.products.with_columns(columns))
    root = whitening(inner[None], (inner - cross.T @ pseudo_inverse(rest.fit.normal) @ cross)[None])[0]
    values = root @ (root.T @ (slope - cross.T @ rest.fit.x))  # with which the effect joins the baseline
    power, pull = float(values @ inner @ values), cross @ values
    more = rest.columns(other, refine_shape(rest, other))
    beside = BaselineProducts(rest.data, rest.baseline.joined(more))
    H = np.tensordot(rest.fit.weights**2, beside.equations.squares, 1) + np.diag(beside.baseline.prior)
    both = _weighted(rest, beside.with_columns(columns)[1]) @ values
    before = power - pull @ pseudo_inverse(rest.fit.normal) @ pull
    return bool(power - both @ pseudo_inverse(H) @ both < CONTAINED * before)


def _weighted(rest: Hypothesis, products: Array) -> Array:
    """Products (n, ...) summed over the joints by their weights."""
    return np.tensordot(rest.fit.weights**2, products, 1)
