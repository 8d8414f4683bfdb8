"""Models A-D, each identified the thesis' way and ours, and judged on a second trajectory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.dynamics.dry_sign import SHARPEST
from studies.thesis import ours
from studies.thesis.halves import HALVES
from studies.thesis.published import COULOMB
from studies.thesis.reference import FRICTION, Run, half_run, run
from studies.thesis.scores import relative, rms
from studies.thesis.thesis_way import identify_half, identify_whole_by_halves, predict_halves

Array = NDArray[np.float64]
TRAIN_SEED, VALIDATION_SEED = 1, 2
NOTHING = 1e-9  # of the largest base parameter: below it a true value is zero, and no relative error exists


@dataclass(frozen=True, eq=False)
class Compared:
    """One reference model on the validation trajectory: the run, the torques of each way (N, 6) by name - in the first
    the reference is two robots of three joints, ``halves`` - and what was found of friction."""

    model: str
    halves: Run
    validation: Run
    predicted: Mapping[str, Array]
    estimates: Mapping[str, ours.Found]

    def measured(self, way: str) -> Run:
        """The run that a way is judged on."""
        return self.halves if way == "thesis, halves" else self.validation

    def error(self, way: str) -> Array:
        """Relative error (6,) [%] of one way against the measured torque."""
        return relative(self.measured(way).torque, self.predicted[way])

    def rms(self, way: str) -> Array:
        """RMS difference (6,) [N m] of one way to the torque without noise."""
        return rms(self.measured(way).true - self.predicted[way])


def compare(model: str, robot: pid.Robot, motions: Mapping[str, pid.Trajectory]) -> Compared:
    """Both ways on one reference model; ``motions`` are "thesis", "designed" and "validation"."""
    train = {name: run(model, motions[name], robot, TRAIN_SEED) for name in ("thesis", "designed")}
    judged = run(model, motions["validation"], robot, VALIDATION_SEED)
    predicted = {
        "thesis, halves": _halves_alone(model, motions),
        "thesis, whole arm": predict_halves(identify_whole_by_halves(train["thesis"]), judged),
    }
    estimates = {
        f"ours, {method}, {motion} trajectory": ours.attempt(robot, train[motion], how)
        for motion in train
        for method, how in (("wls", "wls"), ("physical", ours.PHYSICAL))
    }
    for way, found in estimates.items():
        if found.estimate is not None:
            predicted[way] = found.estimate.model.torque(judged.signals())
    return Compared(model, _joined(model, motions["validation"]), judged, predicted, estimates)


def best(found: Compared) -> str:
    """Our way on the designed trajectory: physical, or weighted least squares where the physical fit was not solved."""
    physical, plain = (f"ours, {method}, designed trajectory" for method in ("physical", "wls"))
    return physical if found.estimates[physical].estimate is not None else plain


def _halves_alone(model: str, motions: Mapping[str, pid.Trajectory]) -> Array:
    """Each half identified and predicted on a reference of its own, side by side (N, 6)."""
    sides = []
    for name in HALVES:
        found = identify_half(name, half_run(model, motions["thesis"], name, TRAIN_SEED))
        judged = half_run(model, motions["validation"], name, VALIDATION_SEED)
        sides.append(found.torque(judged.q, judged.v, judged.a))
    return np.column_stack(sides)


def _joined(model: str, motion: pid.Trajectory) -> Run:
    """The two halves' validation runs side by side."""
    parts = [half_run(model, motion, name, VALIDATION_SEED) for name in HALVES]
    columns = {x: np.column_stack([getattr(p, x) for p in parts]) for x in ("q", "v", "a", "true", "torque")}
    return Run(parts[0].time, **columns)


def results(found: Compared, robot: pid.Robot) -> dict[str, Any]:
    """Errors [%, N m], the noise floor, friction and the base parameters' errors, as JSON can hold them."""
    clean, way = found.validation, best(found)
    each = {name: _one(found, name, one, robot) for name, one in found.estimates.items()}
    return {
        "ours_is": way,
        "error_thesis_way": found.error("thesis, halves").tolist(),
        "error_thesis_way_whole_arm": found.error("thesis, whole arm").tolist(),
        "error_ours": each[way]["error"],
        "error_noise_alone": relative(clean.torque, clean.true).tolist(),
        "rms_noise": rms(clean.torque - clean.true).tolist(),
        "rms_thesis_way": found.rms("thesis, halves").tolist(),
        "rms_thesis_way_whole_arm": found.rms("thesis, whole arm").tolist(),
        "error_of_truth_with_default_sign": relative(
            clean.torque, ours.true_torque(robot, found.model, clean, SHARPEST)
        ).tolist(),
        "friction": each[way]["friction"],
        "friction_off_percent": each[way]["friction_off_percent"],
        "base_parameters_off_relative": each[way]["base_parameters_off_relative"],
        "ours": each,
    }


def _one(found: Compared, way: str, one: ours.Found, robot: pid.Robot) -> dict[str, Any]:
    if one.estimate is None:
        return {"not_solved": one.why}
    e = one.estimate
    true, values = e.base.values(ours.truth(robot, found.model)), e.base.values(e.theta)
    known = np.abs(true) > NOTHING * np.abs(true).max()
    coulomb = e.model.parameters("coulomb_friction")
    off = 100 * (coulomb / COULOMB - 1) if FRICTION[found.model] else None
    return {
        "error": found.error(way).tolist(),
        "rms": found.rms(way).tolist(),
        "friction": coulomb.tolist(),
        "friction_off_percent": None if off is None else off.tolist(),
        "base_parameters_off_relative": float(np.max(np.abs(values - true)[known] / np.abs(true)[known])),
        "base_parameters_that_are_zero_off": float(np.max(np.abs(values - true)[~known])),
    }
