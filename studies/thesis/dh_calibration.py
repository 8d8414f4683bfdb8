"""A robot whose DH parameters are slightly off: the torque error of uncalibrated geometry, before and after a fit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.dynamics.regressor import build_regressor
from physident.estimation.regressor_fit import estimate_from
from physident.robots.dh import urdf_from_table
from studies.thesis.halves import ur5_table
from studies.thesis.reference import Run, run
from studies.thesis.scores import FILTER, relative, rms

Array = NDArray[np.float64]
LENGTH = 5e-4  # m: standard deviation of the offsets of d and a
ANGLE = 0.1  # degrees: of alpha and of the joint's zero


def calibrated(seed: int = 0) -> pid.Robot:
    """The UR5 with small calibration offsets in its DH table, its links the same in their DH frames.

    Table 2.7's own numbers are of no arm (kilometres that cancel between parallel axes): these are drawn.
    """
    rng, table = np.random.default_rng(seed), ur5_table()
    for joint in table["joints"]:
        d, a = LENGTH * rng.standard_normal(2)
        alpha, offset = ANGLE * rng.standard_normal(2)
        joint["calibration"] = {"d": d, "a": a, "alpha_deg": alpha, "offset_deg": offset}
    limit = tuple(joint["acceleration_limit"] for joint in table["joints"])
    return pid.Robot(name="ur5, calibrated", urdf=urdf_from_table(table), acceleration_limit=limit)


def cost(robot: pid.Robot, train: pid.Trajectory, validation: pid.Trajectory) -> dict[str, Any]:
    """Error per joint on the validation trajectory when the geometry is the uncalibrated one: with the true link
    parameters, and with those that fit best (model A, noise-free)."""
    true = calibrated()
    judged = run("a", validation, true)
    links = pid.Model.nominal(robot, ["rigid_body"])
    fitted = _fit(robot, run("a", train, true))
    found = {"true_links": links.torque(judged.signals()), "fitted_links": fitted.torque(judged.signals())}
    return {
        "length_std_m": LENGTH,
        "angle_std_deg": ANGLE,
        **{
            name: {"error": relative(judged.torque, t).tolist(), "rms": rms(judged.torque - t).tolist()}
            for name, t in found.items()
        },
    }


def _fit(robot: pid.Robot, train: Run) -> pid.Model:
    effects = pid.make_effects(["rigid_body"])
    regressor = build_regressor(robot, effects, [train.signals()], FILTER, moving_only=False)
    return estimate_from(robot, effects, regressor, [], "wls", FILTER).model
