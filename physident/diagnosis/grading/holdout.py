"""Unseen recordings decide: a finding that makes them worse is a hint, and the extended model does not carry it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.grading.members import members, without_effects
from physident.diagnosis.result.findings import Finding
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.dynamics.model import Model
from physident.estimation.identify import prepare_all
from physident.estimation.results.predictions import predictions_of
from physident.recordings.recording import Recording

Array = NDArray[np.float64]
UNSEEN = "not confirmed on unseen data"


def held_to_unseen(
    hypothesis: Hypothesis,
    findings: Sequence[Finding],
    holdout: Sequence[Recording],
    drive_gains: tuple[float, ...] | None,
) -> tuple[Finding, ...]:
    """The findings, those as hints with which the holdout's error on their joints is larger than without them, all others
    refitted. A contact belongs to its own recording and stays."""
    if not holdout:
        return tuple(findings)
    groups = [[] if finding.intervals else members(hypothesis, finding) for finding in findings]
    worse = made_worse(hypothesis, groups, holdout, drive_gains)
    return tuple(
        replace(finding, grade="hint", doubts=(*finding.doubts, UNSEEN)) if bad else finding
        for finding, bad in zip(findings, worse, strict=True)
    )


def made_worse(
    hypothesis: Hypothesis,
    groups: Sequence[Sequence[int]],
    holdout: Sequence[Recording],
    drive_gains: tuple[float, ...] | None,
) -> list[bool]:
    """Whether the holdout's error on its joints is larger with each group of accepted effects (their indices) than without it."""
    problem = hypothesis.problem
    with_torque = [recording.with_default_drive_gains(drive_gains) for recording in holdout]
    signals = prepare_all(problem.model.robot, with_torque, problem.filter)

    def errors(model: Model) -> Array:
        """Mean squared error (n,) of a model on the holdout, in units of the noise."""
        return (predictions_of(model, signals, problem.filter).rms / hypothesis.fit.sigma) ** 2

    whole, result = errors(hypothesis.extension.model), []
    for group in groups:
        joints = [j - 1 for i in group for j in hypothesis.accepted[i].candidate.joints] or slice(None)
        other = errors(without_effects(hypothesis, group).extension.model) if group else whole
        result.append(bool(np.sum(whole[joints]) > np.sum(other[joints])))
    return result
