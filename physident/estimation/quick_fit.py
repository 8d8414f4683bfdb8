"""Weighted least squares without its uncertainty: the first values that others start from."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.dynamics.regressor import Regressor
from physident.effects.effect import Effect
from physident.estimation.least_squares import solve_step
from physident.identifiability.base_parameters import find_base_parameters
from physident.large_arrays import magnitude
from physident.robots.robot import Robot

Array = NDArray[np.float64]
SETTLED = 1e-3  # largest change between rounds: of the noise's size, or of the model's torque relative to the residual
REFRESHES = 20


def quick_fit(robot: Robot, effects: tuple[Effect, ...], regressor: Regressor) -> Array:
    """Parameters (p,) by weighted least squares on the QR factors; what the data do not show keeps its nominal value."""
    base, nominal = find_base_parameters(robot, effects), Model.nominal(robot, effects).theta
    theta, floor = nominal, 1e-9 * max(1.0, float(magnitude(regressor.torque).max()))
    weights = np.ones(robot.n)
    for _ in range(REFRESHES):
        solved = solve_step(regressor, base, weights, base.values(nominal))
        theta = base.nearest(nominal, solved.x)
        after = 1 / np.maximum(regressor.joint_sizes(theta) / np.sqrt(len(regressor.time)), floor)
        settled = np.allclose(after, weights, rtol=SETTLED)
        weights = after
        if settled:
            break
    return theta
