"""The entry point: find, quantify and add the effects that recordings show and a model lacks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.asked import Asked, ask, listed
from physident.diagnosis.at_rest.at_rest import diagnose_at_rest, is_at_rest
from physident.diagnosis.at_rest.poses import AtRest
from physident.diagnosis.grading.confounders import with_confounder
from physident.diagnosis.grading.control import alike_before
from physident.diagnosis.grading.grades import expected_error, graded, is_patchwork, single_cause
from physident.diagnosis.grading.holdout import held_to_unseen
from physident.diagnosis.grading.members import members, with_values, without
from physident.diagnosis.grading.one_story import one_cause_a_torque
from physident.diagnosis.learned.search_and_learn import search_and_learn
from physident.diagnosis.problem.folds import leaves_out_recordings
from physident.diagnosis.problem.problem import DiagnosisProblem
from physident.diagnosis.result.assemble import make_findings
from physident.diagnosis.result.diagnosis import Diagnosis
from physident.diagnosis.result.errors import ERRS_MORE, beyond_noise, errors_before_and_after, refutes
from physident.diagnosis.result.extended_estimate import extended_estimate
from physident.diagnosis.result.findings import Finding, Placebo, Verdict
from physident.diagnosis.result.unexplained import (
    Unexplained,
    above_noise_floor,
    describe_unexplained,
    incomplete_joints,
)
from physident.diagnosis.rivals.rivals import check_rivals
from physident.diagnosis.rivals.same_torque import by_simpler, same_torque
from physident.diagnosis.search.candidate_scores import CandidateScores
from physident.diagnosis.search.forward_search import SearchResult, settled_hypothesis
from physident.diagnosis.search.hypothesis import Hypothesis, state_hypothesis
from physident.diagnosis.search.shape_refinement import refine_shape
from physident.diagnosis.search.side_results import placebos_of, refuse_if_placebos_pass, unseen_effects
from physident.diagnosis.stability.doubts import trust_in
from physident.diagnosis.statistics.intervals import Uncertainty, uncertainty_of
from physident.diagnosis.statistics.noise_floor import noise_floor
from physident.diagnosis.statistics.stored_products import Key
from physident.dynamics.model import Model
from physident.effects.shared_scale import SharedScale
from physident.errors import InputError, warn
from physident.estimation.estimate import Estimate
from physident.recordings.load import Recordings
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter
from physident.threads import one_thread


@one_thread
def diagnose(
    model: Estimate | Model,
    recordings: Recordings,
    holdout: Recordings = (),
    filter: Filter | float | None = None,
    seed: int = 0,
    progress: Callable[[str], None] = lambda _: None,
    columns: str | None = None,
    recording_offsets: bool = False,
    before: Sequence[Recording] | None = None,
) -> Diagnosis | AtRest:
    """What recordings show that a model does not: causes with their proof on left-out rows or recordings.

    ``recordings`` and ``holdout`` are one or several recordings, paths or patterns. Those without any motion are compared with gravity and friction at standstill (``AtRest``); for all others see
    ``diagnose_motion``, whose arguments and errors these are. Raises InputError for a holdout, a filter or offsets beside
    recordings at rest, which need motion.
    """
    recordings, holdout = (listed(model, given, columns) for given in (recordings, holdout))
    if not is_at_rest(recordings):
        return diagnose_motion(model, recordings, holdout, filter, seed, progress, columns, recording_offsets, before)
    if holdout or filter is not None or recording_offsets:
        raise InputError(
            "all recordings are at standstill, but a holdout, a filter or recording_offsets was given; expected recordings"
            " with motion, or none of these"
        )
    return diagnose_at_rest(model, recordings)


@one_thread
def diagnose_motion(
    model: Estimate | Model,
    recordings: Recordings,
    holdout: Recordings = (),
    filter: Filter | float | None = None,
    seed: int = 0,
    progress: Callable[[str], None] = lambda _: None,
    columns: str | None = None,
    recording_offsets: bool = False,
    before: Sequence[Recording] | None = None,
) -> Diagnosis:
    """What recordings of a moving arm show that a model does not: causes with their proof on left-out rows.

    Given an ``Estimate``, it finds effects that are missing (recordings that were fitted) or that have changed (new
    recordings); a ``Model`` is treated as nominal. ``holdout`` is scored once, at the end. ``filter``, and the ``columns``
    stored in the extended model, apply to a ``Model`` only; ``before`` are recordings from before a change, which findings are
    held against, by default those that the model was fitted to; ``seed`` draws the surrogates. With ``recording_offsets`` a
    constant torque per recording is refitted and never reported. Raises InputError for no recordings, a repeated one, a mixture of fitted and
    new ones, currents without gains, efforts that cannot be the arm's, and a holdout that could not be scored: all of it
    before the search. Raises NotSolvedError where every placebo passes as a cause.
    """
    asked = ask(model, recordings, holdout, filter, seed, progress, columns, recording_offsets, before)
    problem = asked.problem()
    searched = _searched(problem, progress)
    progress("searching halves of the recordings")
    judged = _judged(asked, searched)
    return _answer(asked, problem, searched, judged)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Searched:
    """What was ``found``, its ``last`` scores with every shape refined and every effect ``stands_for`` a simpler one, and the ``placebos``."""

    found: SearchResult
    last: CandidateScores
    stands_for: dict[Key, Key]
    placebos: tuple[Placebo, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Judged:
    """Graded findings, ``old`` ones that the control shows alike, the hypothesis without hints and patches, its values' ``errors``, its model
    ``refitted`` where that was needed, and the rest."""

    findings: tuple[Finding, ...]
    old: tuple[Finding, ...]
    patchwork: bool
    sure: Hypothesis
    errors: Uncertainty
    refitted: Estimate | None
    unexplained: tuple[Unexplained, ...]
    noise_floor: NDArray[np.float64] | None


def _searched(problem: DiagnosisProblem, progress: Callable[[str], None]) -> _Searched:
    found = search_and_learn(problem, progress)
    placebos = placebos_of(found.last)
    refuse_if_placebos_pass(placebos)
    problem = found.last.hypothesis.problem
    refined = _with_refined_shapes(problem, found)
    simpler, stands_for = by_simpler(refined)
    last = replace(found.last, hypothesis=settled_hypothesis(problem, simpler, refined) if stands_for else refined)
    return _Searched(found=found, last=last, stands_for=stands_for, placebos=placebos)


def _judged(asked: Asked, searched: _Searched) -> _Judged:
    """What was found, held against rivals, halves, the control and unseen recordings."""
    last, hypothesis = searched.last, searched.last.hypothesis
    problem, uncertainty = hypothesis.problem, uncertainty_of(hypothesis)
    from_currents = any(recording.effort_kind == "current" for recording in asked.recordings)
    same = same_torque(hypothesis)
    checks = [check_rivals(last, one, same.get(one.candidate.key, ())) for one in hypothesis.accepted]
    trust = trust_in(searched.found.first, last, checks, searched.stands_for)
    alike = alike_before(hypothesis, asked.control_signals)
    found = make_findings(hypothesis, checks, uncertainty, from_currents, trust, alike)
    unexplained = describe_unexplained(hypothesis)
    floor = noise_floor(problem.regressor, problem.signals, hypothesis.torque, hypothesis.residual)
    expected = expected_error(hypothesis, asked.estimate, floor, unexplained)
    findings, old = _apart(hypothesis, graded(hypothesis, found, expected, bool(asked.control)), alike)
    findings = one_cause_a_torque(hypothesis, findings)
    findings = with_confounder(findings, asked.control, asked.recordings)
    refitted = _refitted(asked, hypothesis, uncertainty)
    findings = held_to_unseen(hypothesis, findings, asked.holdout, asked.drive_gains, asked.control_signals, refitted)
    patchwork = is_patchwork(searched.found.overfull, bool(asked.control), problem.all_compared, findings)
    findings = single_cause(findings) if patchwork else findings
    unseen_too = bool(asked.holdout) or leaves_out_recordings(problem.fold, problem.regressor.recording)
    # of a model that was fitted to them, they fit what was recorded; a description lacks most of an arm
    patches = patchwork and problem.question == "missing" and not unseen_too
    unsure = [f for f in (*findings, *old) if f.grade == "hint" or (patches and f.grade != "cause")]
    sure, errors = without(hypothesis, unsure), uncertainty
    if len(sure.accepted) < len(hypothesis.accepted):  # what these explained is open
        unexplained, refitted = describe_unexplained(sure), None
        if sure.accepted:
            errors = uncertainty_of(sure)
            findings, old = (with_values(sure, some, errors) for some in (findings, old))
    return _Judged(
        findings=findings,
        old=old,
        patchwork=patchwork,
        sure=sure,
        errors=errors,
        refitted=refitted,
        unexplained=unexplained,
        noise_floor=floor,
    )


def _refitted(asked: Asked, hypothesis: Hypothesis, uncertainty: Uncertainty) -> Estimate | None:
    """The extended model, fitted anew, that a holdout is to judge; None where there is no holdout, or no second fit."""
    if not asked.holdout or not hypothesis.accepted or hypothesis.problem.question != "missing":
        return None
    return extended_estimate(hypothesis, uncertainty, asked.with_torque)


def _extended(asked: Asked, judged: _Judged) -> Estimate | None:
    """The model with all that is no hint, or with what its own recordings showed already; None where there is neither."""
    if judged.sure.accepted:
        found = judged.refitted or extended_estimate(judged.sure, judged.errors, asked.with_torque)
    elif asked.complete and asked.complete.findings:
        found = asked.complete.estimate
    else:
        return None
    return replace(found, layout=asked.layout, drive_gains=asked.drive_gains)


def _answer(asked: Asked, problem: DiagnosisProblem, searched: _Searched, judged: _Judged) -> Diagnosis:
    hypothesis, extended, holdout = searched.last.hypothesis, _extended(asked, judged), asked.holdout
    error_before, error_after = errors_before_and_after(
        asked.original, settled_hypothesis(problem, ()), judged.sure, extended, asked.with_torque, holdout,
        asked.comparison if asked.comparison.compared else None,
    )  # fmt: skip
    changed = asked.estimate if asked.question == "different" else None
    refuted = refutes(changed, error_before, error_after) if changed and extended else ""
    if refuted:
        warn(refuted)
        judged, extended = _as_hints(judged), None
    causes = any(finding.grade == "cause" for finding in judged.findings)
    left = bool(above_noise_floor(judged.unexplained, judged.noise_floor))
    wrong_unseen = (
        beyond_noise(extended or asked.original, holdout, error_after, judged.unexplained, judged.noise_floor, changed)
        if holdout
        else ()
    )
    return Diagnosis(
        question=asked.question,
        verdict=_verdict(causes, left or bool(wrong_unseen)),
        findings=judged.findings,
        missing_since_before=(*(asked.complete.findings if asked.complete and not refuted else ()), *judged.old),
        wrong_baseline=_joints_of(hypothesis) if judged.patchwork else (),
        wrong_unseen=wrong_unseen,
        controlled=bool(asked.control) if asked.question == "different" else None,
        before=error_before,
        after=error_after,
        scored_on="holdout" if holdout else "left-out rows",
        noise_floor=judged.noise_floor,
        placebos=searched.placebos,
        unseen=unseen_effects(searched.found.first),
        unexplained=judged.unexplained,
        recordings=asked.used(),
        model=asked.original.model,
        extended=extended.model if extended else None,
        estimate=extended,
        filter=asked.filter,
        layout=asked.layout,
        drive_gains=asked.drive_gains,
        unidentified=hypothesis.problem.freedom.unidentified,
        seed=asked.seed,
        incomplete=incomplete_joints(changed, judged.unexplained) if changed and not problem.all_compared else (),
        recording_offsets=asked.recording_offsets,
        warnings=(*asked.warnings, *([refuted] if refuted else [])),
        model_file=asked.original.path,
    )


def _as_hints(judged: _Judged) -> _Judged:
    """The same findings, each a hint, because the model that they extend errs more with them."""

    def doubted(findings: Sequence[Finding]) -> tuple[Finding, ...]:
        return tuple(replace(one, grade="hint", doubts=(*one.doubts, ERRS_MORE)) for one in findings)

    return replace(judged, findings=doubted(judged.findings), old=doubted(judged.old))


def _with_refined_shapes(problem: DiagnosisProblem, found: SearchResult) -> Hypothesis:
    """The last hypothesis with every shape refined beside all others, and all columns by the extended model."""
    accepted, last = list(found.accepted), found.last.hypothesis
    if not accepted:
        return last
    for i, one in enumerate(accepted):
        held = (
            isinstance(one.effect, SharedScale) and one.effect.held
        )  # beside what was found on the joints that it holds
        if len(one.candidate.options) > 1 and len(accepted) > 1 and not held:
            rest = state_hypothesis(problem, [*accepted[:i], *accepted[i + 1 :]], last.model, last.data)
            accepted[i] = replace(one, effect=refine_shape(rest, one.candidate))
    return settled_hypothesis(problem, accepted, last)


def _apart(
    hypothesis: Hypothesis, findings: Sequence[Finding], alike: frozenset[Key]
) -> tuple[tuple[Finding, ...], tuple[Finding, ...]]:
    """The findings that are changes, and those that the control shows alike."""
    old = {id(f): hypothesis.accepted[members(hypothesis, f)[0]].candidate.key in alike for f in findings}
    return tuple(f for f in findings if not old[id(f)]), tuple(f for f in findings if old[id(f)])


def _joints_of(hypothesis: Hypothesis) -> tuple[int, ...]:
    """The joints (from 1) that the accepted effects act on; all, where they name none."""
    named = {joint for one in hypothesis.accepted for joint in one.candidate.joints}
    return tuple(sorted(named or range(1, hypothesis.problem.model.robot.n + 1)))


def _verdict(found: bool, structured: bool) -> Verdict:
    if found:
        return "partly_explained" if structured else "explained"
    return "unexplained" if structured else "nothing_missing"
