"""The noise floor: what repeats of a motion say about noise, and silence where nothing repeats."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import physident as pid
from physident.diagnosis.statistics.noise_floor import noise_floor
from physident.dynamics.regressor import build_regressor
from physident.effects.catalogue import DEFAULT_EFFECTS
from physident.estimation.identify import prepare_all
from tests.plant import Arm, Sensors, multisine, record
from tests.plant.motions import Motion

FILTER = pid.Filter(5.0)


def floor(folder: Path, motions: list[Motion], seeds: tuple[int, ...]) -> np.ndarray | None:
    for motion, seed in zip(motions, seeds, strict=True):
        record(Arm(), motion, Sensors(), seed).write_csv(folder / f"{seed}.csv")
    robot = pid.load_robot("ur5")
    signals = prepare_all(robot, pid.load_recordings([folder / f"{seed}.csv" for seed in seeds]), FILTER)
    regressor = build_regressor(robot, pid.make_effects(DEFAULT_EFFECTS), signals, FILTER)
    return noise_floor(regressor, signals, regressor.torque)


def test_a_motion_made_twice_shows_the_instruments_noise_through_the_filter(tmp_path: Path) -> None:
    found = floor(tmp_path, [multisine(5), multisine(5)], (1, 2))
    assert found is not None
    sensors = Sensors()
    through = np.array(sensors.torque_noise) * np.linalg.norm(FILTER.taps(sensors.rate))
    np.testing.assert_allclose(found, through, rtol=0.12)  # 400 rows, every second one independent


def test_rows_that_are_not_counted_are_no_noise(tmp_path: Path) -> None:
    """Where an effect remembers what was not recorded, rows have neither columns nor torque: they say nothing of noise."""
    for seed in (1, 2):
        record(Arm(), multisine(5), Sensors(), seed).write_csv(tmp_path / f"{seed}.csv")
    signals = prepare_all(pid.load_robot("ur5"), pid.load_recordings([tmp_path / "1.csv", tmp_path / "2.csv"]), FILTER)
    regressor = build_regressor(pid.load_robot("ur5"), pid.make_effects(DEFAULT_EFFECTS), signals, FILTER)
    whole = noise_floor(regressor, signals, regressor.torque)
    counted, torque = regressor.counted.copy(), regressor.torque.copy()
    some = np.flatnonzero(regressor.recording == 0)
    for rows in (some[:6], some[100:104]):
        counted[rows, 1], torque[rows, 1] = False, 0.0
    without = noise_floor(replace(regressor, counted=counted), signals, torque)
    assert whole is not None
    assert without is not None
    np.testing.assert_allclose(without, whole, rtol=0.1)


def test_motions_that_do_not_repeat_have_no_floor(tmp_path: Path) -> None:
    assert floor(tmp_path, [multisine(5), multisine(7)], (1, 2)) is None
