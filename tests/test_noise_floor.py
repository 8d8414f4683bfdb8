"""The noise floor: what repeats of a motion say about noise, and silence where nothing repeats."""

from __future__ import annotations

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


def test_motions_that_do_not_repeat_have_no_floor(tmp_path: Path) -> None:
    assert floor(tmp_path, [multisine(5), multisine(7)], (1, 2)) is None
