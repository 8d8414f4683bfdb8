"""Do stated intervals hold the truth, and how far off are parameters, over many draws of the noise?"""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any

import numpy as np

import physident as pid
from studies.thesis import ours
from physident.estimation.identify import estimate_from
from studies.thesis.currents import measured_torque
from studies.thesis.reference import run
from studies.thesis.scores import FILTER, filtered

DRAWS = 100


def coverage(model: str, robot: pid.Robot, motion: pid.Trajectory, draws: int = DRAWS) -> dict[str, Any]:
    """Share of draws and base parameters whose 95 % interval holds the truth, and the base parameters' relative error."""
    clean = run(model, motion, robot)
    regressor = ours.regressor(robot, clean)
    inside, off = [], []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pid.PhysidentWarning)  # few independent samples: that is what is measured
        for seed in range(draws):
            noisy = filtered(measured_torque(clean.true, np.random.default_rng([seed, 9])))
            e = estimate_from(robot, ours.effects(), replace(regressor, torque=noisy), [], "wls", FILTER)
            true, ends = e.base.values(ours.truth(robot, model)), e.intervals()
            inside.append((ends[:, 0] <= true) & (true <= ends[:, 1]))
            off.append(np.linalg.norm(e.base.values(e.theta) - true) / np.linalg.norm(true))
    per_parameter = 100 * np.mean(inside, axis=0)
    return {
        "draws": draws,
        "parameters": len(per_parameter),
        "coverage_percent": float(per_parameter.mean()),
        "lowest_percent": float(per_parameter.min()),
        "highest_percent": float(per_parameter.max()),
        "parameter_error_percent": 100 * float(np.median(off)),
    }
