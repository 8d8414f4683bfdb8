"""From base parameters back to all parameters: what no motion can show stays nominal."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physident.identifiability.base_parameters import BaseParameters

Array = NDArray[np.float64]


def nearest_to(nominal: Array, base: BaseParameters, values: Array) -> Array:
    """The parameters (p,) nearest to ``nominal`` whose base parameters are ``values`` (r,): what no motion can show
    stays where the robot's description has it."""
    K = base.grouping
    return nominal + K.T @ np.linalg.solve(K @ K.T, values - K @ nominal)
