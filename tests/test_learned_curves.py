"""Learned curves: what their modes are, what stays outside of their range, and that they find the curve an arm has."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray

import physident as pid
from physident.effects.learned.curves import LearnedLoad, LearnedPosition, LearnedPositionFriction
from physident.effects.learned.spline import bumps, modes
from physident.effects.learned.velocity_curve import LearnedVelocity
from physident.estimation.physical.cones import physical_cones
from physident.identifiability.base_parameters import random_motion
from physident.recordings.signals import Signals
from tests.followed import followed

pytestmark = pytest.mark.slow

PLACE, WIDTH, HEIGHT = 0.2, 0.2, 3.0  # rad, rad, N m: of the curve that the simulated arm has on its third joint


@dataclass(frozen=True)
class Bump(pid.FormulaEffect):
    """What the arm has: a torque around one position."""

    name = "bump"
    unit = "N m"
    family = pid.Family.TRANSMISSION
    formulas = (f"np.exp(-0.5 * ((q - {PLACE}) / {WIDTH}) ** 2)",)


def bump(q: np.ndarray) -> np.ndarray:
    return HEIGHT * np.exp(-0.5 * ((q - PLACE) / WIDTH) ** 2)


@pytest.fixture(scope="module")
def runs(ur5: pid.Robot) -> list[pid.Recording]:
    """Three recordings of an arm with the bump, whose third joint passes it often."""
    nominal = pid.Model.nominal(ur5)
    friction = {"viscous_friction": 5.0, "coulomb_friction": 4.0}
    theta = [friction.get(c.effect, value) for c, value in zip(nominal.columns, nominal.theta, strict=True)]
    arm = pid.Model(ur5, (*nominal.effects, Bump(joints=(3,))), np.array([*theta, HEIGHT]))
    sensors = pid.Sensors(encoder_step=5e-5, velocity_noise=1e-3, torque_noise=0.5)
    motions = [pid.random_trajectory(ur5, seed=seed, duration=30.0, base_frequency=0.1) for seed in (1, 2, 3)]
    return [followed(arm, motion, sensors, seed=seed) for seed, motion in enumerate(motions)]


@pytest.mark.parametrize("circle", [False, True])
def test_all_modes_but_a_constant_have_no_mean_and_none_overlap(circle: bool) -> None:
    u = (np.arange(8000) + 0.5) / 8000
    shapes = modes(32, circle).T @ bumps(32 * u, 32)
    products = shapes @ shapes.T / len(u)
    np.testing.assert_allclose(shapes[0], 1, atol=1e-12)
    np.testing.assert_allclose(shapes[1:].mean(axis=1), 0, atol=1e-6)
    np.testing.assert_allclose(products, np.diag(np.diag(products)), atol=1e-6)
    sizes = np.sqrt(np.diag(products))
    assert (np.diff(sizes) < 1e-9).all()  # from the smoothest on, each is held more than the one before
    if circle:
        ends = modes(32, circle).T @ bumps(np.array([0.0, 32.0]), 32)
        np.testing.assert_allclose(ends[:, 0], ends[:, 1], atol=1e-12)


def at(q: float, v: float = 0.0) -> Signals:
    return Signals.of_states(np.full((1, 6), q), np.full((1, 6), v), np.zeros((1, 6)))


@pytest.mark.parametrize("circle", [False, True])
def test_no_part_of_a_curve_is_larger_than_its_ceiling(circle: bool, ur5: pid.Robot) -> None:
    """One standard deviation of each mode, over an interval and over the circle of a joint without limits."""
    robot = without_limits(ur5) if circle else ur5
    amplitude, ceiling = 50.0, 2.0
    curve = LearnedPosition((1,), (-1.0,), (1.0,), (amplitude,), (ceiling,))
    assert curve.circles(robot)[0] == circle
    x = ((np.arange(4000) + 0.5) / 2000 - 1.0) * (np.pi if circle else 1.0)
    sizes = curve.prior_sizes(robot)
    assert sizes is not None
    largest = np.sqrt(np.mean((curve.shapes_at(robot, x) * sizes) ** 2, axis=0))
    assert (largest < 1.35 * ceiling).all()
    assert (largest[:4] > 0.35 * ceiling).all()
    np.testing.assert_allclose(sizes[-8:], amplitude)  # what is fine, other parameters do not have


def test_beyond_its_range_a_curve_stays_constant(ur5: pid.Robot) -> None:
    position = LearnedPosition((3,), (-0.5,), (0.7,), (1.0,))
    for inside, outside in ((0.7, 2.5), (-0.5, -1.9)):
        np.testing.assert_array_equal(position.values(ur5, at(inside)), position.values(ur5, at(outside)))


def test_how_a_curve_shares_a_line_with_viscous_friction_is_seen_nowhere(ur5: pid.Robot) -> None:
    """Dry and viscous friction that a curve over velocity holds go on beyond its range as these do, and a bump ends with it."""
    curve = LearnedVelocity((3,), (-0.8,), (0.8,), (1.0,))
    v = np.concatenate([-np.geomspace(0.8, 0.05, 200), np.geomspace(0.05, 0.8, 200)])
    laws = np.column_stack([2 * np.sign(v) + 5 * v, np.sign(v) * np.exp(-(((np.abs(v) - 0.08) / 0.03) ** 2))])
    theta: NDArray[np.float64] = np.linalg.lstsq(curve.shapes_at(ur5, v), laws, rcond=None)[0].astype(np.float64)
    fast = np.array([-9.0, -1.0, 0.8, 1.0, 9.0])
    line, bump = (curve.shapes_at(ur5, fast) @ theta).T
    np.testing.assert_allclose(line[1:4], (2 * np.sign(fast) + 5 * fast)[1:4], rtol=0.03)
    assert 6.0 < line[4] < 10.0  # far beyond it has levelled off
    np.testing.assert_allclose(bump, 0.0, atol=0.2)
    source = curve.numpy_source(ur5, theta[:, 0])
    assert source is not None
    printed = [eval(source, {"np": np, "v": np.full(ur5.n, one)}) for one in fast]
    np.testing.assert_allclose(np.array(printed)[:, 2], line)


def without_limits(robot: pid.Robot) -> pid.Robot:
    free = replace(robot)
    object.__setattr__(free, "lower", np.full(robot.n, -np.inf))
    object.__setattr__(free, "upper", np.full(robot.n, np.inf))
    return free


def test_it_repeats_with_each_turn_of_a_joint_without_limits(ur5: pid.Robot) -> None:
    free = without_limits(ur5)
    effect = LearnedPosition((3,), (-1.0,), (1.0,), (1.0,))
    np.testing.assert_allclose(effect.values(free, at(0.4)), effect.values(free, at(0.4 - 2 * np.pi)), atol=1e-12)
    assert np.abs(effect.values(ur5, at(0.4)) - effect.values(ur5, at(0.4 - 2 * np.pi))).max() > 0.1


def test_its_range_is_that_of_the_recordings(ur5: pid.Robot, runs: list[pid.Recording]) -> None:
    signals = [pid.prepare(run, pid.Filter()) for run in runs]
    placed = LearnedPosition((3,)).placed(ur5, signals)
    assert isinstance(placed, LearnedPosition)
    every = np.concatenate([one.q[:, 2] for one in signals])
    assert (placed.low, placed.high) == ((every.min(),), (every.max(),))
    given = LearnedPosition((3,), (-9.0,), (9.0,))
    assert given.placed(ur5, signals) == given


@pytest.mark.parametrize("method", ["wls", "physical"])
def test_the_curve_that_the_arm_has_is_found(method: str, ur5: pid.Robot, runs: list[pid.Recording]) -> None:
    """Within 15 % of its height wherever the recordings were, and as good on unseen rows as the noise allows."""
    curve = LearnedPosition((3,))
    plain = pid.identify(ur5, runs[:2], method=method)
    learned = pid.identify(ur5, runs[:2], [*pid.Model.nominal(ur5).effects, curve], method=method)
    effect, values = learned.model.effect_parameters()[-1]
    assert isinstance(effect, LearnedPosition)
    x, torque, _ = effect.curve(ur5, values)
    q = np.sort(np.concatenate([run.q[:, 2] for run in runs[:2]]))
    seen = np.searchsorted(q, x + 0.05) - np.searchsorted(q, x - 0.05) > 50
    true = bump(x)
    apart = (torque - true)[seen]
    assert np.abs(apart - apart.mean()).max() < 0.15 * HEIGHT  # its mean is an offset
    before, after = (pid.validate(one, runs[2]).rms for one in (plain, learned))
    assert after[2] < 0.5 * before[2]
    np.testing.assert_allclose(np.delete(after, 2), np.delete(before, 2), rtol=0.35)


def test_a_curve_is_told_by_where_it_is_large_not_by_its_numbers(ur5: pid.Robot, runs: list[pid.Recording]) -> None:
    effects = [*pid.Model.nominal(ur5).effects, LearnedPosition((3,))]
    told = repr(pid.identify(ur5, runs, effects)).splitlines()
    (row,) = [row for row in told if "learned_position" in row]
    found = re.search(r"joint 3: .* ([+-][0-9.]+) N m between (-?[0-9.]+) and (-?[0-9.]+) rad$", row)
    assert found is not None
    size, low, high = map(float, found.groups())
    assert size == pytest.approx(HEIGHT, rel=0.3)  # but for its mean, which an offset takes
    assert PLACE - 2 * WIDTH < low < PLACE < high < PLACE + 2 * WIDTH  # at least half of it is there


def test_the_ends_of_a_narrow_range_are_told_apart(ur5: pid.Robot) -> None:
    """A range of 4 mrad at 1.8 rad is no empty one, and that of a single place is a place."""
    effect, x = LearnedPosition((3,), (-2.0,), (2.0,), (1.0,)), np.array([0.0, 1.796, 1.798, 1.8, 1.9])
    narrow = effect.points_in_words(ur5, 0, x, np.array([0.0, 1.0, 1.2, 1.0, 0.0]))
    assert narrow.endswith("+1.2 N m between 1.796 and 1.8 rad")
    assert effect.points_in_words(ur5, 0, x, np.array([0.0, 0.0, 1.2, 0.0, 0.0])).endswith("+1.2 N m at 1.8 rad")
    assert effect.points_in_words(ur5, 0, x, np.array([0.0, 1.0, 1.0, 1.0, 1.0])).endswith("between 1.8 and 1.9 rad")


def test_a_model_may_be_curves_alone(ur5: pid.Robot, runs: list[pid.Recording]) -> None:
    """Most of what a shoulder carries is its weight, which a curve over its position takes."""
    estimate = pid.identify(ur5, runs[:2], [LearnedPosition()])
    assert estimate.sigma[1] < 0.3 * np.sqrt(np.mean([np.mean(run.effort[:, 1] ** 2) for run in runs[:2]]))


def test_a_curve_that_the_arm_does_not_have_stays_small(ur5: pid.Robot, runs: list[pid.Recording]) -> None:
    estimate = pid.identify(ur5, runs[:2], [*pid.Model.nominal(ur5).effects, LearnedPosition((5,))])
    effect, values = estimate.model.effect_parameters()[-1]
    assert isinstance(effect, LearnedPosition)
    _, torque, _ = effect.curve(ur5, values)
    assert np.abs(torque).max() < 0.2  # N m, of noise of 0.5


def test_a_physical_model_with_a_learned_friction_curve_takes_energy(ur5: pid.Robot, runs: list[pid.Recording]) -> None:
    effects = [*pid.Model.nominal(ur5).effects, LearnedVelocity((3,))]
    model = pid.identify(ur5, runs[:2], effects, method="physical").model
    assert physical_cones(ur5, model.effects).broken(model.theta) == []
    v = np.concatenate([-np.geomspace(3.0, 1e-2, 60), np.geomspace(1e-2, 3.0, 60)])
    total = sum(
        effect.friction(ur5, v)[[c.joint == 3 for c in effect.columns(ur5)]].T
        @ values[[c.joint == 3 for c in effect.columns(ur5)]]
        for effect, values in model.effect_parameters()
    )
    assert (np.asarray(total) * v > -1e-6).all()


def test_a_model_with_curves_survives_its_file(ur5: pid.Robot, runs: list[pid.Recording], tmp_path) -> None:
    effects = [*pid.Model.nominal(ur5).effects, LearnedPosition((3,)), LearnedPositionFriction((2,)), LearnedLoad((1,))]
    estimate = pid.identify(ur5, runs[:2], effects)
    estimate.save(tmp_path / "model.json")
    again = pid.load_estimate(tmp_path / "model.json")
    motion = random_motion(ur5, 4)
    np.testing.assert_array_equal(again.model.torque(motion), estimate.model.torque(motion))
    pid.export_python(again, tmp_path / "arm.py")
    space: dict = {}
    exec((tmp_path / "arm.py").read_text(encoding="utf-8"), space)
    found = space["torque"](motion.q, motion.v, motion.a)
    np.testing.assert_allclose(found, estimate.model.torque(motion), rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"low": (1.0,), "high": (0.0,)}, "expected low below high"),
        ({"low": (-np.inf,), "high": (0.0,)}, "expected low below high, both finite"),
        ({"low": (1.0,)}, "expected both or neither"),
        ({"amplitude": (0.0,)}, "expected positive"),
        ({"amplitude": (float("nan"),)}, "expected positive"),
        ({"ceiling": (-1.0,)}, "expected positive"),
        ({"low": (0.0, 0.0), "high": (1.0,)}, "low has 2 values, expected one, or 1, one a joint"),
        ({"low": -1.0, "high": 1.0}, r"low is -1.0, expected numbers in a row, such as \(-1.0,\)"),
    ],
)
def test_impossible_settings_are_refused(settings: dict, said: str) -> None:
    with pytest.raises(pid.InputError, match=said):
        LearnedPosition((1,), **settings)


def test_a_diagnosis_learns_what_no_law_describes(ur5: pid.Robot, runs: list[pid.Recording]) -> None:
    estimate = pid.identify(ur5, runs)
    found = pid.diagnose(estimate, runs)
    assert isinstance(found, pid.Diagnosis)
    (cause,) = [finding for finding in found.findings if finding.grade == "cause"]
    assert (cause.effect, cause.joints) == ("learned_position", (3,))
    (curve,) = cause.curves
    true = bump(np.array(curve.x))
    middle = np.abs(np.array(curve.x) - PLACE) < 2 * WIDTH
    apart = (np.array(curve.torque) - true)[middle]
    assert np.abs(apart - apart.mean()).max() < 0.15 * HEIGHT
    assert "nearest:" in cause.in_words or "none takes" in cause.in_words
    assert found.estimate is not None
    assert "learned_position" in {effect.name for effect in found.estimate.model.effects}
