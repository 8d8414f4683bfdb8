"""What it costs to leave the coupling of the halves out: eq. 4.3 against eq. 4.2."""

from __future__ import annotations

from typing import Any

import numpy as np

import physident as pid
from physident.effects.catalogue import make_effects
from physident.identifiability.base_parameters import find_base_parameters
from studies.thesis.halves import HALVES, half
from studies.thesis.reference import run
from studies.thesis.scores import relative, rms
from studies.thesis.thesis_way import HalfModel, identify_whole_by_halves, predict_halves


def true_halves() -> list[HalfModel]:
    """The halves with their true base parameters."""
    models = []
    for name in HALVES:
        base = find_base_parameters(half(name), make_effects(["rigid_body"]))
        models.append(HalfModel(name, base, base.values(half(name).nominal)))
    return models


def cost(robot: pid.Robot, train: pid.Trajectory, validation: pid.Trajectory) -> dict[str, Any]:
    """Error per joint on the validation trajectory of model A: true parameters with the blocks left out, parameters
    fitted without the blocks, and the same fit's error on its own trajectory."""
    fitted, own = identify_whole_by_halves(run("a", train, robot)), run("a", train, robot)
    judged = run("a", validation, robot)
    exact = predict_halves(true_halves(), judged)
    found = predict_halves(fitted, judged)
    return {
        "true_parameters": {
            "error": relative(judged.torque, exact).tolist(),
            "rms": rms(judged.torque - exact).tolist(),
        },
        "fitted": {"error": relative(judged.torque, found).tolist(), "rms": rms(judged.torque - found).tolist()},
        "fitted_on_its_own_trajectory": relative(own.torque, predict_halves(fitted, own)).tolist(),
        "rms_torque": np.asarray(rms(judged.torque)).tolist(),
    }
