"""The entry point: find, quantify and add the effects that recordings show and a model lacks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from physident.diagnosis.at_rest.at_rest import diagnose_at_rest, is_at_rest
from physident.diagnosis.at_rest.poses import AtRest
from physident.diagnosis.grading.agreement import as_recordings_agree
from physident.diagnosis.grading.completed import complete_model
from physident.diagnosis.grading.confounders import with_confounder
from physident.diagnosis.grading.control import alike_before, control_recordings, with_temperatures
from physident.diagnosis.grading.grades import expected_error, graded, is_patchwork, single_cause
from physident.diagnosis.grading.holdout import held_to_unseen
from physident.diagnosis.grading.members import members, with_values, without
from physident.diagnosis.learned.search_and_learn import search_and_learn
from physident.diagnosis.problem.problem import DiagnosisProblem, state_problem
from physident.diagnosis.problem.question import Question, choose_question
from physident.diagnosis.problem.requirements import check_holdout, check_lengths, refuse_repeated
from physident.diagnosis.repeated.comparison import compare_with_control
from physident.diagnosis.result.assemble import make_findings
from physident.diagnosis.result.diagnosis import Diagnosis
from physident.diagnosis.result.errors import errors_before_and_after
from physident.diagnosis.result.extended_estimate import extended_estimate
from physident.diagnosis.result.findings import Finding, Role, UsedRecording, Verdict
from physident.diagnosis.result.unexplained import above_noise_floor, describe_unexplained, incomplete_joints
from physident.diagnosis.rivals.rivals import check_rivals
from physident.diagnosis.rivals.same_torque import by_simpler, same_torque
from physident.diagnosis.search.forward_search import SearchResult, settled_hypothesis
from physident.diagnosis.search.hypothesis import Hypothesis, state_hypothesis
from physident.diagnosis.search.shape_refinement import refine_shape
from physident.diagnosis.search.side_results import placebos_of, refuse_if_placebos_pass, unseen_effects
from physident.diagnosis.stability.doubts import trust_in
from physident.diagnosis.statistics.intervals import uncertainty_of
from physident.diagnosis.statistics.noise_floor import noise_floor
from physident.diagnosis.statistics.stored_products import Key
from physident.dynamics.model import Model
from physident.errors import InputError, warn
from physident.estimation.dry_friction.transition_width import model_with_transitions
from physident.estimation.estimate import Estimate, as_estimate
from physident.estimation.identify import prepare_all
from physident.estimation.regressor_fit import shared_gains
from physident.recordings.load import Recordings, as_recordings
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter, as_filter
from physident.setup_checks.check_setup import warn_of_setup
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
    recordings, holdout = (_listed(model, given, columns) for given in (recordings, holdout))
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
    recordings, holdout = (_listed(model, given, columns) for given in (recordings, holdout))
    question = choose_question(model, recordings)
    _check_options(model, recordings, filter, columns, recording_offsets)
    refuse_repeated(model, recordings, holdout, before or ())
    estimate = model if isinstance(model, Estimate) else None
    given = model if isinstance(model, Model) else model.model
    used_filter = estimate.filter if estimate else as_filter(filter)
    gains = estimate.drive_gains if estimate else shared_gains(recordings)
    layout = estimate.layout if estimate else columns
    with_torque = [recording.with_default_drive_gains(gains) for recording in recordings]
    signals = prepare_all(given.robot, with_torque, used_filter)
    check_lengths(given, signals, used_filter)
    check_holdout(model, recordings, holdout, used_filter)
    warnings = warn_of_setup(given.robot, [*with_torque, *(r.with_default_drive_gains(gains) for r in holdout)])

    if isinstance(model, Model):  # a description says nothing of how its friction turns
        model = given = model_with_transitions(model.stepped(), signals, used_filter)
    control = _control(estimate, before, question)
    original, complete = as_estimate(model, used_filter), None
    before_signals, assumed = with_temperatures(prepare_all(given.robot, control, used_filter), signals)
    for text in assumed:
        warn(text)
    comparison = compare_with_control(given, signals, before_signals)
    if estimate and control and before is None:
        if not comparison.compared:  # what was taken off cannot be taken for a change
            complete = complete_model(estimate, control, with_torque, seed, progress)
            estimate = complete.estimate
        model = estimate = as_recordings_agree(estimate, before_signals)
    beside = [None if k is None else control[k].source for k in comparison.partner]
    asked = state_problem(question, model, comparison.signals, used_filter, seed, recording_offsets, comparison)
    found = search_and_learn(asked, progress)
    problem = found.last.hypothesis.problem
    placebos = placebos_of(found.last)
    refuse_if_placebos_pass(placebos)
    refined = _with_refined_shapes(problem, found)
    simpler, stands_for = by_simpler(refined)
    last = replace(found.last, hypothesis=settled_hypothesis(problem, simpler, refined) if stands_for else refined)
    hypothesis, uncertainty = last.hypothesis, uncertainty_of(last.hypothesis)
    from_currents = any(recording.effort_kind == "current" for recording in recordings)
    same = same_torque(hypothesis)
    checks = [check_rivals(last, one, same.get(one.candidate.key, ())) for one in hypothesis.accepted]
    progress("searching halves of the recordings")
    trust = trust_in(found.first, last, checks, stands_for)
    alike = alike_before(hypothesis, before_signals)
    found_effects = make_findings(hypothesis, checks, uncertainty, from_currents, trust, alike)
    unexplained = describe_unexplained(hypothesis)
    floor = noise_floor(problem.regressor, problem.signals, hypothesis.torque)
    expected = expected_error(hypothesis, estimate, floor, unexplained)
    every = graded(hypothesis, found_effects, expected, controlled=bool(control))
    findings, since_before = _apart(hypothesis, every, alike)
    findings = held_to_unseen(
        hypothesis, with_confounder(findings, control, recordings), holdout, gains, before_signals
    )
    patchwork = is_patchwork(found.overfull, bool(control), problem.all_compared, findings)
    findings = single_cause(findings) if patchwork else findings
    sure = without(hypothesis, [f for f in (*findings, *since_before) if f.grade == "hint"])
    if len(sure.accepted) < len(hypothesis.accepted):  # what a hint explained is open
        unexplained = describe_unexplained(sure)
    extended = None
    if sure.accepted:
        errors = uncertainty
        if len(sure.accepted) < len(hypothesis.accepted):
            errors = uncertainty_of(sure)
            findings, since_before = (with_values(sure, some, errors) for some in (findings, since_before))
        extended = replace(extended_estimate(sure, errors, with_torque), layout=layout, drive_gains=gains)
    elif complete and complete.findings:
        extended = replace(complete.estimate, layout=layout, drive_gains=gains)
    causes = any(finding.grade == "cause" for finding in findings)
    error_before, error_after = errors_before_and_after(
        original, settled_hypothesis(asked, ()), sure, extended, with_torque, holdout,
        comparison if comparison.compared else None,
    )  # fmt: skip
    return Diagnosis(
        question=question,
        verdict=_verdict(causes, bool(above_noise_floor(unexplained, floor))),
        findings=findings,
        missing_since_before=(*(complete.findings if complete else ()), *since_before),
        wrong_baseline=_joints_of(hypothesis) if patchwork else (),
        controlled=bool(control) if question == "different" else None,
        before=error_before,
        after=error_after,
        scored_on="holdout" if holdout else "left-out rows",
        noise_floor=floor,
        placebos=placebos,
        unseen=unseen_effects(found.first),
        unexplained=unexplained,
        recordings=(
            *_used(recordings, "diagnosed", beside),
            *_used(holdout, "holdout"),
            *_used(before or (), "before"),
        ),
        model=given,
        extended=extended.model if extended else None,
        estimate=extended,
        filter=used_filter,
        layout=layout,
        drive_gains=gains,
        unidentified=problem.freedom.unidentified,
        seed=seed,
        incomplete=incomplete_joints(estimate, unexplained) if estimate and question == "different" else (),
        recording_offsets=recording_offsets,
        warnings=(*warnings, *assumed),
        model_file=original.path,
    )


def _check_options(
    model: Estimate | Model,
    recordings: Sequence[Recording],
    filter: Filter | float | None,
    columns: str | None,
    recording_offsets: bool,
) -> None:
    if isinstance(model, Estimate) and (filter is not None or columns is not None):
        raise InputError(
            "a filter or columns were given beside an estimate; expected none, because an estimate remembers them"
        )
    if recording_offsets and len(recordings) < 2:
        raise InputError(
            "recording_offsets was given with one recording; expected two or more, between which a zero can drift"
        )


def _with_refined_shapes(problem: DiagnosisProblem, found: SearchResult) -> Hypothesis:
    """The last hypothesis with every shape refined beside all others, and all columns by the extended model."""
    accepted, last = list(found.accepted), found.last.hypothesis
    if not accepted:
        return last
    for i, one in enumerate(accepted):
        if len(one.candidate.options) > 1 and len(accepted) > 1:
            rest = state_hypothesis(problem, [*accepted[:i], *accepted[i + 1 :]], last.model, last.data)
            accepted[i] = replace(one, effect=refine_shape(rest, one.candidate))
    return settled_hypothesis(problem, accepted, last)


def _control(
    estimate: Estimate | None, before: Sequence[Recording] | None, question: Question
) -> tuple[Recording, ...]:
    """The recordings that a change is held against: those given, or those that the model was fitted to."""
    if estimate is None or question != "different":
        return ()
    if before is None:
        return control_recordings(estimate)
    return tuple(recording.with_default_drive_gains(estimate.drive_gains) for recording in before)


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


def _listed(model: Estimate | Model, given: Recordings, columns: str | None) -> list[Recording]:
    estimate = model if isinstance(model, Estimate) else None
    robot = model.robot if isinstance(model, Model) else model.model.robot
    return as_recordings(given, robot, estimate.layout if estimate else columns)


def _used(
    recordings: Sequence[Recording], role: Role, repeats: Sequence[str | None] | None = None
) -> tuple[UsedRecording, ...]:
    beside = repeats or [None] * len(recordings)
    return tuple(UsedRecording(r.source, r.sha256, role, other) for r, other in zip(recordings, beside, strict=True))
