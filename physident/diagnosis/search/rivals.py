"""What else it could be: candidates that may take an accepted effect's place at no price the data can tell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.candidates import Candidate
from physident.diagnosis.search.acceptance import CLOSEST, as_good, costs, possible_sign, replaces
from physident.diagnosis.search.candidate_scores import Look
from physident.diagnosis.search.contact import CONTACT, scan
from physident.diagnosis.search.hypothesis import Accepted, State
from physident.diagnosis.search.shape_refinement import refined
from physident.diagnosis.statistics.left_out_gains import gains
from physident.diagnosis.statistics.normal_equations import inverted, whitening

Array = NDArray[np.float64]
CONTAINED = 0.01  # share of an effect's torque outside a larger one's columns: a hundredfold record would not show it


@dataclass(frozen=True, eq=False)
class Examined:
    """An accepted effect beside all others: its left-out ``gain``, and the candidates that could stand in its place."""

    accepted: Accepted
    gain: float
    rivals: tuple[Candidate, ...]


def examine(last: Look, accepted: Accepted) -> Examined:
    """The left-out gain of an accepted effect beside all others, and its rivals."""
    state = last.state
    rest = state.case.state([a for a in state.accepted if a is not accepted], state.model, state.evidence)
    if accepted.candidate is CONTACT:
        return Examined(accepted, float(scan(rest, rest.evidence.response[:, :, None]).evidence[0]), ())
    found = gains(rest.evidence, rest.baseline, rest.fit, rest.evidence.response[:, :, None]).evidence[:, 0]
    candidates = rest.evidence.candidates
    own = next(c for c in candidates if c.key == accepted.candidate.key)
    gain = float(found[candidates.index(own)])
    rivals, cost = [], costs(rest, own, state.fit.weights)
    for index in np.argsort(-found)[: CLOSEST + 1]:
        other = candidates[int(index)]
        # a rival must itself be evidence, and its place must be free of the effect it would replace
        if other is own or other.placebo or found[index] < last.threshold:
            continue
        if not as_good(rest, other, cost, state.fit.weights):
            continue
        if other.size > own.size and _contains(rest, other, accepted):
            continue
        if replaces(rest, other, own, last.threshold) and possible_sign(rest, other) is None:
            rivals.append(other)
    return Examined(accepted, gain, tuple(rivals))


def _contains(rest: State, other: Candidate, accepted: Accepted) -> bool:
    """Whether a larger candidate imitates the accepted effect because it contains it."""
    weights = rest.fit.weights
    inside = rest.baseline.joined(rest.case.columns(refined(rest, other), rest.model))
    columns = rest.case.columns(accepted.effect, rest.model)
    values = _value(rest, columns)
    torque = [w * (c @ values) for w, c in zip(weights, columns, strict=True)]

    def left(baseline_joints: tuple[Array, ...], prior: Array) -> float:
        B = [w * own for w, own in zip(weights, baseline_joints, strict=True)]
        H = np.sum([own.T @ own for own in B], axis=0) + np.diag(prior)
        slope = np.sum([own.T @ t for own, t in zip(B, torque, strict=True)], axis=0)
        return float(sum(t @ t for t in torque) - slope @ inverted(H) @ slope)

    before = left(rest.baseline.joints, rest.baseline.prior)
    return left(inside.joints, inside.prior) < CONTAINED * before


def _value(rest: State, columns: list[Array]) -> Array:
    """The values (k,) of columns that join a state's baseline."""
    weights = rest.fit.weights
    C = [w * own for w, own in zip(weights, columns, strict=True)]
    B = [w * own for w, own in zip(weights, rest.baseline.joints, strict=True)]
    cross = np.sum([b.T @ c for b, c in zip(B, C, strict=True)], axis=0)
    inner = np.sum([c.T @ c for c in C], axis=0)
    slope = np.sum([c.T @ (w * r) for c, w, r in zip(C, weights, rest.fit.residual.T, strict=True)], axis=0)
    root = whitening(inner[None], (inner - cross.T @ inverted(rest.fit.normal) @ cross)[None])[0]
    return root @ (root.T @ slope)
