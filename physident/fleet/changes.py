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
    effects = watched_effects(robot)
    watched = build_regressor(robot, effects, signals, filter, model=model)
    residual = (arm.torque - arm.predict(model.theta)) * watched.counted
    weights = rest_weights(spread_rows(robot, model.effects, signals, filter), dry_level(model), residual, arm.counted)
    sigma = np.maximum(joint_sigma(arm, residual * weights, 0.0), np.array(baseline.sigma))
    rows = weight_rows(watched, weights / sigma * watched.counted)
    response = residual * weights / sigma
    candidates, along = candidates_of(robot, effects)
    blocks = _products(rows, response)
    known = {c.name: float(v) for c, v in zip(model.columns, model.theta, strict=True)}
    names = [(column.name, column.unit) for column in rows.columns]
    load = np.sqrt((arm.predict(model.theta) ** 2).mean(axis=0))
    found = []
    for candidate in candidates:
        fit = _alone(blocks, list(candidate.columns), along)
        if fit is None:
            continue
        half = t_quantile(len(blocks))
        for k, place in enumerate(candidate.columns):
            name, unit = names[place]
            change, std = float(fit.change[k]), float(fit.std[k])
            found.append(
                Change(
                    candidate=candidate, parameter=name, unit=unit, baseline=known.get(name, 0.0), change=change, std=std,
                    low=known.get(name, 0.0) + change - half * std, high=known.get(name, 0.0) + change + half * std,
                    information=1 / float(np.linalg.inv(fit.information)[k, k]), coupling=tuple(fit.information[k].tolist()),
                    blocks=len(blocks), load=float(load[candidate.joint - 1]),
                )
            )  # fmt: skip
    return found


@dataclass(frozen=True, eq=False)
class _Fit:
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


def _alone(blocks: list[tuple[Array, Array]], chosen: list[int], along: list[int]) -> _Fit | None:
    """Least squares of some columns beside those that are always fitted along; None where they show nothing.

    The standard errors are those of a jackknife over the blocks.
    """
    places = np.array(chosen + along)
    N, z = sum(block[0] for block in blocks), sum(block[1] for block in blocks)
    H, g = np.asarray(N)[np.ix_(places, places)], np.asarray(z)[places]
    scale = np.sqrt(np.where(np.diag(H) > 0, np.diag(H), 1.0))
    H, g = H / np.outer(scale, scale), g / scale
    if (np.diag(H)[: len(chosen)] == 0).any() or np.linalg.eigvalsh(H)[0] < SEEN**2:
        return None
    whole, k = np.linalg.solve(H, g), len(chosen)
    left_out = np.array(
        [
            np.linalg.solve(H - part[np.ix_(places, places)] / np.outer(scale, scale), g - score[places] / scale)
            for part, score in blocks
        ]
    )
    G = len(blocks)
    std = np.sqrt((G - 1) / G * ((left_out - whole) ** 2).sum(axis=0))
    # what is left of the candidate's columns beside those that are fitted along
    information = np.linalg.inv(np.linalg.inv(H)[:k, :k]) * np.outer(scale[:k], scale[:k])
    return _Fit((whole / scale)[:k], (std / scale)[:k], information)
