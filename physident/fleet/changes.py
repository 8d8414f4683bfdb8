"""What one recording shows to have changed since an arm's baseline: each candidate by itself, with its interval."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import Regressor, build_regressor
from physident.estimation.dry_friction.held_rests import hold_rests
from physident.estimation.dry_friction.row_weights import dry_level, rest_weights, spread_rows
from physident.estimation.estimate import Estimate
from physident.estimation.identify import prepare_all
from physident.estimation.uncertainty import (
    BLOCK_PERIODS,
    FEWEST_BLOCKS,
    block_labels,
    correlation_rows,
    t_quantile,
)
from physident.estimation.weighting import joint_sigma, weight_rows
from physident.fleet.candidates import Candidate, candidates_of, watched_effects
from physident.recordings.recording import Recording
from physident.threads import one_thread

Array = NDArray[np.float64]
SEEN = 1e-6  # of a column's length: less than that is left of one that others explain


@dataclass(frozen=True, kw_only=True)
class Change:
    """The change of one parameter since the baseline, as if its candidate alone had changed.

    ``value`` is the baseline's with the change, ``std`` the standard error of the change and ``low`` to ``high`` its 95 %
    interval, from ``blocks`` blocks. ``information`` is what a unit of the change explains, in squares of the noise, beside the
    candidate's other parameters, and ``coupling`` (k,) the row of the matrix with which the candidate's k parameters explain it
    together. ``baseline`` is the value that the change is relative to, zero where the arm has none of it; ``load`` [N m|N] is the RMS of
    the baseline's torque on the joint.
    """

    candidate: Candidate
    parameter: str
    unit: str
    baseline: float
    change: float
    std: float
    low: float
    high: float
    information: float
    coupling: tuple[float, ...]
    blocks: int
    load: float

    @property
    def value(self) -> float:
        """The value of the parameter."""
        return self.baseline + self.change


@one_thread
def changes_in(baseline: Estimate, recording: Recording) -> list[Change]:
    """The changes of all watched parameters in a recording; raises InputError as ``identify`` does."""
    model, robot, filter = baseline.model, baseline.model.robot, baseline.filter
    signals = hold_rests(model, prepare_all(robot, [recording], filter))
    arm = build_regressor(robot, model.effects, signals, filter, model=model)
    effects = watched_effects(model)
    watched = build_regressor(robot, effects, signals, filter, model=model)
    residual = arm.residual(model.theta) * watched.counted
    weights = rest_weights(spread_rows(robot, model.effects, signals, filter), dry_level(model), residual, arm)
    sigma = np.maximum(joint_sigma(arm, residual * weights, 0.0), np.array(baseline.sigma))
    rows = weight_rows(watched, weights / sigma * watched.counted)
    response = residual * weights / sigma
    blocks = _products(rows, response)
    half = t_quantile(len(blocks))
    load = np.sqrt((arm.predict(model.theta) ** 2).mean(axis=0))
    found = []
    for candidate in candidates_of(model, effects):
        fit = _alone(blocks, candidate.weights)
        if fit is None:
            continue
        for k, place in enumerate(fit.seen):
            name, unit, known = candidate.names[place], candidate.units[place], candidate.baseline[place]
            change, std = float(fit.change[k]), float(fit.std[k])
            found.append(
                Change(
                    candidate=candidate, parameter=name, unit=unit, baseline=float(known), change=change, std=std,
                    low=float(known) + change - half * std, high=float(known) + change + half * std,
                    information=1 / float(np.linalg.inv(fit.information)[k, k]), coupling=tuple(fit.information[k].tolist()),
                    blocks=len(blocks), load=float(load[candidate.joint - 1]),
                )
            )  # fmt: skip
    return found


@dataclass(frozen=True, eq=False)
class _Fit:
    seen: list[int]
    change: Array
    std: Array
    information: Array


def _products(rows: Regressor, response: Array) -> list[tuple[Array, Array]]:
    """Products (p, p) of the columns and (p,) with the response, of each block of rows: all that is kept of them."""
    memory = float(correlation_rows(rows, response).max())
    length = max(1, min(math.ceil(BLOCK_PERIODS * memory), len(response) // FEWEST_BLOCKS))
    labels = block_labels(rows.segment, length)
    result = []
    for label in range(int(labels.max()) + 1):
        chosen = np.flatnonzero(labels == label)
        A = rows.dense(chosen).reshape(-1, len(rows.columns))
        result.append((A.T @ A, A.T @ response[chosen].ravel()))
    return result


def _alone(blocks: list[tuple[Array, Array]], weights: Array) -> _Fit | None:
    """Least squares of a candidate's columns, sums of all columns by ``weights`` (p, k); None where they show nothing.

    The standard errors are those of a jackknife over the blocks.
    """
    lengths = np.sqrt(np.diag(weights.T @ sum(N for N, _ in blocks) @ weights))
    seen = np.flatnonzero(
        lengths > SEEN * lengths.max(initial=0.0)
    ).tolist()  # a plane arm shows no moment across its plane
    weights = weights[:, seen]
    parts = [(weights.T @ N @ weights, weights.T @ z) for N, z in blocks]
    H, g = np.sum([N for N, _ in parts], axis=0), np.sum([z for _, z in parts], axis=0)
    scale = np.sqrt(np.diag(H))
    if not seen or np.linalg.eigvalsh(H / np.outer(scale, scale))[0] < SEEN**2:
        return None
    whole = np.linalg.solve(H, g)
    left_out = np.array([np.linalg.solve(H - N, g - z) for N, z in parts])
    G = len(blocks)
    return _Fit(seen, whole, np.sqrt((G - 1) / G * ((left_out - whole) ** 2).sum(axis=0)), H)
