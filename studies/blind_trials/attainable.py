"""How well could anybody know a hidden effect's size, who already knows its cause, its place and its shape?"""

from __future__ import annotations

from math import erf, sqrt

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.dynamics.regressor import Regressor
from physident.estimation.uncertainty import correlation_rows
from studies.blind_trials.arms import FILTER
from studies.blind_trials.sizing import filtered
from studies.blind_trials.summary import WITHIN
from studies.blind_trials.trial import Prepared

Array = NDArray[np.float64]
ROUNDS = 3  # of weights; they settle after two


def attainable(prepared: Prepared) -> float:
    """The chance [%] that the best unbiased estimate of the size alone is within ten per cent (Cramer and Rao's bound).

    The hidden torque to the sample is one column beside what the question leaves open: all of the model for what is missing,
    the model within its covariance for what is different, nothing for a nominal one.
    """
    runs = prepared.changed[:2]
    without = [taken.without for taken in runs]
    # friction as these recordings turn it, as a diagnosis has it
    regressor = filtered(without, pid.identify(pid.load_robot("ur5"), without, filter=FILTER).model.effects)
    torque = filtered([taken.alone for taken in runs]).torque
    Y = [_dense(regressor, j) for j in range(torque.shape[1])]
    weights = _weights(regressor, Y)
    column = np.concatenate([w * own for w, own in zip(weights, torque.T, strict=True)])
    if prepared.trial.question == "nominal":
        information = column @ column
    else:
        information = _outside(prepared, np.vstack([w * own for w, own in zip(weights, Y, strict=True)]), column)
    return 100 * erf(WITHIN / 100 * sqrt(information / 2))


def _outside(prepared: Prepared, Y: Array, column: Array) -> float:
    """What a column tells beside the model's own."""
    if not isinstance(prepared.model, pid.Estimate) or prepared.trial.question == "missing":
        left = column - Y @ np.linalg.lstsq(Y, column, rcond=1e-8)[0]
        return float(left @ left)
    values, vectors = np.linalg.eigh(prepared.model.covariance)
    A = Y[:, prepared.model.base.independent] @ (vectors * np.sqrt(np.maximum(values, 0.0)))
    slope = A.T @ column
    return float(column @ column - slope @ np.linalg.solve(np.eye(len(slope)) + A.T @ A, slope))


def _dense(regressor: Regressor, joint: int) -> Array:
    rows = regressor.joints[joint]
    values = np.zeros((len(rows.values), len(regressor.columns)))
    values[:, rows.columns] = rows.values
    return values


def _weights(regressor: Regressor, Y: list[Array]) -> Array:
    """Weights (n,) of joints' rows: one over the noise, and over the root of its memory in rows."""
    sigma, residual = np.ones(len(Y)), regressor.torque
    for _ in range(ROUNDS):
        A = np.vstack([own / s for own, s in zip(Y, sigma, strict=True)])
        y = np.concatenate([own / s for own, s in zip(regressor.torque.T, sigma, strict=True)])
        x = np.linalg.lstsq(A, y, rcond=1e-8)[0]
        residual = regressor.torque - np.column_stack([own @ x for own in Y])
        sigma = np.sqrt(np.mean(residual**2, axis=0))
    return 1 / (sigma * np.sqrt(correlation_rows(regressor, residual)))
