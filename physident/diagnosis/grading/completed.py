"""The model with what its own recordings show that it lacks: only beside that can a change be told from an old fault.

Friction that a model does not have is missing before and after. Asked what is different, a search would name it, and what it
hides or imitates would be named with it. So the recordings that the model was fitted to are asked first what is missing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from physident.diagnosis.grading.holdout import made_worse
from physident.diagnosis.grading.members import without_effects
from physident.diagnosis.learned.search_and_learn import search_and_learn
from physident.diagnosis.problem.problem import state_problem
from physident.diagnosis.result.assemble import make_findings
from physident.diagnosis.result.extended_estimate import extended_estimate
from physident.diagnosis.result.findings import Finding
from physident.diagnosis.rivals.rivals import RivalCheck
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.intervals import uncertainty_of
from physident.effects.catalogue import CATALOGUE
from physident.errors import PhysidentError, warn
from physident.estimation.estimate import Estimate
from physident.estimation.identify import prepare_all
from physident.estimation.results.predictions import predictions_of
from physident.recordings.recording import Recording
from physident.recordings.signals import Signals
from physident.validation.predictions import predicted

CHANGED = 2.0  # times the error that a model left on its own recordings: a joint that errs more has changed


@dataclass(frozen=True, kw_only=True, eq=False)
class CompletedModel:
    """An ``estimate`` with all that its own recordings show, and the ``findings`` that were added to it."""

    estimate: Estimate
    findings: tuple[Finding, ...] = ()


def complete_model(
    estimate: Estimate,
    control: Sequence[Recording],
    asked: Sequence[Recording],
    seed: int,
    progress: Callable[[str], None],
) -> CompletedModel:
    """The estimate with what a search on the ``control``, all of the recordings that it was fitted to, adds to it.

    What makes the error on the recordings that are ``asked`` larger is not added, where these joints are as they were: it held where
    the arm had been, and not where it is.
    Where these recordings cannot be searched, or what is found cannot be identified beside the model, the estimate stays as it is, and
    a warning says so.
    """
    signals = prepare_all(estimate.model.robot, control, estimate.filter)
    try:
        found = _searched(estimate, control, signals, seed, progress)
        hypothesis = _held_to(found, signals, asked, estimate)
        if not hypothesis.accepted:
            return CompletedModel(estimate=estimate)
        uncertainty = uncertainty_of(hypothesis)
        extended = extended_estimate(hypothesis, uncertainty, control)
    except PhysidentError as refusal:
        warn(
            f"what the model always lacked may be named as a change: its own recordings could not be searched ({refusal})"
        )
        return CompletedModel(estimate=estimate)
    checks = [RivalCheck(one, 0.0, ()) for one in hypothesis.accepted]
    return CompletedModel(estimate=extended, findings=make_findings(hypothesis, checks, uncertainty))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Search:
    """What a search of a model's own recordings found, and ``asked``, all that it depends on beside the estimate."""

    estimate: Estimate
    asked: tuple[object, ...]
    found: Hypothesis


# one at most: who holds recording after recording against a model asks the same of its own recordings every time
_last: list[_Search] = []


def _searched(
    estimate: Estimate,
    control: Sequence[Recording],
    signals: Sequence[Signals],
    seed: int,
    progress: Callable[[str], None],
) -> Hypothesis:
    """What the search of a model's own recordings finds; the last answer where the same is asked again."""
    asked = (*map(_content, control), seed, *CATALOGUE.items())
    for known in _last:
        if known.estimate is estimate and known.asked == asked:
            progress("the model's own recordings were searched before")
            return known.found
    progress("searching the model's own recordings for what they show already")
    _last.clear()
    found = search_and_learn(state_problem("missing", estimate, signals, estimate.filter, seed)).last.hypothesis
    found.problem.forget()
    _last.append(_Search(estimate=estimate, asked=asked, found=found))
    return found


def _content(recording: Recording) -> tuple[object, ...]:
    """What distinguishes a recording from another one; its hash is that of the file."""
    measured = None if recording.temperature is None else recording.temperature.tobytes()
    return recording.sha256, recording.effort_kind, recording.drive_gains, measured


def _held_to(
    hypothesis: Hypothesis, own: Sequence[Signals], asked: Sequence[Recording], estimate: Estimate
) -> Hypothesis:
    """The hypothesis without the effects that make the error of their joints on other recordings larger. Where a joint has changed,
    its error says nothing of what it always lacked."""
    left = predictions_of(estimate.model, own, estimate.filter).rms
    as_before = predicted(estimate, asked).rms < CHANGED * left
    told = [
        i
        for i, one in enumerate(hypothesis.accepted)
        if as_before[[j - 1 for j in one.candidate.joints] or slice(None)].all()
    ]
    worse = made_worse(hypothesis, [[i] for i in told], asked, estimate.drive_gains)
    return without_effects(hypothesis, [i for i, bad in zip(told, worse, strict=True) if bad])
