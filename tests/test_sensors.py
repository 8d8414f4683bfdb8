"""Sensors: each fault alone, against its own definition."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest

import physident as pid
from physident.effects.friction import ViscousFriction
from physident.effects.inertia import RigidBody, RotorInertia
from physident.simulation.integrate import integrate
from physident.simulation.sensors import Sensors, Warming, load_sensors
from physident.simulation.simulate import Simulation, simulate

GAINS = np.array([0.125, 0.125, 0.125, 0.0922, 0.0922, 0.0922]) * 101  # K_T G of the UR5 [N m/A]


@pytest.fixture(scope="module")
def model() -> pid.Model:
    robot = pid.load_robot("ur5")
    effects = (RigidBody(), RotorInertia(), ViscousFriction())
    return pid.Model(robot, effects, np.concatenate([robot.nominal, np.full(6, 0.3), np.full(6, 3.0)]))


@pytest.fixture(scope="module")
def motion(model) -> pid.Trajectory:
    return pid.random_trajectory(model.robot, seed=0, duration=10.0)


@pytest.fixture(scope="module")
def states(model, motion) -> pid.Signals:
    return integrate(model, motion, step=0.002)


@pytest.fixture(scope="module")
def read(model, motion, states):
    """Reads the one true motion through any sensors."""

    def recording(seed: int = 0, robot: pid.Robot | None = None, **settings: Any) -> pid.Recording:
        sensors = Sensors(**settings)
        arm = replace(model, robot=robot or model.robot)
        table = sensors.read(arm.robot, states, motion.duration, np.random.default_rng(seed))
        return Simulation(arm, motion, sensors=sensors).recording(table)

    return recording


@pytest.fixture(scope="module")
def truth(read) -> pid.Recording:
    return read()


def test_ideal_sensors_show_the_truth(states, truth):
    assert truth.dq is not None
    for seen, true in ((truth.q, states.q), (truth.dq, states.v), (truth.effort, states.torque)):
        assert true is not None
        np.testing.assert_array_equal(seen, true[::4])
    np.testing.assert_allclose(truth.time, np.arange(1251) / 125, atol=1e-12)


def test_encoder_counts(read, truth):
    step = 2 * np.pi / 4096
    coarse = (step, step, step, 2 * step, 2 * step, 2 * step)
    seen = read(encoder_step=coarse, velocity="encoder")
    counts = seen.q / coarse
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-9)
    assert (np.abs(seen.q - truth.q) <= np.array(coarse) / 2 + 1e-12).all()
    assert seen.dq is not None
    np.testing.assert_allclose(np.cumsum(seen.dq / 125, axis=0), seen.q - seen.q[0], atol=1e-9)
    # the difference of two counts over a period cannot be finer than a count over that period
    assert np.unique(np.round(seen.dq[:, 0], 9)).size < 2 * np.abs(seen.dq[:, 0]).max() / (step * 125) + 3


def test_no_velocity(read):
    assert read(velocity="none").dq is None


def test_noise_of_tachometer_and_torque(read, truth):
    levels = np.array([0.5, 1.0, 0.5, 0.1, 0.2, 0.3])
    seen = read(1, velocity_noise=0.02, torque_noise=tuple(levels))
    assert seen.dq is not None
    assert truth.dq is not None
    for noise, level in ((seen.dq - truth.dq, 0.02), (seen.effort - truth.effort, levels)):
        # five standard errors of a standard deviation from 1251 samples
        np.testing.assert_allclose(noise.std(axis=0), level * np.ones(6), rtol=5 / np.sqrt(2 * 1251))
        lag = (noise[1:] * noise[:-1]).mean(axis=0) / noise.var(axis=0)
        assert np.abs(lag).max() < 5 / np.sqrt(1251)  # white
    np.testing.assert_array_equal(seen.q, truth.q)


def test_current_with_noise_on_current_and_torque_constant(read, truth):
    quiet = read(effort="current")
    assert quiet.effort_kind == "current"
    np.testing.assert_allclose(quiet.effort * GAINS, truth.effort, atol=1e-9)
    np.testing.assert_allclose(quiet.torque, truth.effort, atol=1e-9)
    for effort in ("current", "torque"):
        white = read(2, effort=effort, current_noise=0.05)
        np.testing.assert_allclose((white.torque - truth.effort).std(axis=0), 0.05 * GAINS, rtol=0.1)
        spread = read(2, effort=effort, torque_constant_noise=0.03)
        large = np.abs(truth.effort) > 1.0
        assert ((spread.torque - truth.effort)[large] / truth.effort[large]).std() == pytest.approx(0.03, rel=0.1)
    other = read(effort="current", drive_gains=(10.0,) * 6)
    np.testing.assert_allclose(other.effort * 10, truth.effort, atol=1e-9)


def test_currents_need_drives(model, motion):
    bare = replace(model, robot=replace(model.robot, drives=None))
    for sensors in (Sensors(effort="current"), Sensors(current_noise=0.1)):
        with pytest.raises(pid.InputError, match="drive_gains"):
            simulate(bare, motion, sensors=sensors)


def test_effort_arrives_late(read, truth):
    late = read(delay=3 / 125)
    np.testing.assert_allclose(late.effort[3:], truth.effort[:-3], atol=1e-9)
    np.testing.assert_array_equal(late.q, truth.q)
    between = read(delay=0.0047)
    expected = [np.interp(truth.time - 0.0047, truth.time, x) for x in truth.effort.T]
    np.testing.assert_allclose(between.effort[1:], np.array(expected).T[1:], atol=0.1)


def test_rate_and_jitter(read):
    fast = read(rate=500.0)
    slow = read(rate=100.0)
    assert len(fast.time) == 5001
    np.testing.assert_allclose(slow.q, fast.q[::5], atol=1e-8)
    shaken = read(3, rate=100.0, jitter=5e-4)
    assert (np.diff(shaken.time) > 0).all()
    assert np.std(shaken.time - slow.time) == pytest.approx(5e-4, rel=0.1)
    # the clock is honest: what it shows was there at that time
    expected = np.array([np.interp(shaken.time, fast.time, x) for x in fast.q.T]).T
    np.testing.assert_allclose(shaken.q, expected, atol=1e-5)


def test_dropped_and_corrupted_rows(read, truth):
    fewer = read(4, dropped=0.1)
    assert 60 < 1251 - len(fewer.time) < 190
    assert np.isin(fewer.time, truth.time).all()
    torn = read(4, corrupted=0.02)
    assert 10 < len(torn.rejected) < 45
    assert all(row.reason for row in torn.rejected)
    # what is left of position is the truth, but for a value near zero that fell to zero unseen
    kept = np.isin(truth.time, torn.time)
    assert np.abs(torn.q - truth.q[kept]).max() < 0.2


@dataclass(frozen=True)
class ColdFriction(pid.Effect):
    name: ClassVar[str] = "cold_friction"
    unit: ClassVar[str] = "N m s/(rad K)"

    def values(self, robot, signals):
        assert signals.temperature is not None
        return ((40.0 - signals.temperature) * signals.v).T[self.active(robot)]


def test_temperature_is_recorded_and_felt(model, motion, truth):
    warming = Warming(start=20.0, rise=15.0, time_constant=4.0)
    cold = pid.Model(model.robot, (*model.effects, ColdFriction()), np.concatenate([model.theta, np.full(6, 0.3)]))
    seen = simulate(cold, motion, sensors=Sensors(temperature=warming))
    assert seen.temperature is not None
    expected = 20 + 15 * (1 - np.exp(-seen.time / 4.0))
    np.testing.assert_allclose(seen.temperature, np.tile(expected[:, None], (1, 6)))
    states = integrate(cold, motion, temperature=lambda time: warming.at(time, 6))
    np.testing.assert_allclose(seen.effort, cold.torque(states)[::2], atol=1e-5)
    assert np.abs(seen.effort - truth.effort).max() > 1.0


def test_settings_round_trip(tmp_path):
    sensors = Sensors(rate=250.0, encoder_step=(1e-4,) * 6, effort="current", temperature=Warming(20.0), dropped=0.01)
    sensors.save(tmp_path / "sensors.json")
    assert load_sensors(tmp_path / "sensors.json") == sensors


@pytest.mark.parametrize(
    "settings",
    [
        {"rate": 0.0},
        {"rate": "fast"},
        {"rate": [100.0, 200.0]},
        {"jitter": -1e-3},
        {"delay": None},
        {"encoder_step": [1e-3, -1e-3]},
        {"velocity": "radar"},
        {"effort": "voltage"},
        {"dropped": 0.9},
        {"corrupted": True},
        {"torque_noise": float("nan")},
        {"torque_noise": [1, "x"]},
        {"temperature": 20.0},
        {"temperature": {"start": 20, "time_constant": 0}},
        {"temperature": {"begin": 20}},
        {"colour": "red"},
    ],
)
def test_bad_settings_are_one_clear_line(settings: dict[str, Any], tmp_path):
    file = tmp_path / "sensors.json"
    file.write_text(json.dumps({"schema": "physident.sensors/1", **settings}))
    with pytest.raises(pid.InputError) as caught:
        load_sensors(file)
    assert next(iter(settings)) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_settings_that_do_not_fit_the_arm(read):
    misfits: tuple[dict[str, Any], ...] = (
        {"encoder_step": (1e-3,) * 5},
        {"drive_gains": (1.0,) * 5},
        {"torque_noise": (1.0,) * 7},
    )
    for settings in misfits:
        with pytest.raises(pid.InputError, match="expected"):
            read(effort="current", **settings)
