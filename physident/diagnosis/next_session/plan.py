"""Plan the session that answers what a diagnosis has left open."""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from pathlib import Path

from physident.diagnosis.next_session.open_questions import current_model, noise_left, open_questions, part_of_model
from physident.diagnosis.result.record import DiagnosisRecord
from physident.effects.catalogue import CATALOGUE
from physident.effects.inertia import LinkChange
from physident.estimation.estimate_file import load_estimate
from physident.estimation.results.fitted import fitted_recordings
from physident.excitation.session.plan import Budget, plan_session
from physident.excitation.session.ranges import Ranges, ranges_of_signals
from physident.excitation.session.session import Session
from physident.recordings.load import if_at_hand
from physident.recordings.preparation import prepare
from physident.recordings.recording import Recording
from physident.recordings.signals import Signals
from physident.threads import one_thread

MEASURING = "measurement"


@one_thread
def plan_next(
    diagnosis: DiagnosisRecord, budget: Budget, progress: Callable[[float], None] = lambda _: None
) -> Session:
    """The session that within its minutes does most for everything that a diagnosis has left open at once.

    Where the question is what has changed, it begins with motions of the model's own recordings, which show a change alone. Raises InputError for a budget that cannot be used and for collision geometry that cannot be read, NotSolvedError where too few
    motions keep the limits.
    """
    model, notes = current_model(diagnosis), []
    recordings = earlier_recordings(diagnosis)
    if not recordings:
        notes.append("the earlier recordings are not at hand: no range counts as shown")
    if diagnosis.drive_gains is not None and budget.load is None and _about_mass(diagnosis):
        notes.append(
            "mass and drive gains are confounded: with --load KG, a load that was weighed, some pieces carry it"
        )
    inseparable = sorted({(f.effect, r.effect) for f in diagnosis.findings for r in f.rivals if r.inseparable})
    if inseparable:
        pairs = [f"{one} from {other}" for one, other in inseparable]
        notes.append(f"no motion within the recorded ranges tells {', '.join(pairs)}")
    if inside := part_of_model(diagnosis):
        notes.append(f"part of the model that is refitted, so that no motion shows a change of it: {', '.join(inside)}")
    shown = [ranges_of_signals(model, prepare(one, diagnosis.filter)) for one in recordings]
    return plan_session(
        model,
        open_questions(diagnosis),
        noise_left(diagnosis),
        budget,
        shown_ranges=reduce(Ranges.joined, shown) if shown else None,
        noise_words="noise: what the diagnosis left unexplained, with its memory",
        notes=notes,
        progress=progress,
        repeat=_not_yet_repeated(diagnosis, notes),
    )


def _not_yet_repeated(diagnosis: DiagnosisRecord, notes: list[str]) -> list[Signals]:
    """The recordings of the model, where the question is what has changed since, whose motions were not recorded again; a note
    where they are not at hand."""
    if diagnosis.question != "different":
        return []
    if diagnosis.model_file is None or not Path(diagnosis.model_file).is_file():
        notes.append(
            f"the model file {diagnosis.model_file or 'of the diagnosis'} is not at hand: no motion of its recordings is repeated"
        )
        return []
    control = fitted_recordings(load_estimate(diagnosis.model_file))
    if not control:
        notes.append("the model's own recordings are not at hand: no motion of theirs is repeated")
    done = {used.repeats for used in diagnosis.recordings}
    return [prepare(one, diagnosis.filter) for one in control if one.source not in done]


def earlier_recordings(diagnosis: DiagnosisRecord) -> list[Recording]:
    """The recordings that were diagnosed, as far as they are still at hand, unchanged."""
    names = diagnosis.model.robot.joint_names
    used = [one for one in diagnosis.recordings if one.role == "diagnosed"]
    found = [if_at_hand(one.path, one.sha256, diagnosis.layout, names) for one in used]
    return [one.with_default_drive_gains(diagnosis.drive_gains) for one in found if one is not None]


def _about_mass(diagnosis: DiagnosisRecord) -> bool:
    """Whether a finding or its rival is a change of mass, or of the measured torque's scale."""
    names = {n for f in diagnosis.findings for n in (f.effect, *(r.effect for r in f.rivals))}
    return any(issubclass(CATALOGUE[name], LinkChange) or CATALOGUE[name].acts_on == MEASURING for name in names)
