"""How often do 95 % intervals hold the truth on an arm that sticks: in motion, and with rests for nine tenths of the time?"""

from __future__ import annotations

import json
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: small matrices, and a machine that is shared

import sys
import warnings
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.estimation.uncertainty import t_quantile
from studies.dry_friction.arm import CACHE
from studies.open_world.motions import Moves, fourier
from studies.open_world.sensors import Sensors
from studies.open_world.taken import take
from tests.plant_mujoco import MujocoPlant
from tests.serial_arms import make_arm
from tests.truth import ArmTruth, Motion

Array = NDArray[np.float64]
DURATION = 60.0  # s of a recording
MOVING = 0.1  # share of the time in which a joint of the second kind of motion moves
EXPERIMENTS = 40  # of two recordings each
KINDS = ("in motion", "at rest for 90 %")
SENSORS = Sensors(rate=125.0, encoder_step=5e-5, velocity_noise=1e-3, torque_noise=(0.1, 0.1))


def coverage(kind: str, method: str, experiments: int = EXPERIMENTS) -> dict[str, list[float]]:
    """Share [%] of the experiments whose interval holds the truth, and how wide the middle interval is, for each parameter
    that the data determine."""
    hits, widths = [], []
    names: list[str] = []
    for number in range(experiments):
        estimate, truth = experiment(kind, method, number)
        std = np.sqrt(np.diag(estimate.covariance))
        half = t_quantile(estimate.blocks) * std
        error = np.abs(estimate.base.values(estimate.theta) - estimate.base.values(truth))
        names = [column.name for column in np.array(estimate.base.columns)[estimate.base.independent]]
        hits.append(error <= half)
        widths.append(half)
    share, middle = 100 * np.mean(hits, axis=0), np.median(widths, axis=0)
    return {name: [float(s), float(m)] for name, s, m in zip(names, share, middle, strict=True)}


def experiment(kind: str, method: str, number: int) -> tuple[pid.Estimate, Array]:
    """An estimate from two recordings, and the true parameters of its model."""
    arm = make_arm("two", "dry", breakaway=2.0, coulomb=2.0)
    folder = CACHE / "coverage" / kind.replace(" ", "_").replace("%", "")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "arm.urdf").write_text(arm.urdf)
    robot = pid.load_robot(folder / "arm.urdf")
    recordings = []
    for run in range(2):
        seed = 2 * number + run
        motion = _motion(kind, arm, np.random.default_rng([17, seed]))
        recordings.append(
            take(folder / f"{seed}", MujocoPlant(), arm, motion, SENSORS, seed, 0.0, known=False).recording
        )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # few independent samples are what this study is about
        estimate = pid.identify(robot, recordings, method=method)
    truth = {
        "rigid_body": arm.links.ravel(), "rotor_inertia": arm.rotor_inertia, "viscous_friction": arm.friction.viscous,
        "coulomb_friction": arm.friction.coulomb, "torque_offset": arm.torque_offset,
    }  # fmt: skip
    return estimate, np.concatenate([truth[effect.name] for effect in estimate.model.effects])


def _motion(kind: str, arm: ArmTruth, rng: np.random.Generator) -> Motion:
    if kind == KINDS[0]:
        return fourier(arm, rng, DURATION, 0.8)
    here, now = rng.uniform(arm.lower, arm.upper), 0.4
    start, moves = here.copy(), []
    while now < DURATION - 2.0:
        goal, lasts = rng.uniform(arm.lower, arm.upper), float(rng.uniform(0.8, 1.6))
        moves += [(j, now, lasts, way) for j, way in enumerate(goal - here)]
        now, here = now + lasts / MOVING, goal
    joint, begin, lasts_all, way = zip(*moves, strict=True)
    return Moves(DURATION, start, np.array(joint), np.array(begin), np.array(lasts_all), np.array(way), "pauses")


def table(results: dict[str, dict[str, list[float]]]) -> list[str]:
    """Rows of a printed table."""
    rows = ["share of 95 % intervals that hold the truth [%] (half their width), arm of two joints that sticks"]
    for name, values in results.items():
        mean = np.mean([share for share, _ in values.values()])
        rows += [
            "",
            f"{name}: {mean:.1f} % over all parameters",
            *(f"  {key:<28}{share:6.0f}  ({width:.3g})" for key, (share, width) in values.items()),
        ]
    return rows


def main(experiments: int) -> None:
    """Print the table, and keep it where it is of all experiments."""
    results = {f"{k}, {m}": coverage(k, m, experiments) for k in KINDS for m in ("wls", "physical")}
    print("\n".join(table(results)))
    if experiments == EXPERIMENTS:
        text = json.dumps({"experiments": experiments, "coverage": results}, indent=1) + "\n"
        Path(__file__).with_name("coverage.json").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else EXPERIMENTS)
