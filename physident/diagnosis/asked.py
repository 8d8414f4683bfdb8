"""What is asked of a diagnosis: the recordings, the model and its control, checked and prepared before anything is searched."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from physident.diagnosis.grading.agreement import as_recordings_agree
from physident.diagnosis.grading.completed import CompletedModel, complete_model
from physident.diagnosis.grading.control import with_temperatures
from physident.diagnosis.problem.problem import DiagnosisProblem, state_problem
from physident.diagnosis.problem.question import Question, choose_question
from physident.diagnosis.problem.requirements import check_holdout, check_lengths, refuse_repeated
from physident.diagnosis.remainder.own_error import OwnError
from physident.diagnosis.repeated.comparison import Comparison, compare_with_control
from physident.diagnosis.result.findings import Role, UsedRecording
from physident.dynamics.model import Model
from physident.errors import InputError, warn
from physident.estimation.dry_friction.transition_width import model_with_transitions
from physident.estimation.estimate import Estimate, as_estimate
from physident.estimation.identify import prepare_all
from physident.estimation.regressor_fit import shared_gains, shared_layout
from physident.estimation.results.fitted import each_at_hand
from physident.recordings.load import Recordings, as_recordings
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter, Signals, as_filter
from physident.setup_checks.check_setup import warn_of_setup


@dataclass(frozen=True, kw_only=True, eq=False)
class Asked:
    """A question, and what its answer is searched in.

    ``original`` is the model as it came, and ``model`` the one that is searched: ``complete`` with what its own recordings show already, and as
    sure as they agree. ``recordings`` are diagnosed, ``holdout`` is scored at the end; what was found is held against the ``control``, whose
    signals are ``control_signals``: the recordings ``before`` where some were given. ``own_error`` is what the model leaves of its own
    recordings, None where they are not at hand. The ``warnings`` have been given.
    """

    question: Question
    original: Estimate
    model: Estimate | Model
    complete: CompletedModel | None
    recordings: tuple[Recording, ...]
    holdout: tuple[Recording, ...]
    before: tuple[Recording, ...]
    control: tuple[Recording, ...]
    control_signals: list[Signals]
    own_error: OwnError | None
    comparison: Comparison
    layout: str | None
    drive_gains: tuple[float, ...] | None
    recording_offsets: bool
    seed: int
    warnings: tuple[str, ...]

    @property
    def estimate(self) -> Estimate | None:
        """The model that is searched, where it was identified."""
        return self.model if isinstance(self.model, Estimate) else None

    @property
    def filter(self) -> Filter:
        """The filter of all signals."""
        return self.original.filter

    @property
    def with_torque(self) -> list[Recording]:
        """The diagnosed recordings, with the drive gains that turn currents into torque."""
        return [recording.with_default_drive_gains(self.drive_gains) for recording in self.recordings]

    def used(self) -> tuple[UsedRecording, ...]:
        """Every recording with its role, and the source of the control's that it is compared with."""
        partners = [None if k is None else self.control[k].source for k in self.comparison.partner]
        roles: list[tuple[Role, Sequence[Recording], Sequence[str | None]]] = [
            ("diagnosed", self.recordings, partners),
            ("holdout", self.holdout, [None] * len(self.holdout)),
            ("before", self.before, [None] * len(self.before)),
        ]
        return tuple(
            UsedRecording(r.source, r.sha256, role, partner)
            for role, some, others in roles
            for r, partner in zip(some, others, strict=True)
        )

    def problem(self) -> DiagnosisProblem:
        """What is searched."""
        usual = self.own_error.often if self.own_error else None
        return state_problem(
            self.question,
            self.model,
            self.comparison.signals,
            self.filter,
            self.seed,
            self.recording_offsets,
            self.comparison,
            usual,
        )


def ask(
    model: Estimate | Model,
    recordings: Recordings,
    holdout: Recordings,
    filter: Filter | float | None,
    seed: int,
    progress: Callable[[str], None],
    columns: str | None,
    recording_offsets: bool,
    before: Sequence[Recording] | None,
) -> Asked:
    """The arguments of ``diagnose_motion``, checked and prepared. Raises its InputErrors."""
    diagnosed, held = (listed(model, given, columns) for given in (recordings, holdout))
    question = choose_question(model, diagnosed)
    _check_options(model, diagnosed, filter, columns, recording_offsets)
    refuse_repeated(model, diagnosed, held, before or ())
    estimate = model if isinstance(model, Estimate) else None
    given = model if isinstance(model, Model) else model.model
    used_filter = estimate.filter if estimate else as_filter(filter)
    gains = estimate.drive_gains if estimate else shared_gains(diagnosed)
    with_torque, held_torque = ([r.with_default_drive_gains(gains) for r in some] for some in (diagnosed, held))
    signals = prepare_all(given.robot, with_torque, used_filter)
    check_lengths(given, signals, used_filter)
    check_holdout(model, diagnosed, held, used_filter)
    warnings = warn_of_setup(given.robot, with_torque, held_torque)
    if isinstance(model, Model):  # a description says nothing of how its friction turns
        model = given = model_with_transitions(model.stepped(), signals, used_filter)
    own, control, lost = _own_and_control(estimate, before, question)
    control_signals, assumed = with_temperatures(prepare_all(given.robot, control, used_filter), signals)
    for text in (*lost, *assumed):
        warn(text)
    original, complete, searched, own_error = as_estimate(model, used_filter), None, model, None
    if estimate and own:
        complete = complete_model(estimate, own, with_torque, seed, progress)
        own_signals = control_signals
        if before is not None:
            own_signals, _ = with_temperatures(prepare_all(given.robot, own, used_filter), signals)
        searched = as_recordings_agree(complete.estimate, own_signals)
        own_error = OwnError.of(complete.estimate, own_signals, len(diagnosed))
    comparison = compare_with_control(complete.estimate.model if complete else given, signals, control_signals)
    return Asked(
        question=question,
        original=original,
        model=searched,
        complete=complete,
        recordings=tuple(diagnosed),
        holdout=tuple(held),
        before=tuple(before or ()),
        control=control,
        control_signals=control_signals,
        own_error=own_error,
        comparison=comparison,
        layout=estimate.layout if estimate else columns or shared_layout(diagnosed),
        drive_gains=gains,
        recording_offsets=recording_offsets,
        seed=seed,
        warnings=(*warnings, *lost, *assumed),
    )


def listed(model: Estimate | Model, given: Recordings, columns: str | None) -> list[Recording]:
    """One or several recordings, paths or patterns, as a list of recordings of a model's arm."""
    estimate = model if isinstance(model, Estimate) else None
    robot = model.robot if isinstance(model, Model) else model.model.robot
    return as_recordings(given, robot, estimate.layout if estimate else columns)


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


def _own_and_control(
    estimate: Estimate | None, before: Sequence[Recording] | None, question: Question
) -> tuple[tuple[Recording, ...], tuple[Recording, ...], tuple[str, ...]]:
    """The recordings that the model was fitted to, where they are at hand, and those that a change is held against: the same ones, unless
    others were given. Last, which of the former are lost, in words."""
    if estimate is None or question != "different":
        return (), (), ()
    found = each_at_hand(estimate, before or ())
    missing = [source.path for source, one in zip(estimate.sources, found, strict=True) if one is None]
    own = () if missing else tuple(recording for recording in found if recording is not None)
    lost = (_lost(missing),) if missing else ()
    if before is None:
        return own, own, lost
    return own, tuple(recording.with_default_drive_gains(estimate.drive_gains) for recording in before), lost


def _lost(missing: Sequence[str]) -> str:
    names = f"{missing[0]} and {len(missing) - 1} others" if len(missing) > 2 else " and ".join(missing)
    it = "it" if len(missing) == 1 else "them"
    return (
        f"{names}: the model was fitted to {it}, but no such recording is at hand unchanged, so that what the model always lacked"
        f" cannot be told from a change; put {it} back, or pass {it} with --before (in Python, before=[...])"
    )
