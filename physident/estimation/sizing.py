"""Parameters that recordings cannot size: only their sum with others is known, and each alone is of any size."""

from __future__ import annotations

import numpy as np

from physident.dynamics.regressor import Regressor
from physident.identifiability.base_parameters import BaseParameters
from physident.large_arrays import blocks

UNSIZED = 10.0  # times the measured torque: physical contributions to a joint's torque cancel one another far less


def unsized_parameters(regressor: Regressor, base: BaseParameters, theta: np.ndarray) -> tuple[str, ...]:
    """Names of the base parameters whose torque along the recordings is many times the measured one on some joint.

    The torques of such parameters cancel one another, because the motion moves all that they depend on alike; ``theta``
    (p,) are the parameters.
    """
    sizes = np.abs(base.values(theta))
    place = {int(index): i for i, index in enumerate(base.independent)}
    found: set[int] = set()
    for joint, rows in enumerate(regressor.joints):
        limit = UNSIZED * float(np.linalg.norm(regressor.torque[:, joint]))
        squares = sum((rows.some(some) ** 2).sum(axis=0) for some in blocks(len(regressor.time)))
        torques = np.sqrt(squares)
        for column, torque in zip(rows.columns, torques, strict=True):
            if column in place and limit > 0 and torque * sizes[place[column]] > limit:
                found.add(int(column))
    return tuple(base.columns[column].name for column in sorted(found))
