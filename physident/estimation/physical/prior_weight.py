"""The prior weight "auto": the one whose fits predict left-out recordings best."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.regressor import JointRows, Regressor
from physident.errors import InputError
from physident.estimation.physical.semidefinite_program import SemidefiniteProgram
from physident.estimation.uncertainty import block_labels
from physident.estimation.weighting import compress
from physident.identifiability.base_parameters import BaseParameters

WEIGHTS = tuple(float(w) for w in 10.0 ** np.arange(-2, 5))
MAX_FOLDS = 8


def choose_prior_weight(
    program: SemidefiniteProgram, white: Regressor, base: BaseParameters, independent_share: float
) -> float:
    """The weight of ``WEIGHTS`` with the smallest error on left-out recordings, or blocks of a single recording.

    ``white`` is the regressor in units of its noise, ``independent_share`` the number of independent samples for each of
    its rows. Raises InputError for a single recording that is too short to be split.
    """
    data = [(compress(train, base), test) for train, test in _folds(white)]
    errors = []
    for weight in WEIGHTS:
        error = 0.0
        for train, test in data:
            answer = program.solve(train, weight / (independent_share * train.rows))
            theta = program.problem.coordinates.T @ answer.u
            error += float((test.residual(theta) ** 2).sum())
        errors.append(error)
    return WEIGHTS[int(np.argmin(errors))]


def _folds(regressor: Regressor) -> list[tuple[Regressor, Regressor]]:
    """Training and test rows of each fold."""
    labels = regressor.recording
    if len(np.unique(labels)) == 1:
        labels = block_labels(regressor.segment, max(1, -(-len(labels) // 4)))
    groups = np.unique(labels)
    if len(groups) < 2:
        raise InputError(
            "prior weight 'auto' needs data to leave out: give two recordings, or a longer one, or a weight"
        )
    tests = [np.flatnonzero(np.isin(labels, part)) for part in np.array_split(groups, min(MAX_FOLDS, len(groups)))]
    every = np.arange(len(labels))
    return [(_select(regressor, np.setdiff1d(every, rows)), _select(regressor, rows)) for rows in tests]


def _select(regressor: Regressor, rows: NDArray[np.intp]) -> Regressor:
    joints = tuple(JointRows(joint.columns, joint.some(rows)) for joint in regressor.joints)
    return replace(
        regressor,
        joints=joints,
        torque=regressor.torque[rows],
        time=regressor.time[rows],
        recording=regressor.recording[rows],
        segment=regressor.segment[rows],
        counted=regressor.counted[rows],
    )
