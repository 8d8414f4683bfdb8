"""The diagnosis: what recordings show that a model does not, named, measured and added to it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.problem import Case
from physident.diagnosis.problem.question import ask
from physident.diagnosis.problem.requirements import check_holdout, refuse_seen
from physident.diagnosis.result.assemble import findings
from physident.diagnosis.result.extended_estimate import refit
from physident.diagnosis.result.findings import Diagnosis, Levels, Placebo, Unseen, Used, Verdict
from physident.diagnosis.result.unexplained import Remainder, describe, incomplete
from physident.diagnosis.search.candidate_scores import Look
from physident.diagnosis.search.forward_search import Search, search, settled
from physident.diagnosis.search.hypothesis import State
from physident.diagnosis.search.rivals import examine
from physident.diagnosis.search.shape_refinement import refined
from physident.diagnosis.statistics.intervals import certainty
from physident.diagnosis.statistics.noise_floor import AT_FLOOR, noise_floor
from physident.dynamics.model import Model
from physident.errors import InputError
from physident.estimation.estimate import Estimate, as_estimate
from physident.estimation.identify import prepare_all, shared_gains
from physident.identifiability.visibility import VISIBLE
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter
from physident.validation.scores import compare, validate

Array = NDArray[np.float64]
SILENT = 1e-9  # N m a unit: rounding


def diagnose(
    model: Estimate | Model,
    recordings: Sequence[Recording],
    holdout: Sequence[Recording] = (),
    filter: Filter | None = None,
    seed: int = 0,
    progress: Callable[[str], None] = lambda _: None,
    columns: str | None = None,
    recording_offsets: bool = False,
) -> Diagnosis:
    """What recordings show that a model does not: causes with their proof on rows or recordings that were left out.

    An ``Estimate`` asks what is missing from it, given the recordings it was fitted to, or what is different, given new
    ones; a ``Model`` is nominal. ``holdout`` is scored once, at the end. ``filter``, and ``columns`` that the extended
    model remembers, are for a ``Model`` alone; ``seed`` draws the surrogates; with ``recording_offsets`` a constant torque of
    each recording's own is fitted along and not named. Raises InputError for no recordings, one
    that came twice, a mixture of fitted and new ones, currents without gains, efforts that cannot be the arm's, and a
    holdout that could not be scored: all of it before the search.
    """
    question = ask(model, recordings)
    if isinstance(model, Estimate) and (filter is not None or columns is not None):
        raise InputError("a filter or columns came beside an estimate, which has its own; expected none")
    if recording_offsets and len(recordings) < 2:
        raise InputError(
            "recording_offsets came with one recording; expected two or more, between which a zero can drift"
        )
    used = model.filter if isinstance(model, Estimate) else filter or Filter()
    gains = model.drive_gains if isinstance(model, Estimate) else shared_gains(recordings)
    layout = model.layout if isinstance(model, Estimate) else columns
    gained = [recording.with_default_drive_gains(gains) for recording in recordings]
    refuse_seen(model, recordings, holdout)
    arm = model.model if isinstance(model, Estimate) else model
    signals = prepare_all(arm.robot, gained, used)
    check_holdout(model, recordings, holdout, used)
    case = Case.open(question, model, signals, used, seed, recording_offsets)
    found = search(case, progress)
    state = _polished(case, found)
    last = replace(found.last, state=state)
    sure = certainty(state)
    currents = any(recording.effort_kind == "current" for recording in recordings)
    named = findings(state, [examine(last, accepted) for accepted in state.accepted], sure, currents)
    extended = replace(refit(state, sure, gained), layout=layout, drive_gains=gains) if named else None
    remainder, floor = describe(state), noise_floor(case.regressor, case.signals, state.torque)
    before, after = _levels(case, found.first.state, state, model, extended, holdout)
    return Diagnosis(
        question, _verdict(bool(named), remainder, floor), named, before, after,
        "holdout" if holdout else "left-out rows", floor, _placebos(found.last), _unseen(found.first), remainder,
        (*_used(recordings, "diagnosed"), *_used(holdout, "holdout")), arm, extended, used,
        layout, gains, case.freedom.held, seed,
        incomplete(model, remainder) if isinstance(model, Estimate) and question == "different" else (),
        recording_offsets,
    )  # fmt: skip


def _polished(case: Case, found: Search) -> State:
    """The last state with every shape refined beside all others, and all columns by the extended model."""
    accepted = list(found.accepted)
    if not accepted:
        return found.last.state
    model, evidence = found.last.state.model, found.last.state.evidence
    for i, one in enumerate(accepted):
        if len(one.candidate.options) > 1 and len(accepted) > 1:
            rest = case.state([*accepted[:i], *accepted[i + 1 :]], model, evidence)
            accepted[i] = replace(one, effect=refined(rest, one.candidate))
    return settled(case, accepted, found.last.state)


def _verdict(named: bool, remainder: Sequence[Remainder], floor: Array | None) -> Verdict:
    least = np.zeros(len(remainder)) if floor is None else AT_FLOOR * floor
    structured = any(one.structured and one.rms > level for one, level in zip(remainder, least, strict=True))
    if named:
        return "partly_explained" if structured else "explained"
    return "unexplained" if structured else "nothing_missing"


def _levels(
    case: Case,
    first: State,
    last: State,
    model: Estimate | Model,
    extended: Estimate | None,
    holdout: Sequence[Recording],
) -> tuple[Levels, Levels]:
    """Errors before and after: on the holdout where there is one, else on rows that were left out."""
    if holdout:
        start = as_estimate(model, case.filter)
        if extended is None:
            score = validate(start, holdout)
            level = Levels(score.rms, score.relative)
            return level, level
        gain = compare(start, extended, on=holdout)
        return Levels(gain.before.rms, gain.before.relative), Levels(gain.after.rms, gain.after.relative)
    return _left_out(first), _left_out(last)


def _left_out(state: State) -> Levels:
    residual = state.folded.residual() / state.case.weights
    regressor, inside, torque = state.evidence.regressor, state.inside, state.torque
    each = []
    for index in np.unique(regressor.recording[inside]):
        rows = inside & (regressor.recording == index)
        size = np.linalg.norm(torque[rows], axis=0)
        each.append(100 * np.linalg.norm(residual[rows], axis=0) / np.where(size > 0, size, 1.0))
    rows = np.maximum(regressor.counted[inside].sum(axis=0), 1)
    return Levels(np.sqrt((residual[inside] ** 2).sum(axis=0) / rows), np.mean(each, axis=0))


def _placebos(last: Look) -> tuple[Placebo, ...]:
    return tuple(
        Placebo(c.name, c.joints[0], float(gain), last.threshold)
        for c, gain in zip(last.state.evidence.candidates, last.least, strict=True)
        if c.placebo
    )


def _unseen(first: Look) -> tuple[Unseen, ...]:
    """Effects that lie inside the baseline, or show no torque, at the first look."""
    result, evidence = [], first.state.evidence
    for candidate, share in zip(evidence.candidates, first.share, strict=True):
        if share < VISIBLE and not candidate.placebo:
            columns = evidence.everywhere(candidate.options[0].columns)
            silent = max(float(np.abs(own).max(initial=0.0)) for own in columns) < SILENT
            reason = "shows no torque" if silent else "inside what the baseline may take up"
            reason = "of a joint that does not move" if first.state.case.motionless(candidate) else reason
            result.append(Unseen(candidate.name, candidate.joints, reason))
    return tuple(result)


def _used(recordings: Sequence[Recording], role: str) -> tuple[Used, ...]:
    return tuple(Used(r.source, r.sha256, role) for r in recordings)
