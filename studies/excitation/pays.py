"""Does a designed motion pay? The same arm identified on it and on random feasible motions of equal length."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.effects.catalogue import DEFAULT_EFFECTS
from physident.excitation.limits.joint_limits import JointLimits, scale_into_limits
from physident.excitation.limits.workspace import Workspace
from physident.excitation.limits.workspace_constraints import workspace_violation
from physident.excitation.motion.series import Series
from studies.designed_plant import Plan
from tests.exact_friction import exact_arm
from tests.plant import Arm, record

Array = NDArray[np.float64]
PERIODS = 3
RECORDINGS = 6
TRIED = 2000  # random motions, of which the first feasible ones are taken


def random_feasible(robot: pid.Robot, workspace: Workspace, count: int, seed: int) -> list[pid.Trajectory]:
    """The first random motions within all limits, each joint as large as its own limits and a random share allow."""
    series, rng = Series(6, 5, 0.15), np.random.default_rng(seed)
    limits, violation = JointLimits.of(robot), workspace_violation(workspace, series)
    found: list[pid.Trajectory] = []
    while len(found) < count:
        shapes = rng.uniform(-1, 1, (TRIED, 6, series.m - 1))
        share = rng.uniform(0.1, 1.0, (TRIED, 1)) * np.ones((1, 6))
        motions = scale_into_limits(limits, series, 64, shapes, share, rng.uniform(size=(TRIED, 6)))
        fits = np.flatnonzero(violation(motions)[:, 0] <= 0)
        found += [series.trajectory(motions[k], PERIODS) for k in fits[: count - len(found)]]
    return found


def errors(robot: pid.Robot, motions: list[pid.Trajectory]) -> Array:
    """RMS error (r,) of each base parameter over recordings of motions, by the default model, weighted least squares."""
    arm, rows = exact_arm(), []
    with TemporaryDirectory() as folder:
        for seed, motion in enumerate(motions):
            path = Path(folder) / f"{seed}.csv"
            record(arm, Plan(motion), seed=seed).write_csv(path)
            estimate = pid.identify(robot, pid.load_recordings(str(path)))
            rows.append(estimate.base.values(estimate.theta) - estimate.base.values(truth(arm)))
    return np.sqrt(np.mean(np.square(rows), axis=0))


def truth(arm: Arm) -> Array:
    """The default model's parameters of the plant."""
    parts = {
        "rigid_body": arm.links.ravel(),
        "rotor_inertia": arm.drives.rotor_inertia,
        "viscous_friction": arm.friction.viscous,
        "coulomb_friction": arm.friction.coulomb,
        "torque_offset": arm.drives.torque_offset,
    }
    return np.concatenate([np.asarray(parts[name], dtype=float) for name in DEFAULT_EFFECTS])


def study(robot: pid.Robot) -> dict[str, Any]:
    """Ratios of errors, random over designed: a median over parameters, for joint limits and for all limits."""
    workspace = Workspace.of(pid.Model.nominal(robot))
    chosen = {
        "joint": [
            pid.random_trajectory(robot, s, base_frequency=0.15, duration=PERIODS / 0.15, scale=1.0)
            for s in range(RECORDINGS)
        ],
        "all": random_feasible(robot, workspace, RECORDINGS, 0),
    }
    result = {}
    for limits, random in chosen.items():
        design = pid.design_trajectory(robot, limits=limits, periods=PERIODS, seed=0)  # pyright: ignore[reportArgumentType]
        ours, theirs = errors(robot, [design.trajectory] * RECORDINGS), errors(robot, random)
        ratio = theirs / ours
        result[limits] = {
            "median_ratio": float(np.median(ratio)),
            "quartiles": np.quantile(ratio, (0.25, 0.75)).tolist(),
            "parameters": len(ratio),
            "better": int((ratio > 1).sum()),
            "condition": design.condition,
        }
    return result
