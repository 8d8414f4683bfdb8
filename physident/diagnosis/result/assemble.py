"""From accepted effects to findings: joined over joints, with values, gains, rivals and advice."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.grading.members import weighted_rows, where_it_shows
from physident.diagnosis.learned.describe import curve_band
from physident.diagnosis.problem.candidates import AcceptedEffect, prior_precision
from physident.diagnosis.problem.columns import joined_columns
from physident.diagnosis.problem.folds import blocks
from physident.diagnosis.result.advice import other_rival, separating_words
from physident.diagnosis.result.findings import Finding, Reduction, Rival
from physident.diagnosis.result.values import parameter_values, values_in_words
from physident.diagnosis.result.wording import listed
from physident.diagnosis.rivals.rivals import RivalCheck
from physident.diagnosis.search.contact_scan import CONTACT, scan_contacts
from physident.diagnosis.search.hypothesis import Hypothesis, state_hypothesis
from physident.diagnosis.stability.trust import Trust
from physident.diagnosis.statistics.intervals import RESAMPLES, Uncertainty, resampled_reduction
from physident.effects.catalogue import effect_label, effect_scope
from physident.effects.scales.friction_level import FrictionLevel

Array = NDArray[np.float64]
SCALED = (
    "Found from currents: the mass scales with the drive gains; physident drive-gains finds them with a known load."
)


def make_findings(
    hypothesis: Hypothesis,
    checks: Sequence[RivalCheck],
    uncertainty: Uncertainty,
    from_currents: bool = False,
    trust: Mapping[tuple[str, tuple[int, ...]], Trust] | None = None,
    alike: frozenset[tuple[str, tuple[int, ...]]] = frozenset(),
) -> tuple[Finding, ...]:
    """One finding for each cause, the same effect on several joints joined, in order of left-out gain.

    A payload found ``from_currents`` says what its mass depends on. Joints whose ``trust`` has doubts, and those that a
    control shows ``alike``, are findings of their own, so that they take nothing from the others.
    """
    trust = trust or {}
    groups: dict[object, list[RivalCheck]] = {}
    before = [one for one in hypothesis.accepted if one.candidate.key in alike]
    for check in checks:
        name, doubtful = check.accepted.candidate.name, bool(trust.get(check.accepted.candidate.key, Trust()).doubts)
        key = name if effect_scope(name).joins_joints else check.accepted.candidate.key
        old = check.accepted.candidate.key in alike
        groups.setdefault((key, doubtful, old, getattr(check.accepted.effect, "recording", "")), []).append(check)
    found = [_finding(hypothesis, group, uncertainty, from_currents, trust, before) for group in groups.values()]
    return tuple(sorted(found, key=lambda finding: -finding.evidence))


def _finding(
    hypothesis: Hypothesis,
    group: Sequence[RivalCheck],
    uncertainty: Uncertainty,
    from_currents: bool,
    trust: Mapping[tuple[str, tuple[int, ...]], Trust],
    before: Sequence[AcceptedEffect],
) -> Finding:
    group = sorted(group, key=lambda check: check.accepted.candidate.joints)
    accepted = [check.accepted for check in group]
    name = accepted[0].candidate.name
    joints = tuple(j for one in accepted for j in one.candidate.joints)
    whole = [
        ((FrictionLevel.name, check.accepted.candidate.joints), True) for check in group if check.friction is not None
    ]
    rivals = _joined([*whole, *((r.key, r in check.same) for check in group for r in (*check.rivals, *check.same))])
    bands = [curve_band(hypothesis, one, uncertainty) for one in accepted]
    texts = [
        SCALED if from_currents and name == "payload" else "",
        *(_friction_too(check) for check in group),
        separating_words(name, other.effect) if (other := other_rival(name, rivals)) is not None else "",
    ]
    known = [trust.get(one.candidate.key, Trust()) for one in accepted]
    shares = [one.stability for one in known if one.stability is not None]
    least = [check.threshold for check in group if check.threshold is not None]
    return Finding(
        effect=name,
        joints=joints,
        parameters=tuple(v for one in accepted for v in parameter_values(hypothesis, one, uncertainty)),
        gain=_reduction(hypothesis, accepted, [one for one in before if _is_beside(one, accepted)]),
        rivals=rivals,
        intervals=tuple(interval for one in accepted for interval in getattr(one.effect, "intervals", ())),
        advice=" ".join(filter(None, texts)),
        evidence=float(sum(check.gain for check in group)),
        threshold=sum(least) if len(least) == len(group) else None,
        recording=getattr(accepted[0].effect, "recording", ""),
        in_words=values_in_words(hypothesis, accepted, uncertainty),
        curves=tuple(band for band in bands if band is not None),
        stability=min(shares) if shares else None,
        doubts=tuple(dict.fromkeys(doubt for one in known for doubt in one.doubts)),
    )


def _friction_too(check: RivalCheck) -> str:
    """What it means that an effect, alone or beside others, is as good as more or less friction; empty where it is not."""
    if (whole := check.friction) is None:
        return ""
    (joint,) = check.accepted.candidate.joints
    size = f"{100 * abs(whole.share):.3g} % {'more' if whole.share > 0 else 'less'} of every kind of friction"
    if whole.beside:
        return f"With {listed([effect_label(name) for name in whole.beside])} it may be one change: {size} of joint {joint} is nearly the torque of all."
    return f"Nearly all torque of joint {joint} is friction: {size} there is nearly the same torque."


def _joined(rivals: Sequence[tuple[tuple[str, tuple[int, ...]], bool]]) -> tuple[Rival, ...]:
    """Rivals of one name, given with their joints and whether they are inseparable, joined over joints; those that no motion tells first."""
    found: dict[tuple[str, tuple[int, ...]], set[int]] = {}
    separable = set()
    for (name, joints), inseparable in rivals:
        key = (name, () if effect_scope(name).joins_joints else joints)
        found.setdefault(key, set()).update(joints)
        if not inseparable:
            separable.add(key)
    result = [Rival(key[0], tuple(sorted(joints)), key not in separable) for key, joints in found.items()]
    return tuple(sorted(result, key=lambda rival: not rival.inseparable))


def _without(hypothesis: Hypothesis, effects: Sequence[AcceptedEffect]) -> Hypothesis:
    """The hypothesis without some of its accepted effects, its columns as they are."""
    rest = [a for a in hypothesis.accepted if a not in effects]
    return state_hypothesis(hypothesis.problem, rest, hypothesis.model, hypothesis.data)


def _is_beside(old: AcceptedEffect, group: Sequence[AcceptedEffect]) -> bool:
    """Whether an effect that was there before acts on a joint of a group that is no part of it."""
    joints = {joint for one in group for joint in one.candidate.joints}
    return old not in group and bool(joints.intersection(old.candidate.joints))


def _reduction(
    hypothesis: Hypothesis, group: Sequence[AcceptedEffect], old: Sequence[AcceptedEffect] = ()
) -> Reduction:
    """What a group takes of the left-out error beside all others. Those that are ``old`` would take it up, though they have not
    changed: what it takes is measured without them, what it leaves with them."""
    rest = _without(hypothesis, group)
    if group[0].candidate is CONTACT:
        return _contact_reduction(hypothesis, rest, group)
    shown = where_it_shows(hypothesis, [hypothesis.accepted.index(one) for one in group])
    squares_of_weights = shown / hypothesis.fit.sigma**2
    labels = blocks(hypothesis.data, float(hypothesis.fit.memory.max()))
    before, after = (squares_of_weights * squares for squares in _left_out(hypothesis, rest, group))
    if old:
        without, left = _left_out(hypothesis, _without(hypothesis, [*group, *old]), group)
        before = after + squares_of_weights * (without - left)
    rows = float(weighted_rows(hypothesis, labels >= 0) @ squares_of_weights)
    sizes = [float(np.sqrt(max(0.0, cost.sum()) / rows)) for cost in (before, after)]
    return Reduction(
        rms_before=sizes[0],
        rms_after=sizes[1],
        reduction_percent=100 * (1 - sizes[1] / sizes[0]) if sizes[0] > 0 else 0.0,
        interval95=resampled_reduction(before.sum(axis=1), after.sum(axis=1), hypothesis.problem.seed),
    )


def _left_out(hypothesis: Hypothesis, rest: Hypothesis, group: Sequence[AcceptedEffect]) -> tuple[Array, Array]:
    """The squared left-out residual of each block and joint of a hypothesis without and with a group."""
    joined = joined_columns([hypothesis.columns(a.candidate, a.effect) for a in group])
    robot = hypothesis.problem.model.robot
    prior = np.concatenate([prior_precision(a.effect, len(a.effect.columns(robot))) for a in group])
    return rest.left_out_squares, rest.left_out_fits.squares_of_blocks(joined, prior)


def _contact_reduction(hypothesis: Hypothesis, rest: Hypothesis, group: Sequence[AcceptedEffect]) -> Reduction:
    """The gain of contacts as the search computes it: each joint by the force fitted to the others, all joints together."""
    weights, gains = rest.fit.weights, []
    for one in group:
        beside = _without(hypothesis, [one])
        windows = scan_contacts(beside, beside.data.response[:, :, None]).windows
        gains.append((windows * (weights / beside.fit.weights) ** 2).sum(axis=1))
    gain = np.concatenate(gains)
    before = float(np.sum((rest.fit.residual * weights) ** 2))
    draws = np.random.default_rng([rest.problem.seed, 17]).integers(0, len(gain), (RESAMPLES, len(gain)))
    left = np.sqrt(np.maximum(1 - np.append(gain[draws].sum(axis=1), gain.sum()) / before, 0.0))
    low, high = np.quantile(100 * (1 - left[:-1]), (0.025, 0.975))
    size = float(np.sqrt(before / (weighted_rows(rest) @ weights**2)))
    return Reduction(
        rms_before=size,
        rms_after=size * float(left[-1]),
        reduction_percent=100 * (1 - float(left[-1])),
        interval95=(float(low), float(high)),
    )
