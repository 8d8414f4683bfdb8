"""The extended model as an estimate: refitted, with what is known about it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.statistics.intervals import Uncertainty
from physident.dynamics.model import Model
from physident.estimation.estimate import Estimate, Source
from physident.estimation.estimators import WLS
from physident.estimation.identify import estimate_from, smallest_share
from physident.estimation.physical.certificate import Certificate
from physident.estimation.physical.cones import physical_cones
from physident.estimation.shapes import refreshed
from physident.estimation.uncertainty import correlation_rows
from physident.identifiability.base_parameters import find_base_parameters
from physident.recordings.recording import Recording
from physident.recordings.signals import Filter


def extended_estimate(hypothesis: Hypothesis, uncertainty: Uncertainty, recordings: Sequence[Recording]) -> Estimate:
    """The extended model's estimate: identified again where it was fitted to these recordings, else the values of the
    diagnosis, the model's own moved within their covariance."""
    problem, model = hypothesis.problem, hypothesis.extension.model
    if problem.question == "missing" and isinstance(problem.given, Estimate) and not problem.recording_offsets:
        regressor = refreshed(model.robot, model.effects, problem.signals, problem.filter, model.theta)
        return estimate_from(
            model.robot,
            model.effects,
            regressor,
            recordings,
            problem.given.estimator,
            problem.filter,
            problem.given.columns,
        )
    base = find_base_parameters(model.robot, model.effects)
    covariance = base.grouping @ uncertainty.covariance @ base.grouping.T
    before = as_estimate(problem.given, problem.filter)
    regressor = hypothesis.data.regressor
    sources = tuple(
        Source(r.source, r.sha256, r.duration, float(np.count_nonzero(regressor.recording == i) / regressor.kept_rate))
        for i, r in enumerate(recordings)
    )
    size, counted = np.linalg.norm(hypothesis.torque, axis=0), regressor.counted.sum(axis=0)
    decided = np.sqrt(np.maximum(np.diag(covariance), 0.0)) > 0
    matrices = physical_cones(model.robot, model.effects).matrices
    eigenvalues = np.linalg.eigvalsh(hypothesis.fit.normal / _scale(hypothesis.fit.normal))
    certificate = Certificate(
        _stationarity(hypothesis), float(np.sqrt(eigenvalues[-1] / max(eigenvalues[0], 1e-300))), int(decided.sum()), 1,
        eigenvalues=tuple(smallest_share(m.at(model.theta)) for m in matrices),
    )  # fmt: skip
    return Estimate(
        model, WLS(), covariance, np.linalg.norm(hypothesis.residual, axis=0) / np.sqrt(counted),
        100 * np.linalg.norm(hypothesis.residual, axis=0) / np.where(size > 0, size, 1.0),
        len(regressor.time) / correlation_rows(regressor, hypothesis.fit.residual), certificate, problem.filter, (*before.sources, *sources), before.columns,
        before.drive_gains, before.blocks, base_shares=tuple(float(d) for d in decided),
    )  # fmt: skip


def as_estimate(model: Estimate | Model, filter: Filter) -> Estimate:
    """An estimate that says nothing is known of a model but its values; an estimate as it is."""
    if isinstance(model, Estimate):
        return model
    r, n = find_base_parameters(model.robot, model.effects).r, model.robot.n
    none = Certificate(0.0, 1.0, 0, 0)
    return Estimate(
        model, WLS(), np.zeros((r, r)), np.zeros(n), np.zeros(n), np.zeros(n), none, filter, (),
        base_shares=(0.0,) * r,
    )  # fmt: skip


def _scale(H: np.ndarray) -> np.ndarray:
    size = np.sqrt(np.where(np.diag(H) > 0, np.diag(H), 1.0))
    return np.outer(size, size)


def _stationarity(hypothesis: Hypothesis) -> float:
    """The largest gradient left, over the size of its terms."""
    now, baseline = hypothesis.fit, hypothesis.baseline
    gradient = -baseline.prior * now.x
    for B, r, w in zip(baseline.joints, now.residual.T, now.weights, strict=True):
        gradient = gradient + w * w * (B.T @ r)
    size = np.sqrt(np.maximum(np.diag(now.normal), 1e-300)) * np.linalg.norm(now.residual * now.weights)
    return float(np.max(np.abs(gradient) / np.maximum(size, 1e-300), initial=0.0))
