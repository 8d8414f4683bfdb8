"""Models A-D, each identified the thesis' way and ours, and judged on a second trajectory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import physident as pid
from studies.thesis import ours
from studies.thesis.halves import HALVES
from studies.thesis.published import COULOMB
from studies.thesis.reference import Run, half_run, run
from studies.thesis.scores import relative, rms
from studies.thesis.thesis_way import identify_half, identify_whole_by_halves, predict_halves

Array = NDArray[np.float64]
TRAIN_SEED, VALIDATION_SEED = 1, 2


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
    """Errors, the noise floor, friction and the base parameters' errors, as JSON can hold them."""
    clean = found.validation
    data: dict[str, Any] = {
        "error_thesis_way": found.error("thesis, halves").tolist(),
        "error_thesis_way_whole_arm": found.error("thesis, whole arm").tolist(),
        "error_noise_alone": relative(clean.torque, clean.true).tolist(),
        "rms_noise": rms(clean.torque - clean.true).tolist(),
        "rms_thesis_way": found.rms("thesis, halves").tolist(),
        "rms_thesis_way_whole_arm": found.rms("thesis, whole arm").tolist(),
        "ours": {},
    }
    for way, one in found.estimates.items():
        if one.estimate is None:
            data["ours"][way] = {"not_solved": one.why}
            continue
        e = one.estimate
        true = e.base.values(ours.truth(robot, found.model))
        coulomb = e.model.parameters("coulomb_friction")
        data["ours"][way] = {
            "error": found.error(way).tolist(),
            "rms": found.rms(way).tolist(),
            "friction": coulomb.tolist(),
            "friction_off_percent": (100 * (coulomb / COULOMB - 1)).tolist(),
            "base_parameters_off_relative": float(np.abs(e.base.values(e.theta) - true).max() / np.abs(true).max()),
            "base_parameters_off_norm": float(np.linalg.norm(e.base.values(e.theta) - true) / np.linalg.norm(true)),
        }
    return data
