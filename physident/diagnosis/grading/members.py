"""Which accepted effects a finding joins, and what the others are worth without those of some findings."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.result.findings import Finding, ParameterValue
from physident.diagnosis.result.values import parameter_values, values_in_words
from physident.diagnosis.rivals.successors import with_no_successor
from physident.diagnosis.search.hypothesis import Hypothesis, state_hypothesis, values_move
from physident.diagnosis.statistics.intervals import Uncertainty
from physident.diagnosis.statistics.stored_products import Key

Array = NDArray[np.float64]


def members(hypothesis: Hypothesis, finding: Finding) -> list[int]:
    """The accepted effects of a hypothesis (their indices) that a finding joins."""
    return [
        i
        for i, one in enumerate(hypothesis.accepted)
        if one.candidate.name == finding.effect
        and set(one.candidate.joints) <= set(finding.joints)
        and getattr(one.effect, "recording", "") == finding.recording
    ]


def without(hypothesis: Hypothesis, findings: Sequence[Finding]) -> Hypothesis:
    """The hypothesis without the effects of some findings, all others refitted."""
    return without_effects(hypothesis, {i for finding in findings for i in members(hypothesis, finding)})


def without_effects(hypothesis: Hypothesis, dropped: Collection[int]) -> Hypothesis:
    """The hypothesis without some of its accepted effects (their indices), all others refitted."""
    if not dropped:
        return hypothesis
    kept = [one for i, one in enumerate(hypothesis.accepted) if i not in dropped]
    return state_hypothesis(hypothesis.problem, kept, hypothesis.model, hypothesis.data)


def decides_values(hypothesis: Hypothesis, finding: Finding) -> bool:
    """Whether a finding is of effects that any arm has and the model lacks, as friction and offsets, without which the values of others would be
    other ones: however unsure it is, nobody knows it to be zero."""
    ordinary = {one.candidate.key for one in hypothesis.problem.missing_default_effects}
    own = [one for i in members(hypothesis, finding) if (one := hypothesis.accepted[i]).candidate.key in ordinary]
    return bool(with_no_successor(hypothesis, own)) and values_move(without(hypothesis, [finding]), hypothesis)


def where_it_shows(hypothesis: Hypothesis, group: Collection[int]) -> Array:
    """The share (n,) of what accepted effects (their indices) change of the residual, all others refitted, that lies on each joint, in
    units of the noise: a load that only the wrist feels is judged there, whatever the shoulder's friction leaves. Of several effects,
    each counts alike."""
    shares = []
    for one in group:
        rest = without_effects(hypothesis, [one])
        change = (rest.fit.residual - hypothesis.fit.residual) / hypothesis.fit.sigma
        power = np.sum(change * change, axis=0)
        shares.append(power / max(float(power.sum()), 1e-300))
    return np.mean(shares, axis=0)


def weighted_rows(hypothesis: Hypothesis, some: NDArray[np.bool_] | slice = slice(None)) -> Array:
    """How many rows (n,) of each joint, or of ``some``, count, a row that a rest leaves half open as half a row."""
    problem = hypothesis.problem
    return np.sum((problem.weights**2 * problem.regressor.counted)[some], axis=0)


def is_shown_by_comparison(hypothesis: Hypothesis, i: int) -> bool:
    """Whether most of what is known of an accepted effect comes from compared recordings."""
    problem = hypothesis.problem
    if not problem.freedom.compared:
        return False
    power = ((hypothesis.torque_of(i) / hypothesis.fit.sigma) ** 2).sum(axis=1)
    rows = np.isin(problem.regressor.recording, sorted(problem.freedom.compared))
    return bool(power[rows].sum() >= power[~rows].sum())


def with_values(hypothesis: Hypothesis, findings: Sequence[Finding], uncertainty: Uncertainty) -> tuple[Finding, ...]:
    """The findings with the values that a hypothesis gives them; those whose effects it does not hold stay as they are.

    A hint beside a cause takes a part of it, but the extended model does not carry the hint: its values are the cause's.
    """
    result = []
    for finding in findings:
        accepted = sorted(
            (hypothesis.accepted[i] for i in members(hypothesis, finding)), key=lambda a: a.candidate.joints
        )
        values = tuple(v for one in accepted for v in parameter_values(hypothesis, one, uncertainty))
        words = values_in_words(hypothesis, accepted, uncertainty)
        result.append(replace(finding, parameters=values, in_words=words) if values else finding)
    return tuple(result)


def with_changes(findings: Sequence[Finding], sizes: Mapping[Key, float]) -> tuple[Finding, ...]:
    """The findings whose values the model has, with by how much they changed: ``sizes`` times what was found. Where the model lacks
    something of the same kind, its value was never that of the arm, and the difference no change of the arm's."""
    return tuple(
        replace(finding, parameters=tuple(_times(v, _size_of(finding, v.joint, sizes)) for v in finding.parameters))
        for finding in findings
    )


def _times(v: ParameterValue, size: float) -> ParameterValue:
    """A value whose change is so many times as large; a new one, and one of no known size, as it is."""
    if v.change == v.value or not size:
        return v
    low, high = sorted(size * end for end in v.change_interval95)
    return replace(v, change=v.change * size, change_interval95=(low, high))


def _size_of(finding: Finding, joint: int, sizes: Mapping[Key, float]) -> float:
    """By how much of itself the effect of a finding at a joint differs; zero where that is not known."""
    return next((size for (name, joints), size in sizes.items() if name == finding.effect and joint in joints), 0.0)
