"""Unseen recordings decide: a finding that makes them worse is a hint, and the extended model does not carry it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.grading.members import is_shown_by_comparison, members, without_effects
from physident.diagnosis.remainder.unexplained import LARGER
from physident.diagnosis.repeated.comparison import compare_with_control
from physident.diagnosis.result.advice import beyond_range_words
from physident.diagnosis.result.findings import Finding, JointErrors
from physident.diagnosis.result.wording import names_of, with_joints
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.dynamics.model import Model
from physident.effects.learned.curve import LearnedCurve
from physident.estimation.estimate import Estimate
from physident.estimation.identify import prepare_all
from physident.estimation.results.predictions import Predictions, predictions_of
from physident.recordings.recording import Recording
from physident.recordings.signals import Signals

Array = NDArray[np.float64]
UNSEEN = "not confirmed on unseen data"
JUDGED = 0.1  # of a joint's rows where its curves were learned: fewer are a stretch or two, which decide nothing
OLD_HOLDOUT = "the model predicts the holdout as well as its own recordings"
NOTICED = 0.1  # of a joint's rows beyond them: fewer change no error that anybody compares


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
    along any other motion the model errs by more than what has changed. A joint with a curve is judged where that was learned.
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


def from_before(findings: Sequence[Finding], errors: JointErrors, own: Array) -> str:
    """Why a holdout may refute nothing: the model, with these ``errors`` on it, predicts it as well as its ``own`` (n,) [N m|N] recordings, so
    that what it alone refutes is not in it. Empty where it refutes nothing else that would be a cause, or the model errs on it, too."""
    alone = [f for f in findings if f.doubts == (UNSEEN,) and (f.takes_percent or 0.0) > (f.leaves_percent or 0.0)]
    if not alone or (errors.rms > LARGER * own).any():
        return ""
    return (
        f"{OLD_HOLDOUT} and so refutes {'; '.join(names_of(alone, with_joints))}: it was recorded before the change, or only the diagnosed motion"
        " shows such a thing; give a holdout from after the change"
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
    before, after = _errors(hypothesis, (hypothesis.problem.model, refitted), signals, refitted)
    where = [_joints(hypothesis, group) if group else [] for group in groups]
    return [bool(after[joints].sum() > before[joints].sum()) for joints in where]


def _prepared(
    hypothesis: Hypothesis, holdout: Sequence[Recording], drive_gains: tuple[float, ...] | None
) -> list[Signals]:
    problem = hypothesis.problem
    with_torque = [recording.with_default_drive_gains(drive_gains) for recording in holdout]
    return prepare_all(problem.model.robot, with_torque, problem.filter)


def _errors(hypothesis: Hypothesis, models: Sequence[Model], signals: Sequence[Signals], learned: Model) -> list[Array]:
    """Mean squared errors (n,) of models on some signals, in units of the noise, over the rows where the curves of one were
    ``learned``; zero of a joint with hardly any such rows."""
    every = [predictions_of(model, signals, hypothesis.problem.filter) for model in models]
    rows = every[0].counted & _where_learned(learned, signals, every[0])
    rows &= rows.sum(axis=0) >= JUDGED * every[0].counted.sum(axis=0)
    return [(one.restricted(rows).rms / hypothesis.fit.sigma) ** 2 for one in every]


def _where_learned(model: Model, signals: Sequence[Signals], predictions: Predictions) -> NDArray[np.bool_]:
    """The rows (M, n) of predictions of signals in which every curve of a model is within the range it was learned in."""
    result = np.ones_like(predictions.counted)
    curves = [effect for effect in model.effects if isinstance(effect, LearnedCurve)]
    for k, one in enumerate(signals if curves else ()):
        rows, referred = predictions.recording == k, model.refer(one)
        at = np.minimum(np.searchsorted(one.time, predictions.time[rows]), len(one.time) - 1)
        result[rows] = np.all([curve.was_learned(model.robot, referred)[at] for curve in curves], axis=0)
    return result


def saying_what_is_beyond(
    hypothesis: Hypothesis,
    findings: Sequence[Finding],
    holdout: Sequence[Recording],
    drive_gains: tuple[float, ...] | None,
    given: Model,
    extended: Model,
) -> tuple[Finding, ...]:
    """The findings, with advice on those whose curve a holdout leaves: there it was not judged. Where the ``extended`` model errs on
    all of the holdout by more than the ``given`` one on a curve's joints, the curve is a cause, but it is not handed on."""
    signals = _prepared(hypothesis, holdout, drive_gains)
    before, after = (predictions_of(model, signals, hypothesis.problem.filter) for model in (given, extended))
    beyond = (after.counted & ~_where_learned(extended, signals, after)).sum(axis=0)
    share = beyond / np.maximum(after.counted.sum(axis=0), 1)
    more = (after.rms**2 - before.rms**2) / hypothesis.fit.sigma**2
    return tuple(_said_beyond(one, share, more) if one.curves and one.grade != "hint" else one for one in findings)


def _said_beyond(finding: Finding, share: Array, more: Array) -> Finding:
    """A finding with curves, given the share (n,) of a holdout beyond their range, and how much ``more`` (n,) power its error has."""
    joints = [joint - 1 for joint in finding.joints]
    if share[joints].max() <= NOTICED:
        return finding
    handed_on = bool(more[joints].sum() <= 0)
    said = beyond_range_words(finding.effect, float(share[joints].max()), handed_on)
    return replace(finding, advice=" ".join(filter(None, [said, finding.advice])), handed_on=handed_on)


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
        models = [one.extension.model for one in (hypothesis, without_effects(hypothesis, group))]
        judged = [one for k, one in enumerate(beside.signals) if k in beside.compared or not compared]
        whole, other = _errors(hypothesis, models, judged, models[0])
        result.append(bool(np.sum(whole[joints]) > np.sum(other[joints])))
    return result
