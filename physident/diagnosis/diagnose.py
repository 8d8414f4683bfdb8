"""The entry point: find, quantify and add the effects that recordings show and a model lacks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from physident.diagnosis.asked import Asked, ask, listed
from physident.diagnosis.at_rest.at_rest import diagnose_at_rest, is_at_rest
from physident.diagnosis.at_rest.poses import AtRest
from physident.diagnosis.grading.holdout import from_before
from physident.diagnosis.judged import Judged, as_hints, judge
from physident.diagnosis.problem.problem import DiagnosisProblem
from physident.diagnosis.remainder.standing_still import frozen_words
from physident.diagnosis.remainder.unexplained import above_noise_floor, incomplete_joints, large_as_usual
from physident.diagnosis.result.diagnosis import Diagnosis
from physident.diagnosis.result.errors import beyond_noise, errors_before_and_after, refutes
from physident.diagnosis.result.extended_estimate import extended_estimate
from physident.diagnosis.result.findings import Verdict
from physident.diagnosis.search.forward_search import settled_hypothesis
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.search.side_results import unseen_effects
from physident.diagnosis.searched import Searched, search_and_refine
from physident.dynamics.model import Model
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
    searched = search_and_refine(problem, progress)
    progress("searching halves of the recordings")
    judged = judge(asked, searched)
    return _answer(asked, problem, searched, judged)


def _extended(asked: Asked, judged: Judged) -> Estimate | None:
    """The model with all that is no hint, or with what its own recordings showed already; None where there is neither."""
    if judged.sure.accepted:
        found = judged.refitted or extended_estimate(judged.sure, judged.errors, asked.with_torque)
    elif asked.complete and asked.complete.findings:
        found = asked.complete.estimate
    else:
        return None
    return replace(found, layout=asked.layout, drive_gains=asked.drive_gains)


def _answer(asked: Asked, problem: DiagnosisProblem, searched: Searched, judged: Judged) -> Diagnosis:
    hypothesis, extended, holdout = searched.last.hypothesis, _extended(asked, judged), asked.holdout
    error_before, error_after = errors_before_and_after(
        asked.original, settled_hypothesis(problem, ()), judged.sure, extended, asked.with_torque, holdout,
        asked.comparison if asked.comparison.compared else None,
    )  # fmt: skip
    changed = asked.estimate if asked.question == "different" else None
    refuted = refutes(changed, error_before, error_after, bool(holdout)) if changed and extended else ""
    if refuted:
        warn(refuted)
        judged, extended = as_hints(judged), None
    warnings = [*asked.warnings, *([refuted] if refuted else [])]
    if changed and not refuted:
        own = changed.sigma if asked.own_error is None else asked.own_error.rms
        said = (
            from_before(judged.findings, error_before, own) if holdout else "",
            frozen_words(asked.recordings, judged.unexplained),
        )
        for text in filter(None, said):
            warn(text)
            warnings.append(text)
    causes = any(finding.grade == "cause" for finding in judged.findings)
    left = bool(above_noise_floor(judged.unexplained, judged.noise_floor))
    if causes:  # of what is large, though that is usual, nobody knows that it is noise
        left = left or bool(large_as_usual(judged.unexplained, judged.noise_floor))
    wrong_unseen = (
        beyond_noise(
            extended or asked.original,
            asked.recordings,
            holdout,
            error_after,
            judged.unexplained,
            judged.noise_floor,
            changed,
        )
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
        warnings=tuple(warnings),
        model_file=asked.original.path,
    )


def _joints_of(hypothesis: Hypothesis) -> tuple[int, ...]:
    """The joints (from 1) that the accepted effects act on; all, where they name none."""
    named = {joint for one in hypothesis.accepted for joint in one.candidate.joints}
    return tuple(sorted(named or range(1, hypothesis.problem.model.robot.n + 1)))


def _verdict(found: bool, structured: bool) -> Verdict:
    if found:
        return "partly_explained" if structured else "explained"
    return "unexplained" if structured else "nothing_missing"
