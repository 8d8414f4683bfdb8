"""Dry friction near standstill: the weights of rows, the width over which it turns, and rests in a score."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physident as pid
from physident.effects.catalogue import DEFAULT_EFFECTS
from physident.effects.friction import CoulombFriction
from physident.estimation.dry_friction.held_rests import hold_rests
from physident.estimation.dry_friction.rest import rest_rows
from physident.estimation.dry_friction.row_weights import dry_level, rest_weights, spread_rows
from physident.estimation.uncertainty import correlation_rows
from physident.recordings.rests import Rests
from physident.simulation.sensors import Sensors
from physident.simulation.simulate import simulate

RATE = 125.0
FRICTION = 5.0  # N m
Array = np.ndarray
LINK = """<robot name="one"><link name="base"/>
<link name="a"><inertial><origin xyz="0.4 0 0"/><mass value="2"/>
 <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<joint name="one" type="continuous"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/></joint></robot>"""


@pytest.fixture(scope="module")
def turntable(tmp_path_factory: pytest.TempPathFactory) -> pid.Model:
    """One joint about a vertical axis: its torque at rest is friction alone."""
    path = tmp_path_factory.mktemp("one") / "one.urdf"
    path.write_text(LINK)
    robot = pid.load_robot(path)
    model = pid.Model.nominal(robot, ["rigid_body", CoulombFriction(smoothing=0.0)])
    return replace(model, theta=np.append(model.theta[:-1], FRICTION))


def pausing(torque: Array | None = None, rest: float = 4.0) -> pid.Signals:
    """Out for 4 s, at ``rest`` [s], back for 4 s, with the torque of friction alone or another one at rest."""
    time = np.arange(round((8 + rest) * RATE)) / RATE
    speed = np.where(time < 4, 0.5, np.where(time < 4 + rest, 0.0, -0.5))
    resting = speed == 0
    stop = np.array([np.flatnonzero(resting)[-1] + 1])
    rests = Rests(start=np.array([np.argmax(resting)]), stop=stop, before=np.array([0.5]), after=np.array([-0.5]))
    effort = FRICTION * np.sign(speed)
    effort[resting] = 0.0 if torque is None else torque
    q = np.cumsum(speed) / RATE
    return pid.Signals(
        time, q[:, None], speed[:, None], np.zeros((len(time), 1)), effort[:, None], rate=RATE, cutoff=5.0,
        velocity_std=np.array([1e-4]), rests=(rests,),
    )  # fmt: skip


def test_rows_far_from_a_rest_count_fully_and_rows_at_rest_hardly(turntable: pid.Model) -> None:
    filter, signals = pid.Filter(), pausing()
    spread = spread_rows(turntable.robot, turntable.effects, [signals], filter)
    rows = pid.build_regressor(turntable.robot, turntable.effects, [signals], filter)
    noise = 0.05 * np.random.default_rng(0).normal(size=rows.torque.shape)
    assert dry_level(turntable) == pytest.approx(FRICTION)
    unpredicted = noise + FRICTION * spread  # at rest it errs by what the friction may be
    weights = rest_weights(spread, dry_level(turntable), unpredicted, rows)
    far = (np.abs(rows.time - 6.0) > 2.6)[:, None]  # the filter reaches half a second
    np.testing.assert_allclose(weights[far], 1.0, atol=1e-6)
    # in the middle of a rest the sign is anywhere between -1 and 1: its standard deviation is that of a uniform number, which all
    # independent samples of the rest have in common
    middle = int(np.argmin(np.abs(rows.time - 6.0)))
    samples = float((spread > 0.03).sum() / correlation_rows(rows, noise * (spread < 0.03))[0])
    expected = 1 / np.hypot(1, np.sqrt(samples / 3) * FRICTION / 0.05)
    assert weights[middle, 0] == pytest.approx(expected, rel=0.15)
    assert rest_weights(spread, np.zeros(1), noise, rows) == pytest.approx(np.ones_like(noise))


def test_a_long_rest_says_no_more_of_friction_than_a_short_one(turntable: pid.Model) -> None:
    worth = []
    for rest in (2.0, 8.0):
        filter, signals = pid.Filter(), pausing(rest=rest)
        spread = spread_rows(turntable.robot, turntable.effects, [signals], filter)
        rows = pid.build_regressor(turntable.robot, turntable.effects, [signals], filter)
        noise = 0.05 * np.random.default_rng(0).normal(size=rows.torque.shape)
        weights = rest_weights(spread, dry_level(turntable), noise + FRICTION * spread, rows)
        worth.append(float((weights[spread[:, 0] > 0.5] ** 2).sum()))
    assert worth[1] == pytest.approx(worth[0], rel=0.3)  # as independent samples, four times as much


def test_the_rests_that_a_model_predicts_count_row_by_row(turntable: pid.Model) -> None:
    filter, signals = pid.Filter(), pausing()
    spread = spread_rows(turntable.robot, turntable.effects, [signals], filter)
    rows = pid.build_regressor(turntable.robot, turntable.effects, [signals], filter)
    noise = 0.05 * np.random.default_rng(0).normal(size=rows.torque.shape)
    at_rest, known = spread[:, 0] > 0.5, 1 / np.hypot(1, FRICTION / np.sqrt(3) / 0.05)
    for missed, low, high in ((0.0, 0.7, 1.3), (1.0, 0.0, 0.5)):
        weights = rest_weights(spread, dry_level(turntable), noise + missed * FRICTION * spread, rows)
        assert low * known < np.median(weights[at_rest]) < high * known


def test_friction_at_rest_takes_its_best_value_in_a_score(turntable: pid.Model) -> None:
    filter = pid.Filter()
    inside = 3.0  # N m: friction carries it
    for at_rest, outside, left in ((inside, 0.0, 0.0), (-inside, 0.0, 0.0), (2 * FRICTION, 1.0, FRICTION)):
        signals = pausing(np.full(round(4 * RATE), at_rest))
        rows = pid.build_regressor(turntable.robot, turntable.effects, [signals], filter)
        found = rest_rows(turntable, [signals], filter)
        assert found.outside[0] == pytest.approx(outside)
        residual = (rows.torque - rows.predict(turntable.theta) - found.friction)[:, 0]
        middle = np.abs(rows.time - 6.0) < 1.0
        np.testing.assert_allclose(residual[middle], left, atol=0.02 * FRICTION)
        # rows whose window holds no rest are in motion, and are left alone
        moving = found.moving[:, 0]
        reach = (len(filter.taps(RATE)) - 1) / 2 / RATE
        from_middle = np.abs(rows.time - (6.0 - 0.5 / RATE))  # the last sample at rest is the one before 8 s
        np.testing.assert_array_equal(moving, from_middle > 2.0 + reach)
        assert (found.friction[moving] == 0).all()


@pytest.mark.parametrize(("beyond", "share"), [(0.1, 1.0), (-0.1, 0.0)])
@pytest.mark.parametrize("seed", range(5))
def test_noise_does_not_choose_what_counts_of_a_rest(
    turntable: pid.Model, beyond: float, share: float, seed: int
) -> None:
    """Of a rest near its band's edge, some moments seem beyond it and others within: all of it is held, or nothing."""
    noise = np.random.default_rng(seed).normal(size=round(4 * RATE))
    (signals,) = hold_rests(turntable, [pausing(FRICTION + beyond + noise - noise.mean())])
    assert signals.rests is not None
    held = signals.rests[0].held
    assert held is not None
    assert np.isfinite(held).mean() == share


def test_a_rest_that_gives_way_is_held_from_there_on(turntable: pid.Model) -> None:
    torque = np.linspace(0.0, 2 * FRICTION, round(4 * RATE)) + 0.1 * np.random.default_rng(1).normal(
        size=round(4 * RATE)
    )
    (signals,) = hold_rests(turntable, [pausing(torque)])
    assert signals.rests is not None
    held = signals.rests[0].held
    assert held is not None
    assert np.isfinite(held).mean() == pytest.approx(0.5, abs=0.1)  # friction is exhausted halfway
    assert np.isfinite(held[-5:]).all()


def test_without_rests_every_row_is_in_motion(turntable: pid.Model) -> None:
    found = rest_rows(turntable, [replace(pausing(), rests=None)], pid.Filter())
    assert found.moving.all()
    assert (found.friction == 0).all()
    assert found.outside[0] == 0
    none = Rests(start=np.zeros(0, int), stop=np.zeros(0, int), before=np.zeros(0), after=np.zeros(0))
    (signals,) = hold_rests(turntable, [replace(pausing(), rests=(none,))])
    assert signals.rests is not None
    assert len(signals.rests[0].start) == 0


@pytest.mark.parametrize(
    ("smoothing", "low", "high"), [(None, 0.0, 0.004), (0.016, 0.011, 0.023), (0.064, 0.045, 0.091)]
)
def test_the_width_of_dry_friction_is_found(smoothing: float | None, low: float, high: float, ur5: pid.Robot) -> None:
    """A sticking arm is dry, within what the noise of its velocity hides (1e-3 rad/s); a smooth one has its own width."""
    friction = CoulombFriction() if smoothing is None else CoulombFriction(smoothing=smoothing, presliding=0.0)
    effects = pid.make_effects(["rigid_body", "rotor_inertia", "viscous_friction", friction])
    theta = np.concatenate([ur5.nominal, np.full(6, 0.5), np.full(6, 4.0), np.full(6, FRICTION)])
    sensors = Sensors(encoder_step=5e-5, velocity_noise=1e-3, torque_noise=0.3)
    plan = pid.random_trajectory(ur5, seed=2, duration=20.0, base_frequency=0.1)
    recording = simulate(pid.Model(ur5, effects, theta), plan, sensors=sensors, seed=1)
    estimate = pid.identify(ur5, [recording])
    (found,) = [effect for effect in estimate.model.effects if isinstance(effect, CoulombFriction)]
    assert isinstance(found.smoothing, tuple)
    assert min(found.smoothing) >= low
    assert max(found.smoothing) <= high
    np.testing.assert_allclose(estimate.model.parameters("coulomb_friction"), FRICTION, rtol=0.05)


def test_a_stated_width_is_kept(ur5: pid.Robot, healthy_runs: list[pid.Recording]) -> None:
    effects = [e if e != "coulomb_friction" else CoulombFriction(smoothing=0.03) for e in DEFAULT_EFFECTS]
    estimate = pid.identify(ur5, healthy_runs[0], effects)
    assert CoulombFriction(smoothing=0.03) in estimate.model.effects
