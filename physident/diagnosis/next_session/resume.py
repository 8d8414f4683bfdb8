"""Resume a planned session with its recordings: identify, diagnose together with what was recorded before, say what was settled."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from pathlib import Path

from physident.diagnosis.diagnose import diagnose_motion
from physident.diagnosis.next_session.followed import check_followed
from physident.diagnosis.next_session.open_questions import open_questions
from physident.diagnosis.next_session.plan import earlier_recordings, plan_next
from physident.diagnosis.next_session.saved_session import SavedSession
from physident.diagnosis.next_session.settled import Answer, answers, expected
from physident.diagnosis.result.diagnosis import Diagnosis
from physident.diagnosis.result.record import DiagnosisRecord
from physident.dynamics.model import Model
from physident.errors import InputError, NotSolvedError, warn
from physident.estimation.estimate import Estimate
from physident.estimation.estimate_file import load_estimate
from physident.estimation.identify import identify
from physident.excitation.session.ranges import Ranges, ranges_of, ranges_of_signals
from physident.excitation.session.session import Session
from physident.recordings.preparation import prepare
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter
from physident.threads import one_thread

WORTH = 1.0  # questions that another session has to be expected to settle: nobody visits an arm for less than an answer


@dataclass(frozen=True, kw_only=True, eq=False)
class Resumed:
    """What a session settled: the ``answers`` to its questions, the ``diagnosis`` of all recordings together, ``pooled`` earlier ones
    among them, and the ``next`` session as it would be planned, None where nothing is open or no motion keeps the limits.

    ``estimate`` is the identified model, extended by what was found.
    """

    answers: tuple[Answer, ...]
    diagnosis: Diagnosis
    estimate: Estimate | None
    pooled: int
    next: Session | None

    @property
    def settled(self) -> int:
        """Number of questions that were settled."""
        return sum(one.settled for one in self.answers)

    @property
    def expected(self) -> float:
        """Number of questions that the session was expected to settle."""
        return expected([one.question for one in self.answers])

    @property
    def promised(self) -> float:
        """Number of questions that the next session is expected to settle, less in the proportion in which this one kept less than it promised."""
        if self.next is None or self.next.outlook is None:
            return 0.0
        # one question more on both sides: a promise of half a question that was not kept refutes nothing
        return self.next.outlook.settled * min(1.0, (self.settled + 1) / (self.expected + 1))

    @property
    def pays(self) -> bool:
        """Whether another session is expected to settle a question or more."""
        return self.promised >= WORTH

    def __repr__(self) -> str:
        from physident.diagnosis.next_session.text import resumed_text

        return resumed_text(self)


@one_thread
def resume_session(
    session: SavedSession,
    recordings: Mapping[str, Recording],
    filter: Filter | None = None,
    columns: str | None = None,
    seed: int = 0,
    progress: Callable[[str], None] = lambda _: None,
) -> Resumed:
    """What the ``recordings`` of a session, by the names of its legs, have settled.

    Recordings that were diagnosed before count as well, where they are still at hand: they are the prior knowledge. ``filter`` and
    ``columns`` are those of a first session; a later one keeps the earlier diagnosis's. A leg may be missing, with a warning. Raises InputError
    where all legs to fit are, or the model that was asked about is, and for a recording that is of another leg.
    """
    # loaded pieces tell the drive gains only
    planned = [leg.name for leg in session.legs if leg.role == "fit" and not leg.loaded]
    fitted = [name for name in planned if name in recordings]
    if not fitted:
        raise InputError(f"none of {', '.join(planned)} has a recording; expected one of a piece that is fitted")
    if len(fitted) < len(planned):
        lost = ", ".join(name for name in planned if name not in recordings)
        warn(f"{lost}: not recorded, so what this was to settle may stay open")
    before = session.diagnosis
    gains = None if before is None else before.drive_gains
    recordings = {name: one.with_default_drive_gains(gains) for name, one in recordings.items()}
    held_out = [leg.name for leg in session.legs if leg.role == "holdout" and leg.name in recordings]
    new, holdout = ([recordings[name] for name in names] for names in (fitted, held_out))
    repeats = [leg.name for leg in session.legs if leg.name.endswith("_again")]
    if session.diagnosis is None and repeats:
        warn(
            f"{', '.join(repeats)}: a new model was identified, and nothing says what has changed since the recordings that these pieces"
            " repeat; ask the model of those: physident diagnose --model MODEL RECORDING..."
        )
    check_followed(session, recordings, filter or (Filter() if before is None else before.filter))
    earlier = [] if before is None else earlier_recordings(before)
    known = {one.sha256 for one in new + holdout}
    earlier = [one for one in earlier if one.sha256 not in known]
    progress("identifying")
    start = _start(session, [*earlier, *new], filter, columns)
    progress("diagnosing")
    nominal = isinstance(start, Model)
    found = diagnose_motion(
        start, [*earlier, *new], holdout, before.filter if nominal and before else None, seed, progress,
        before.layout if nominal and before else None,
    )  # fmt: skip
    identified = found.estimate or (start if isinstance(start, Estimate) else None)
    shown = _shown(session.model, [*new, *holdout], found.filter)
    said = answers(
        session.expectations, found, start if isinstance(start, Estimate) else found.estimate, _planned(session), shown
    )
    return Resumed(
        answers=said, diagnosis=found, estimate=identified, pooled=len(earlier), next=_next(session, found, progress)
    )


def _start(
    session: SavedSession, recordings: Sequence[Recording], filter: Filter | None, columns: str | None
) -> Estimate | Model:
    """The model that the diagnosis starts from, by the question of the earlier one."""
    before = session.diagnosis
    if before is None:
        return identify(session.model.robot, recordings, filter=filter, columns=columns)
    if before.question == "missing":
        effects = [replace(one) for one in before.model.effects]
        return identify(before.model.robot, recordings, effects, filter=before.filter, columns=before.layout)
    if before.question == "nominal":
        return before.model
    if before.model_file is None or not Path(before.model_file).is_file():
        raise InputError(
            f"the model {before.model_file or 'that was diagnosed'} is not at hand, which was asked what has changed since;"
            " expected it where it was when it was diagnosed"
        )
    return load_estimate(before.model_file)


def _planned(session: SavedSession) -> Ranges:
    """The ranges of the session's motions."""
    return reduce(Ranges.joined, (ranges_of(session.model, motion) for motion in session.motions))


def _shown(model: Model, recordings: Sequence[Recording], filter: Filter) -> Ranges:
    """The ranges of recordings."""
    return reduce(Ranges.joined, (ranges_of_signals(model, prepare(one, filter)) for one in recordings))


def _next(session: SavedSession, found: DiagnosisRecord, progress: Callable[[str], None]) -> Session | None:
    """The next session, with the budget of this one."""
    if not open_questions(found):
        return None
    progress("planning the next session")
    try:
        planned = plan_next(found, replace(session.budget, seed=session.budget.seed + 1))
    except NotSolvedError:
        return None
    return planned if planned.outlook is not None and planned.outlook.expectations else None
