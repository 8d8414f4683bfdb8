"""What was found, judged: held against rivals, halves of the recordings, the control and unseen recordings, and graded."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.asked import Asked
from physident.diagnosis.graded import Graded, graded_beside_what_stays
from physident.diagnosis.grading.confounders import with_confounder
from physident.diagnosis.grading.control import Change, changes_since
from physident.diagnosis.grading.grades import BESIDE_OTHERS, is_patchwork, single_cause
from physident.diagnosis.grading.holdout import held_to_unseen, saying_what_is_beyond
from physident.diagnosis.grading.members import decides_values, members, with_changes, with_values, without
from physident.diagnosis.grading.one_story import one_cause_a_torque
from physident.diagnosis.problem.columns import Columns
from physident.diagnosis.problem.folds import leaves_out_recordings
from physident.diagnosis.remainder.beside_own import beside_own
from physident.diagnosis.remainder.unexplained import Unexplained, describe_unexplained
from physident.diagnosis.result.errors import ERRS_MORE
from physident.diagnosis.result.extended_estimate import extended_estimate
from physident.diagnosis.result.findings import Finding
from physident.diagnosis.rivals.rivals import check_every_rival
from physident.diagnosis.rivals.whole_friction import whole_friction
from physident.diagnosis.search.candidate_scores import CandidateScores
from physident.diagnosis.search.forward_search import without_redundant
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.searched import Searched
from physident.diagnosis.stability.doubts import trust_in
from physident.diagnosis.stability.trust import with_doubt
from physident.diagnosis.statistics.intervals import Uncertainty, uncertainty_of
from physident.diagnosis.statistics.stored_products import Key
from physident.diagnosis.usual.as_usual import (
    UsualChange,
    differ_as_usual,
    friction_of_the_day,
    usual_friction,
    usual_in_words,
)
from physident.diagnosis.usual.usual_push import pushed_as_usual
from physident.estimation.estimate import Estimate


@dataclass(frozen=True, kw_only=True, eq=False)
class Judged:
    """Graded findings, ``old`` ones that the control shows alike, the hypothesis that is handed on (no hint, no patch, no curve that unseen recordings leave
    and that makes them worse), its values' ``errors``, its model
    ``refitted`` where that was needed, and the rest."""

    findings: tuple[Finding, ...]
    old: tuple[Finding, ...]
    patchwork: bool
    sure: Hypothesis
    errors: Uncertainty
    refitted: Estimate | None
    unexplained: tuple[Unexplained, ...]
    noise_floor: NDArray[np.float64] | None


def judge(asked: Asked, searched: Searched) -> Judged:
    """What was found, held against rivals, halves, the control and unseen recordings."""
    last, hypothesis = searched.last, searched.last.hypothesis
    problem = hypothesis.problem
    checks = check_every_rival(last, searched.same, whole_friction(hypothesis))
    trust = trust_in(searched.found.first, last, checks, searched.stands_for)
    changes = changes_since(hypothesis, asked.control_signals)
    partners = {k for k in asked.comparison.partner if k is not None}
    known = usual_friction(hypothesis, asked.control_signals, len(partners))
    usual = differ_as_usual(hypothesis, known)
    wander = friction_of_the_day(hypothesis, known)
    sizes = {key: one.size for key, one in changes.items()} | dict.fromkeys(usual, 0.0)
    alike = frozenset(key for key, size in sizes.items() if size == 0)
    grade = partial(
        graded_beside_what_stays,
        hypothesis,
        checks,
        sizes=sizes,
        estimate=asked.estimate,
        wander=wander,
        pushed_as_usual=pushed_as_usual(hypothesis, asked.estimate, asked.control_signals, are_fitted=not asked.before),
        from_currents=any(recording.effort_kind == "current" for recording in asked.recordings),
    )
    found = grade(trust)
    findings, old = _told(asked, hypothesis, found, alike)
    refitted = _refitted(asked, found.hypothesis, found.uncertainty)
    held = held_to_unseen(found.hypothesis, findings, asked.holdout, asked.drive_gains, asked.control_signals, refitted)
    if any(one is not other for one, other in zip(held, findings, strict=True)):  # unseen recordings refute some
        found, refitted = grade(trust, hints=[one for one in (*held, *old) if one.grade == "hint"]), None
        findings, old = _told(asked, hypothesis, found, alike)
    patchwork = is_patchwork(searched.found.overfull, bool(asked.control), problem.all_compared, findings)
    ordinary = {one.candidate.name for one in problem.missing_default_effects}
    findings = single_cause(findings, ordinary) if patchwork else findings
    unseen_too = bool(asked.holdout) or leaves_out_recordings(problem.fold, problem.regressor.recording)
    # of a model that was fitted to them, they fit what was recorded; a description lacks most of an arm
    patches = patchwork and problem.question == "missing" and not unseen_too
    if patches and (lost := _lost_alone(found.hypothesis, findings, searched.last)):
        found = grade({**trust, **{key: with_doubt(trust.get(key), BESIDE_OTHERS) for key in lost}})
        findings, old = _told(asked, hypothesis, found, alike)
        findings = single_cause(findings, ordinary)
    hypothesis, unexplained, uncertainty = found.hypothesis, found.unexplained, found.uncertainty
    unsure = [f for f in (*findings, *old) if f.grade == "hint" or (patches and f.grade != "cause")]
    sure, errors = without(hypothesis, [f for f in unsure if not decides_values(hypothesis, f)]), uncertainty
    if len(sure.accepted) < len(hypothesis.accepted):  # what these explained is open
        unexplained, refitted = describe_unexplained(sure), None
        if sure.accepted:
            errors, findings, old = _valued(sure, wander, sizes, findings, old)
    if asked.own_error is not None:
        compared = np.isin(problem.regressor.recording, sorted(problem.freedom.compared)).mean()
        unexplained = beside_own(
            unexplained, asked.own_error, hypothesis.torque, float(compared), asked.own_error.louder(problem.signals),
            None if compared else _unfitted(searched.last.hypothesis, findings),
        )  # fmt: skip
    if asked.holdout and any(one.curves and one.grade != "hint" for one in findings):
        refitted = refitted or extended_estimate(sure, errors, asked.with_torque)
        both = asked.original.model, refitted.model
        findings = saying_what_is_beyond(sure, findings, asked.holdout, asked.drive_gains, *both)
        if back := [one for one in findings if not one.handed_on]:
            sure, refitted = without(sure, back), None
            if sure.accepted:
                errors, findings, old = _valued(sure, wander, sizes, findings, old)
    return Judged(
        findings=findings,
        old=_with_reason(searched.last.hypothesis, old, usual, changes),
        patchwork=patchwork,
        sure=sure,
        errors=errors,
        refitted=refitted,
        unexplained=unexplained,
        noise_floor=found.noise_floor,
    )


def _unfitted(hypothesis: Hypothesis, findings: Sequence[Finding]) -> dict[int, float]:
    """The RMS [N m|N] that the model errs by before anything is fitted, of the joints (from 1) on which no change acts that was found, not even by
    what hangs further out; rows that a rest leaves open count less."""
    found = {i for one in findings if one.grade != "hint" for i in members(hypothesis, one)}
    acting = [np.any(hypothesis.torque_of(i), axis=0) for i in found]
    rms = np.sqrt(np.mean(hypothesis.data.response**2, axis=0))
    return {j: float(error) for j, error in enumerate(rms, 1) if not any(one[j - 1] for one in acting)}


def _valued(
    sure: Hypothesis,
    wander: Columns | None,
    sizes: Mapping[Key, float],
    findings: Sequence[Finding],
    old: Sequence[Finding],
) -> tuple[Uncertainty, tuple[Finding, ...], tuple[Finding, ...]]:
    """The uncertainty of what is handed on, and the findings, and those that are no change, with the values they have there."""
    errors = uncertainty_of(sure, wander)
    valued = [with_changes(with_values(sure, some, errors), sizes) for some in (findings, old)]
    return errors, valued[0], valued[1]


def _lost_alone(hypothesis: Hypothesis, findings: Sequence[Finding], last: CandidateScores) -> list[Key]:
    """The effects of the causes that no longer meet every condition without what is not carried: their joints were found beside it."""
    causes = without(hypothesis, [finding for finding in findings if finding.grade != "cause"])
    kept = without_redundant(causes.problem, causes.accepted, last)
    return [one.candidate.key for one in causes.accepted if kept and not any(one is other for other in kept)]


def _told(
    asked: Asked, hypothesis: Hypothesis, found: Graded, alike: frozenset[Key]
) -> tuple[tuple[Finding, ...], tuple[Finding, ...]]:
    """The graded findings that are changes, one cause a torque, with what else could be their reason; and those that the control shows alike."""
    findings, old = _apart(hypothesis, found.findings, alike)
    findings = one_cause_a_torque(found.hypothesis, findings, found.uncertainty)
    return with_confounder(findings, asked.control, asked.recordings), old


def _refitted(asked: Asked, hypothesis: Hypothesis, uncertainty: Uncertainty) -> Estimate | None:
    """The extended model, fitted anew, that a holdout is to judge; None where there is no holdout, or no second fit."""
    if not asked.holdout or not hypothesis.accepted or hypothesis.problem.question != "missing":
        return None
    return extended_estimate(hypothesis, uncertainty, asked.with_torque)


def _apart(
    hypothesis: Hypothesis, findings: Sequence[Finding], alike: frozenset[Key]
) -> tuple[tuple[Finding, ...], tuple[Finding, ...]]:
    """The findings that are changes, and those that the control shows alike."""
    old = {id(f): hypothesis.accepted[members(hypothesis, f)[0]].candidate.key in alike for f in findings}
    return tuple(f for f in findings if not old[id(f)]), tuple(f for f in findings if old[id(f)])


def _with_reason(
    hypothesis: Hypothesis, old: Sequence[Finding], usual: Mapping[Key, UsualChange], changes: Mapping[Key, Change]
) -> tuple[Finding, ...]:
    """The findings that are no proven change, those of friction that differs as usual with why."""
    result = []
    for one in old:
        keys = [hypothesis.accepted[i].candidate.key for i in members(hypothesis, one)]
        reason = usual_in_words([usual[key] for key in keys if key in usual])
        result.append(
            replace(one, confounder=reason, mostly_new=all(key in changes and changes[key].mostly_new for key in keys))
        )
    return tuple(result)


def as_hints(judged: Judged) -> Judged:
    """The same findings, each a hint, because the model that they extend errs more with them."""

    def doubted(findings: Sequence[Finding]) -> tuple[Finding, ...]:
        return tuple(replace(one, grade="hint", doubts=(*one.doubts, ERRS_MORE), no_cause="") for one in findings)

    return replace(judged, findings=doubted(judged.findings), old=doubted(judged.old))
