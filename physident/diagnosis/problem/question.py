"""The question of a diagnosis - different, missing or nominal - and how freely the model's parameters move meanwhile."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from physident.diagnosis.problem.columns import Baseline
from physident.diagnosis.statistics.normal_equations import pseudo_inverse
from physident.dynamics.model import Model
from physident.dynamics.regressor import JointRows, Regressor
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.estimation.physical.information_shares import BY_PRIOR
from physident.estimation.weighting import information_in
from physident.large_arrays import empty, steps
from physident.recordings.recording import Recording

Array = NDArray[np.float64]
Question = Literal["different", "missing", "nominal"]


def choose_question(model: Estimate | Model, recordings: Sequence[Recording]) -> Question:
    """Which question recordings put to a model; raises InputError where only some of them were fitted."""
    if not recordings:
        raise InputError("no recordings given, expected at least one to diagnose")
    if isinstance(model, Model):
        return "nominal"
    fitted = {source.sha256 for source in model.sources}
    seen = [recording for recording in recordings if recording.sha256 in fitted]
    if seen and len(seen) < len(recordings):
        new = next(recording for recording in recordings if recording.sha256 not in fitted)
        raise InputError(
            f"the model was fitted to {seen[0].source} but not to {new.source}; expected recordings that were all fitted"
            " (what is missing from the model?) or all new (what is different now?)"
        )
    return "missing" if seen else "different"


@dataclass(frozen=True, eq=False)
class ParameterFreedom:
    """How the model's parameters theta (p,) may move: theta + ``map`` (p, R) @ x, x of prior precision ``prior`` (R,).

    ``unidentified``: names of base parameters that the model never identified, which stay where they are. ``nuisance``: columns of
    the regressor that are refitted along and mean nothing; the last of x are theirs, and move no parameter. In ``compared``
    recordings (their indices), from whose torque the model's error was taken, parameters have no part.
    """

    map: Array
    prior: Array
    unidentified: tuple[str, ...]
    nuisance: tuple[int, ...] = ()
    compared: frozenset[int] = frozenset()

    def baseline(self, regressor: Regressor) -> Baseline:
        """The columns of x, from a regressor whose first p columns are the model's."""
        p = len(self.map)
        fixed = np.isin(regressor.recording, sorted(self.compared))
        joints = []
        for rows in regressor.joints:
            chosen = rows.columns < p
            columns = empty((len(self.prior), len(regressor.time))).T
            for some in steps(len(columns)):
                values = rows.some(some)
                columns[some] = values[:, chosen] @ self.map[rows.columns[chosen]]
                columns[some][fixed[some]] = 0.0
                for k, column in enumerate(self.nuisance, len(self.prior) - len(self.nuisance)):
                    columns[some, k] = values[:, rows.columns == column].sum(axis=1)
            joints.append(columns)
        return Baseline(tuple(joints), self.prior)


def parameter_freedom(
    model: Estimate | Model,
    question: Question,
    regressor: Regressor,
    nuisance: tuple[int, ...] = (),
    compared: frozenset[int] = frozenset(),
) -> ParameterFreedom:
    """Missing: every base parameter is free. Different: each is kept within its covariance, but for ``compared`` recordings. Nominal:
    none moves. The ``nuisance`` columns are free always: how much they matter depends on the motion, healthy arm or not."""
    if isinstance(model, Model):
        maps, prior, unidentified = np.zeros((len(model.theta), 0)), np.zeros(0), ()
    elif question == "missing":
        maps = np.zeros((len(model.theta), model.base.r))
        maps[model.base.independent, np.arange(model.base.r)] = 1.0
        prior, unidentified = np.zeros(model.base.r), ()
    else:
        root, unidentified = _root(model, regressor)
        maps = np.zeros((len(model.theta), root.shape[1]))
        maps[model.base.independent] = root
        prior = np.ones(root.shape[1])
    k = len(nuisance)
    whole = np.column_stack([maps, np.zeros((len(maps), k))])
    return ParameterFreedom(whole, np.concatenate([prior, np.zeros(k)]), unidentified, nuisance, compared)


def _root(estimate: Estimate, regressor: Regressor) -> tuple[Array, tuple[str, ...]]:
    """A root (r, R) of the base parameters' covariance, and the names of those that were never identified."""
    base = estimate.base
    decided = _shares(estimate) >= BY_PRIOR
    covariance = known_covariance(estimate, regressor)
    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    values, vectors = np.linalg.eigh(covariance / np.outer(size, size))
    kept = values > 1e-9 * values[-1]
    names = tuple(base.columns[base.independent[i]].name for i in np.flatnonzero(~decided))
    return size[:, None] * vectors[:, kept] * np.sqrt(values[kept]), names


def known_covariance(estimate: Estimate, regressor: Regressor) -> Array:
    """The covariance (r, r) of the base parameters, zero of those that were never identified.

    A covariance from G blocks has rank G and no more: it is mixed with the inverse of the fitted rows' information, as if that
    were r blocks of prior knowledge; else r - G directions would be known exactly. Of a model that does not know the
    information, the rows of the new motion stand in, at the old recordings' worth.
    """
    base, information = estimate.base, estimate.information
    if information is None:
        columns = len(estimate.theta)
        joints = tuple(
            JointRows(rows.columns[rows.columns < columns], rows.values[:, rows.columns < columns])
            for rows in regressor.joints
        )
        own = replace(regressor, joints=joints, columns=regressor.columns[:columns])
        information = information_in(own, base, estimate.sigma, estimate.effective_samples)
    share = base.r / (base.r + estimate.blocks)
    covariance = (1 - share) * estimate.covariance + share * pseudo_inverse(information)
    decided = _shares(estimate) >= BY_PRIOR
    return covariance * np.outer(decided, decided)


def _shares(estimate: Estimate) -> Array:
    """How much (r,) of each base parameter the data decided, all of it where the estimate does not say."""
    return np.array(estimate.base_shares or np.ones(estimate.base.r))
