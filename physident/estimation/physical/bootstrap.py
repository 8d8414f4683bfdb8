"""Standard errors of a physical fit by refits to resampled blocks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physident.estimation.physical.problem import Answer
from physident.estimation.physical.semidefinite_program import SemidefiniteProgram
from physident.estimation.uncertainty import Jackknife
from physident.estimation.weighting import Compressed

Array = NDArray[np.float64]


def bootstrap_covariance(
    program: SemidefiniteProgram,
    data: Compressed,
    curved: Compressed,
    answer: Answer,
    left_out: Jackknife,
    resamples: int,
    seed: int,
) -> Array:
    """Covariance (r, r) of the base parameters over refits to resampled blocks of ``data``.

    Wild block bootstrap: each block's gradient keeps its size and gets a random sign, the motion stays the same (Cameron,
    Gelbach, Miller, "Bootstrap-based improvements for inference with clustered errors", 2008). ``curved`` is ``data`` with
    the curvature of a robust loss.
    """
    b = program.problem.KT @ answer.u
    balance = data.R.T @ (data.z - data.R @ b)  # the gradient that prior and cones balance at the answer
    to_z = np.linalg.pinv(curved.R.T, rcond=1e-10)
    rng = np.random.default_rng(seed)
    values = []
    for signs in rng.choice([-1.0, 1.0], size=(resamples, left_out.blocks)):
        push = signs @ left_out.pushes * np.sqrt(left_out.shrink)
        resampled = Compressed(curved.R, curved.R @ b + to_z @ (balance + push), data.rest, data.rows)
        values.append(program.problem.KT @ program.solve(resampled, answer.strength).u - b)
    return np.atleast_2d(np.cov(np.array(values).T, ddof=1))
