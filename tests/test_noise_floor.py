"""The noise floor: what repeats of a motion say about noise, and silence where nothing repeats."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.statistics.noise_floor import noise_floor
from physident.dynamics.regressor import build_regressor
from physident.effects.catalogue import DEFAULT_EFFECTS
from physident.estimation.identify import prepare_all
from tests.made_once import STEP, made_once
from tests.plant import Arm, Sensors, multisine, record

FILTER = pid.Filter(5.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("floor")


def taken(folder: Path, motion: int, noise: int, larger: float = 1.0) -> pid.Recording:
    """A recording of a motion with some noise; each is made once."""
    plan = multisine(motion)
    larger_plan = replace(plan, amplitude=larger * plan.amplitude)
    return made_once(folder / f"{motion}_{noise}_{larger}.csv", Arm(), larger_plan, noise)


def floor(recordings: list[pid.Recording]) -> np.ndarray | None:
    robot = pid.load_robot("ur5")
    signals = prepare_all(robot, recordings, FILTER)
    regressor = build_regressor(robot, pid.make_effects(DEFAULT_EFFECTS), signals, FILTER)
    return noise_floor(regressor, signals, regressor.torque, regressor.torque)


def test_a_motion_made_twice_shows_the_instruments_noise_through_the_filter(folder: Path) -> None:
    found = floor([taken(folder, 5, 1), taken(folder, 5, 2)])
    assert found is not None
    sensors = Sensors()
    through = np.array(sensors.torque_noise) * np.linalg.norm(FILTER.taps(sensors.rate))
    np.testing.assert_allclose(found, through, rtol=0.12)  # 400 rows, every second one independent


@pytest.mark.parametrize("rate", [125.6, 250.0])
def test_a_clock_of_another_rate_shows_the_same_noise(folder: Path, rate: float) -> None:
    """Of a clock that jitters, the step in the middle is another one in each recording."""
    sensors = Sensors(rate=rate)
    record(Arm(), multisine(5), sensors, 2, step=STEP).write_csv(folder / "other.csv")
    found = floor([taken(folder, 5, 1), pid.load_recording(folder / "other.csv")])
    assert found is not None
    noise = [np.linalg.norm(FILTER.taps(one.rate)) for one in (Sensors(), sensors)]
    through = np.array(sensors.torque_noise) * np.linalg.norm(noise) / np.sqrt(2)
    np.testing.assert_allclose(found, through, rtol=0.12)


def test_rows_that_are_not_counted_are_no_noise(folder: Path) -> None:
    """Where an effect remembers what was not recorded, rows have neither columns nor torque: they say nothing of noise."""
    signals = prepare_all(pid.load_robot("ur5"), [taken(folder, 5, 1), taken(folder, 5, 2)], FILTER)
    regressor = build_regressor(pid.load_robot("ur5"), pid.make_effects(DEFAULT_EFFECTS), signals, FILTER)
    whole = noise_floor(regressor, signals, regressor.torque, regressor.torque)
    counted, torque = regressor.counted.copy(), regressor.torque.copy()
    some = np.flatnonzero(regressor.recording == 0)
    for rows in (some[:6], some[100:104]):
        counted[rows, 1], torque[rows, 1] = False, 0.0
    without = noise_floor(replace(regressor, counted=counted), signals, torque, torque)
    assert whole is not None
    assert without is not None
    np.testing.assert_allclose(without, whole, rtol=0.1)


def test_motions_that_do_not_repeat_have_no_floor(folder: Path) -> None:
    assert floor([taken(folder, 5, 1), taken(folder, 7, 3)]) is None


def test_a_motion_that_repeats_a_little_larger_shows_hardly_more_than_noise(folder: Path) -> None:
    """No controller repeats a motion exactly; what a few percent more of it need is torque that a model predicts."""
    robot, effects = pid.load_robot("ur5"), pid.make_effects(DEFAULT_EFFECTS)
    recordings = [taken(folder, 5, 1), taken(folder, 5, 2, larger=1.04)]
    signals = prepare_all(robot, recordings, FILTER)
    regressor = build_regressor(robot, effects, signals, FILTER)
    left = regressor.residual(pid.identify(robot, recordings, filter=FILTER).model.theta)
    found = noise_floor(regressor, signals, regressor.torque, left)
    of_torque = noise_floor(regressor, signals, regressor.torque, regressor.torque)
    assert found is not None
    assert of_torque is not None
    sensors = Sensors()
    through = np.array(sensors.torque_noise) * np.linalg.norm(FILTER.taps(sensors.rate))
    assert found[1] < 1.2 * through[1] < 2 * through[1] < of_torque[1]  # the shoulder, which carries the arm
    assert np.all(found <= of_torque)


def test_noise_is_no_more_than_its_share_of_what_is_left_of_all_rows(folder: Path) -> None:
    """Rows of a repeated motion that are harder than the rest say what share of the rest is noise, and quieter ones how large noise is."""
    recordings = [taken(folder, *seeds) for seeds in ((5, 1), (5, 2), (7, 3))]
    signals = prepare_all(pid.load_robot("ur5"), recordings, FILTER)
    regressor = build_regressor(pid.load_robot("ur5"), pid.make_effects(DEFAULT_EFFECTS), signals, FILTER)
    noise = np.random.default_rng(0).standard_normal(regressor.torque.shape)
    repeated = (regressor.recording < 2)[:, None]
    for size in (0.1, 1.0, 10.0):  # of what is left of the motion that does not repeat
        left = np.where(repeated, noise, size * noise)
        found = noise_floor(regressor, signals, left, left)
        everywhere = np.sqrt(np.mean(np.where(repeated, 1.0, size**2)))
        assert found is not None
        np.testing.assert_allclose(found, min(1.0, everywhere), rtol=0.15)
