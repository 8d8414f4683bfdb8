"""Draw what a joint's friction does where its speed changes sign, for each kind of friction in both plants."""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: small matrices, and a machine that is shared

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray

mpl.use("Agg")
import matplotlib.pyplot as plt

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from physident.graphics.style import MEASURED, RESIDUAL, SETTINGS
from tests.plant.open_plant import PinocchioPlant
from tests.plant_mujoco import MujocoPlant
from tests.serial_arms import Kind, Sway, make_arm
from tests.truth import ArmTruth, Plant

Array = NDArray[np.float64]
PLANTS: tuple[tuple[Plant, str, dict[str, Any]], ...] = (
    (PinocchioPlant(), MEASURED, {"lw": 1.6}),
    (MujocoPlant(), RESIDUAL, {"lw": 1.3, "ls": (0, (4, 2))}),
)
JOINT = 0  # the first joint of a SCARA, which no gravity loads
COULOMB, BREAKAWAY = 2.0, 2.6  # N m
COLUMNS: tuple[tuple[str, Kind, float], ...] = (
    ("dry: the joint sticks", "dry", 0.001),
    ("bristle: LuGre", "bristle", 0.001),
    ("smooth, 0.001 rad/s wide", "smooth", 0.001),
    ("smooth, 0.05 rad/s wide", "smooth", 0.05),
)
WINDOW = (-0.08, 0.16)  # s about the reversal


def arm_of(kind: Kind, width: float) -> ArmTruth:
    """A SCARA with one kind of friction, under slack control."""
    arm = make_arm("scara", kind, coulomb=COULOMB, breakaway=BREAKAWAY, bandwidth=30.0)
    rows = {"width": width, "bristle_stiffness": 1000.0, "bristle_damping": 2.0}
    return replace(arm, friction=replace(arm.friction, **{key: np.full(4, value) for key, value in rows.items()}))


def reversal(plant: Plant, arm: ArmTruth) -> tuple[Array, Array, Array]:
    """Time [s] about one planned reversal, and there the joint's speed [rad/s] and friction [N m]."""
    plan = Sway(np.array([0.16, 0.12, 0.02, 0.1]), duration=5.0)
    run = plant.simulate(arm, plan)
    none = np.zeros(4)
    bare = replace(arm, friction=replace(arm.friction, kind="smooth", coulomb=none, breakaway=none, viscous=none))
    friction = run.torque - plant.torque_along(bare, run)
    planned = plan.states(run.time)[1][:, JOINT]
    inner = np.flatnonzero((planned[:-1] * planned[1:] < 0) & (np.abs(np.diff(planned)) > 1e-6))
    time = run.time - run.time[inner[0]]
    rows = (time >= WINDOW[0]) & (time <= WINDOW[1])
    return time[rows], run.v[rows, JOINT], friction[rows, JOINT]


def main() -> None:
    mpl.rcParams.update(SETTINGS)
    figure, axes = plt.subplots(2, len(COLUMNS), figsize=(11, 4.8), sharex=True, sharey="row", layout="constrained")
    for (title, kind, width), (speed, torque) in zip(COLUMNS, axes.T, strict=True):
        for plant, colour, style in PLANTS:
            time, v, friction = reversal(plant, arm_of(kind, width))
            speed.plot(1e3 * time, v, color=colour, label=plant.name, **style)
            torque.plot(1e3 * time, friction, color=colour, **style)
        speed.set_title(title)
        torque.set_xlabel("time since the planned reversal [ms]")
    axes[0, 0].set_ylabel("velocity [rad/s]")
    axes[1, 0].set_ylabel("friction [N m]")
    axes[0, 0].legend(loc="lower left")
    figure.savefig(Path(__file__).with_name("reversal.png"), dpi=110)


if __name__ == "__main__":
    main()
