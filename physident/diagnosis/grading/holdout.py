"""Unseen recordings decide: a finding that makes them worse is a hint, and the extended model does not carry it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.grading.members import is_shown_by_comparison, members, without_effects
from physident.diagnosis.repeated.comparison import compare_with_control
from physident.diagnosis.result.findings import Finding
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.dynamics.model import Model
from physident.estimation.estimate import Estimate
from physident.estimation.identify import prepare_all
from physident.estimation.results.predictions import predictions_of
from physident.recordings.recording import Recording
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
UNSEEN = "not confirmed on unseen data"


def held_to_unseen(
    hypothesis: Hypothesis,
    findings: Sequence[Finding],
    holdout: Sequence[Recording],
    drive_gains: tuple[float, ...] | None,
    control: Sequence[Signals] = (),
    refitted: Estimate | None = None,
) -> tuple[Finding, ...]:
    """The findings, those as hints with which the holdout's error on their joints is larger than without them, all others
    refitted, or on whose joints the extended model, where it is ``refitted`` as a whole, errs by more than the model did. A contact
    belongs to its own recording and stays.

    What a comparison with the ``control`` shows is judged by unseen recordings that are compared too, and stays where there is none:
    along any other motion the model errs by more than what has changed.
    """
    if not holdout:
        return tuple(findings)
    groups = [[] if finding.intervals else members(hypothesis, finding) for finding in findings]
    worse = made_worse(hypothesis, groups, holdout, drive_gains, control)
    if refitted:
        lost = errs_more_where(hypothesis, groups, holdout, drive_gains, refitted.model)
        worse = [either or other for either, other in zip(worse, lost, strict=True)]
    return tuple(
        replace(finding, grade="hint", doubts=(*finding.doubts, UNSEEN), no_cause="") if bad else finding
        for finding, bad in zip(findings, worse, strict=True)
    )


def errs_more_where(
    hypothesis: Hypothesis,
    groups: Sequence[Sequence[int]],
    holdout: Sequence[Recording],
    drive_gains: tuple[float, ...] | None,
    refitted: Model,
) -> list[bool]:
    """Whether a refitted model errs by more than the problem's model on the joints of each group: what fitted rows leave open
    between an effect and gravity, two fits settle differently, and only one of them is handed on."""
    signals = _prepared(hypothesis, holdout, drive_gains)
    before, after = (_errors(hypothesis, model, signals) for model in (hypothesis.problem.model, refitted))
    where = [_joints(hypothesis, group) if group else [] for group in groups]
    return [bool(after[joints].sum() > before[joints].sum()) for joints in where]


def _prepared(
    hypothesis: Hypothesis, holdout: Sequence[Recording], drive_gains: tuple[float, ...] | None
) -> list[Signals]:
    problem = hypothesis.problem
    with_torque = [recording.with_default_drive_gains(drive_gains) for recording in holdout]
    return prepare_all(problem.model.robot, with_torque, problem.filter)


def _errors(hypothesis: Hypothesis, model: Model, signals: Sequence[Signals]) -> Array:
    """Mean squared error (n,) of a model on some signals, in units of the noise."""
    return (predictions_of(model, signals, hypothesis.problem.filter).rms / hypothesis.fit.sigma) ** 2


def _joints(hypothesis: Hypothesis, group: Sequence[int]) -> list[int]:
    """The joints (indices) of a group of accepted effects; all, where they name none."""
    named = {j - 1 for i in group for j in hypothesis.accepted[i].candidate.joints}
    return sorted(named or range(hypothesis.problem.model.robot.n))


def made_worse(
    hypothesis: Hypothesis,
    groups: Sequence[Sequence[int]],
    holdout: Sequence[Recording],
    drive_gains: tuple[float, ...] | None,
    control: Sequence[Signals] = (),
) -> list[bool]:
    """Whether the holdout's error on its joints is larger with each group of accepted effects (their indices) than without it."""
    signals = _prepared(hypothesis, holdout, drive_gains)
    beside = compare_with_control(hypothesis.problem.model, signals, control)
    result = []
    for group in groups:
        compared = any(is_shown_by_comparison(hypothesis, i) for i in group)
        if compared and not beside.compared:
            result.append(False)
            continue
        joints = _joints(hypothesis, group)
        models = (one.extension.model for one in (hypothesis, without_effects(hypothesis, group)))
        judged = [one for k, one in enumerate(beside.signals) if k in beside.compared or not compared]
        whole, other = (_errors(hypothesis, model, judged) for model in models)
        result.append(bool(np.sum(whole[joints]) > np.sum(other[joints])))
    return result
