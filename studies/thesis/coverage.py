"""Do stated intervals hold the truth, and how far off are parameters, over many draws of the noise?"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

import physident as pid
from physident.estimation.least_squares import least_squares
from physident.estimation.uncertainty import t_quantile
from physident.identifiability.base_parameters import find_base_parameters
from studies.thesis import ours
from studies.thesis.currents import measured_torque
from studies.thesis.reference import run
from studies.thesis.scores import filtered

DRAWS = 100


def coverage(model: str, robot: pid.Robot, motion: pid.Trajectory, draws: int = DRAWS) -> dict[str, Any]:
    """Share of draws and base parameters whose 95 % interval holds the truth, and the base parameters' relative error.

    Weighted least squares, as ``identify`` does it, with what does not change between draws made once.
    """
    clean = run(model, motion, robot)
    regressor, base = ours.regressor(robot, clean), find_base_parameters(robot, ours.effects())
    nominal = pid.Model.nominal(robot, ours.effects()).theta
    true = base.values(ours.truth(robot, model))
    inside, off = [], []
    for seed in range(draws):
        noisy = filtered(measured_torque(clean.true, np.random.default_rng([seed, 9])))
        found = least_squares(replace(regressor, torque=noisy), base, nominal, "diagonal")
        half = t_quantile(found.blocks, 0.95) * np.sqrt(np.diag(found.covariance))
        inside.append(np.abs(found.base - true) <= half)
        off.append(np.linalg.norm(found.base - true) / np.linalg.norm(true))
    per_parameter = 100 * np.mean(inside, axis=0)
    return {
        "draws": draws,
        "parameters": len(per_parameter),
        "coverage_percent": float(per_parameter.mean()),
        "lowest_percent": float(per_parameter.min()),
        "highest_percent": float(per_parameter.max()),
        "parameter_error_percent": 100 * float(np.median(off)),
    }
