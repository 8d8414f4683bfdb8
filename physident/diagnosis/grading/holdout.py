"""Unseen recordings decide: a finding that makes them worse is a hint, and the extended model does not carry it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.grading.members import without
from physident.diagnosis.result.findings import Finding
from physident.diagnosis.search.hypothesis import Hypothesis
from physident.dynamics.model import Model
from physident.estimation.estimate import as_estimate
from physident.recordings.recording import Recording
from physident.validation.predictions import predict

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
    whole = _errors(hypothesis.extension.model, hypothesis, holdout, drive_gains)
    result = []
    for finding in findings:
        if finding.intervals:
            result.append(finding)
            continue
        rest = without(hypothesis, [finding])
        index = [j - 1 for j in finding.joints] or list(range(len(whole)))
        other = _errors(rest.extension.model, hypothesis, holdout, drive_gains)
        worse = float(np.sum(whole[index])) > float(np.sum(other[index]))
        result.append(replace(finding, grade="hint", doubts=(*finding.doubts, UNSEEN)) if worse else finding)
    return tuple(result)


def _errors(
    model: Model, hypothesis: Hypothesis, holdout: Sequence[Recording], drive_gains: tuple[float, ...] | None
) -> Array:
    """Mean squared error (n,) of a model on the holdout, in units of the noise."""
    estimate = replace(as_estimate(model, hypothesis.problem.filter), drive_gains=drive_gains)
    predictions = predict(estimate, holdout)
    return (predictions.rms / hypothesis.fit.sigma) ** 2
