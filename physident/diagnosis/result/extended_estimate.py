"""The extended model as an estimate: refitted, with the covariance of its values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from physident.diagnosis.search.hypothesis import Hypothesis
from physident.diagnosis.search.turning_speeds import with_widths_anew
from physident.diagnosis.statistics.intervals import Uncertainty
from physident.estimation.estimate import Estimate, as_estimate
from physident.estimation.estimated_model import Source
from physident.estimation.estimators import WLS
from physident.estimation.physical.certificate import Certificate, condition_number
from physident.estimation.physical.cones import physical_cones
from physident.estimation.regressor_fit import fit_with_rests, smallest_share
from physident.estimation.uncertainty import correlation_rows
from physident.identifiability.base_parameters import find_base_parameters
from physident.recordings.recording import Recording


def extended_estimate(hypothesis: Hypothesis, uncertainty: Uncertainty, recordings: Sequence[Recording]) -> Estimate:
    """The extended model's estimate: identified again if the model was fitted to these recordings; otherwise with the values
    of the diagnosis, which move the model's parameters within their covariance. The recordings of a change are then its own."""
    problem, model = hypothesis.problem, hypothesis.extension.model
    if problem.question == "missing" and isinstance(problem.given, Estimate) and not problem.recording_offsets:
        signals = [replace(one, transition=None) for one in problem.signals]
        effects, regressor = with_widths_anew(problem, model, signals)
        given = problem.given
        return fit_with_rests(
            model.robot, effects, regressor, signals, recordings, given.estimator, problem.filter, given.layout
        )[0]
    base = find_base_parameters(model.robot, model.effects)
    covariance = base.grouping @ uncertainty.theta.covariance @ base.grouping.T
    before = as_estimate(problem.given, problem.filter)
    regressor = hypothesis.data.regressor
    sources = tuple(
        Source(r.source, r.sha256, r.duration, float(np.count_nonzero(regressor.recording == i) / regressor.kept_rate))
        for i, r in enumerate(recordings)
    )
    size, counted = np.linalg.norm(hypothesis.torque, axis=0), regressor.counted.sum(axis=0)
    decided = np.sqrt(np.maximum(np.diag(covariance), 0.0)) > 0
    matrices = physical_cones(model.robot, model.effects).matrices
    eigenvalues = np.linalg.eigvalsh(hypothesis.fit.normal / _scale(hypothesis.fit.normal))[::-1]
    certificate = Certificate(
        stationarity=_stationarity(hypothesis),
        condition=condition_number(np.sqrt(np.maximum(eigenvalues, 0.0), dtype=np.float64)),
        determined=int(decided.sum()),
        iterations=1,
        eigenvalues=tuple(smallest_share(m.at(model.theta)) for m in matrices),
    )
    return Estimate(
        model=model,
        estimator=WLS(),
        covariance=covariance,
        sigma=np.linalg.norm(hypothesis.residual, axis=0) / np.sqrt(counted),
        relative=100 * np.linalg.norm(hypothesis.residual, axis=0) / np.where(size > 0, size, 1.0),
        effective_samples=len(regressor.time) / correlation_rows(regressor, hypothesis.fit.residual),
        certificate=certificate,
        filter=problem.filter,
        # what has changed is not in the recordings from before: they are no control of the model that it made
        sources=before.sources if problem.question == "missing" else sources,
        fitted=before.fitted if problem.question == "missing" else tuple(recordings),
        layout=before.layout,
        drive_gains=before.drive_gains,
        blocks=before.blocks,
        base_shares=tuple(float(d) for d in decided),
    )


def _scale(H: np.ndarray) -> np.ndarray:
    size = np.sqrt(np.where(np.diag(H) > 0, np.diag(H), 1.0))
    return np.outer(size, size)


def _stationarity(hypothesis: Hypothesis) -> float:
    """The largest gradient left, over the size of its terms."""
    fit, baseline = hypothesis.fit, hypothesis.baseline
    equations = hypothesis.products.equations
    pull = (
        np.tensordot(fit.weights**2, equations.slopes, 1) - np.tensordot(fit.weights**2, equations.squares, 1) @ fit.x
    )
    gradient = pull - baseline.prior * fit.x
    size = np.sqrt(np.maximum(np.diag(fit.normal), 1e-300)) * np.linalg.norm(fit.residual * fit.weights)
    return float(np.max(np.abs(gradient) / np.maximum(size, 1e-300), initial=0.0))
