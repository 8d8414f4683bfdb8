"""The demo: two generated recordings of the built-in UR5, so that the way from recordings to a model can be seen."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from physident.estimation.estimate import Estimate
from physident.estimation.identify import identify
from physident.excitation.trajectory import random_trajectory
from physident.files import write_with
from physident.recording import load_recordings
from physident.robot import Robot, load_robot
from physident.validation import Score, predictions, validate

Array = NDArray[np.float64]
RATE = 125.0  # Hz, the UR5's own
ENCODER_STEP = 2 * np.pi / 2**17  # rad
VELOCITY_STEP = 1e-3  # rad/s
TORQUE_NOISE = np.array([1.5, 2.0, 1.2, 0.3, 0.3, 0.25])  # N m, white at the recording's rate
COULOMB = np.array([7.7, 8.3, 7.8, 1.4, 2.0, 2.1])  # N m
VISCOUS = np.array([9.0, 9.0, 6.0, 2.5, 2.0, 1.5])  # N m s/rad
ROTOR = np.array([1.2, 1.2, 0.9, 0.21, 0.21, 0.21])  # kg m^2


@dataclass(frozen=True)
class Demo:
    """What the demo made: an estimate, its score on the recording that was not fitted, and the files written."""

    estimate: Estimate
    score: Score
    files: tuple[Path, ...]

    def __repr__(self) -> str:
        e = self.estimate
        truth = {"rotor_inertia": ROTOR, "viscous_friction": VISCOUS, "coulomb_friction": COULOMB}
        train, test = self.estimate.sources[0].path, self.score.recordings[0]
        rows = [
            f"A generated UR5, identified on {train}, judged on {test}, which was not fitted.",
            "",
            repr(e),
        ]
        rows += ["", "hidden in the data, and found:", "effect              joint     true    found   ±      unit"]
        for effect, values in truth.items():
            for i, (c, found, std) in enumerate(zip(e.model.columns, e.theta, e.standard_errors, strict=True)):
                if c.effect == effect and not np.isnan(e.standard_errors[i]) and c.joint in (1, 3, 6):
                    rows.append(
                        f"{effect:<18}  {c.joint:5d}  {values[c.joint - 1]:7.3f}  {found:7.3f}  {std:5.3f}  {c.unit}"
                    )
        return "\n".join([*rows, "", repr(self.score), "", "open: " + ", ".join(map(str, self.files))])


def run_demo(folder: str | Path = "demo", seed: int = 0) -> Demo:
    """Generate two UR5 recordings, identify on one, validate on the other; writes recordings, model and figure."""
    from physident.view.plots import plot_predictions

    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    robot = load_robot("ur5")
    for name, offset in (("train", 0), ("test", 1)):
        _write(folder / f"{name}.csv", *_measure(robot, 2 * seed + offset))
    train, test = load_recordings([folder / "train.csv", folder / "test.csv"])
    estimate = identify(robot, [train])
    estimate.save(folder / "model.json")
    score = validate(estimate, [test])
    plot_predictions(predictions(estimate, [test]), robot.joint_names, folder / "validation.png")
    return Demo(estimate, score, tuple(folder / name for name in ("validation.png", "model.json")))


def _measure(robot: Robot, seed: int) -> tuple[Array, Array, Array, Array]:
    """Time, position, velocity and torque as an arm would record them along a random Fourier motion."""
    import pinocchio

    time, q, v, a = random_trajectory(robot, seed=seed, harmonics=5, base_frequency=0.1, duration=20.0).sample(RATE)
    model = robot.pinocchio
    data = model.createData()
    torque = np.array([pinocchio.rnea(model, data, *state).copy() for state in zip(q, v, a, strict=True)])
    torque += ROTOR * a + VISCOUS * v + COULOMB * np.tanh(v / 0.01)
    rng = np.random.default_rng([seed, 1])
    torque += TORQUE_NOISE * rng.standard_normal(torque.shape)
    return time, _quantised(q, ENCODER_STEP), _quantised(v, VELOCITY_STEP), torque


def _quantised(values: Array, step: float) -> Array:
    return step * np.round(values / step)


def _write(path: Path, time: Array, q: Array, dq: Array, tau: Array) -> None:
    names = ["time", *(f"{kind}_{j}" for kind in ("q", "dq", "tau") for j in range(1, q.shape[1] + 1))]
    rows = np.column_stack([time, q, dq, tau])

    def write(temporary: Path) -> None:
        with temporary.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow(names)
            writer.writerows([f"{x:.7g}" for x in row] for row in rows)

    write_with(path, write)
