"""Friction at a place that turns over a speed of its own: found beside dry friction, and as wide as the arm's."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

import physident as pid
from physident.effects.friction import CoulombFriction
from physident.effects.learned.curves import LearnedPositionFriction, LearnedTemperature, LearnedTime
from physident.export.symbolic import symbolic_model
from physident.identifiability.base_parameters import random_motion
from tests.followed import followed

pytestmark = pytest.mark.slow

PLACE, WIDTH, HEIGHT, SLOW = 0.2, 0.2, 4.0, 0.22  # rad, rad, N m, rad/s


@dataclass(frozen=True)
class Drag(pid.FormulaEffect):
    """What the arm has: a place that drags as if in oil."""

    name = "drag"
    unit = "N m"
    family = pid.Family.FRICTION
    formulas = (f"np.exp(-0.5 * ((q - {PLACE}) / {WIDTH}) ** 2) * v / (np.abs(v) + {SLOW})",)


@pytest.fixture(scope="module")
def runs(ur5: pid.Robot) -> list[pid.Recording]:
    """Three recordings of an arm whose third joint passes the place often."""
    nominal = pid.Model.nominal(ur5)
    friction = {"viscous_friction": 5.0, "coulomb_friction": 4.0}
    theta = [friction.get(c.effect, value) for c, value in zip(nominal.columns, nominal.theta, strict=True)]
    arm = pid.Model(ur5, (*nominal.effects, Drag(joints=(3,))), np.array([*theta, HEIGHT]))
    sensors = pid.Sensors(encoder_step=5e-5, velocity_noise=1e-3, torque_noise=0.3)
    motions = [pid.random_trajectory(ur5, seed=seed, duration=30.0, base_frequency=0.1) for seed in (1, 2, 3)]
    return [followed(arm, motion, sensors, seed=seed) for seed, motion in enumerate(motions)]


def test_it_turns_over_its_own_speed(ur5: pid.Robot, runs: list[pid.Recording]) -> None:
    found = pid.diagnose_motion(pid.identify(ur5, runs[:2]), runs[:2], runs[2:])
    (cause,) = found.causes
    assert (cause.effect, cause.joints) == ("learned_position_friction", (3,))
    assert found.estimate is not None
    parameters = found.estimate.model.effect_parameters()
    ((curve, theta),) = [(e, own) for e, own in parameters if isinstance(e, LearnedPositionFriction)]
    assert curve.smoothing is not None
    # half of either friction is reached at about the same speed: v / (v + slow) there, tanh(v / smoothing) here
    assert SLOW / 2 < curve.smoothing[0] * np.arctanh(0.5) < 2 * SLOW
    q, torque, _ = curve.curve(ur5, theta)
    speed = np.concatenate(
        [np.abs(run.dq[np.abs(run.q[:, 2] - PLACE) < WIDTH, 2]) for run in runs[:2] if run.dq is not None]
    )
    there = HEIGHT * float(np.median(speed / (speed + SLOW)))
    assert np.interp(PLACE, q, torque) == pytest.approx(
        there, rel=0.15
    )  # and not less, with friction everywhere else below zero
    assert np.abs(torque[np.abs(q - PLACE) > 4 * WIDTH]).max() < 0.15 * HEIGHT
    as_dry = [replace(e, smoothing=None) if e is curve else e for e in found.estimate.model.effects]
    dry = pid.identify(ur5, runs[:2], as_dry)
    own = pid.validate(found.estimate, runs[2:])
    assert own.rms[2] < 0.8 * pid.validate(dry, runs[2:]).rms[2]


@pytest.mark.parametrize("zero", [None, (-0.4, 0.2)])
def test_its_exported_torque_is_its_own(zero: tuple[float, ...] | None, ur5: pid.Robot, tmp_path) -> None:
    curve = LearnedPositionFriction((2, 3), (-1.0,), (1.0,), (1.0,), smoothing=(0.1, 0.3), zero=zero)
    effects = (*pid.Model.nominal(ur5).effects, curve)
    count = sum(len(e.columns(ur5)) for e in effects)
    model = pid.Model(ur5, effects, np.random.default_rng(0).standard_normal(count))
    pid.export_python(model, tmp_path / "arm.py")
    space: dict = {}
    exec((tmp_path / "arm.py").read_text(encoding="utf-8"), space)
    motion = random_motion(ur5, 4)
    np.testing.assert_allclose(
        space["torque"](motion.q, motion.v, motion.a), model.torque(motion), rtol=1e-8, atol=1e-8
    )


def test_exported_friction_turns_as_the_model_does(ur5: pid.Robot, tmp_path) -> None:
    """What has no speed of its own turns with the joint's dry friction, exported as well as evaluated."""
    widths = (0.2, 0.1, 0.3, 0.05, 0.0, 0.2)
    effects = (
        *pid.make_effects(["rigid_body", "load_dependent_friction"]),
        CoulombFriction(smoothing=widths),
        LearnedPositionFriction((2, 3), (-1.0, -1.0), (1.0, 1.0), (1.0, 1.0)),
    )
    count = sum(len(e.columns(ur5)) for e in effects)
    model = pid.Model(ur5, effects, np.random.default_rng(0).standard_normal(count))
    motion = random_motion(ur5, 40)
    slow = replace(motion, v=0.1 * motion.v)
    pid.export_python(model, tmp_path / "arm.py")
    space: dict = {}
    exec((tmp_path / "arm.py").read_text(encoding="utf-8"), space)
    expected = model.torque(slow)
    np.testing.assert_allclose(space["torque"](slow.q, slow.v, slow.a), expected, rtol=1e-8, atol=1e-8)
    import casadi as ca

    one = symbolic_model(model)
    at_once = ca.Function("torque", [one.q, one.v, one.a], [one.torque, one.regressor])
    torque, regressor = at_once(slow.q[0], slow.v[0], slow.a[0])
    np.testing.assert_allclose(np.array(torque).ravel(), expected[0], rtol=1e-8)
    np.testing.assert_allclose(np.array(regressor) @ model.theta, expected[0], rtol=1e-8)


def test_it_is_zero_at_its_zero_whatever_its_parameters(ur5: pid.Robot) -> None:
    curve = LearnedPositionFriction((2, 3), (-1.0,), (1.0,), (1.0,), smoothing=(0.1, 0.3), zero=(-0.4, 0.2))
    theta = np.random.default_rng(1).standard_normal(len(curve.columns(ur5)))
    for k, place in enumerate((-0.4, 0.2)):
        q, torque, _ = curve.curve(ur5, theta, k)
        assert abs(np.interp(place, q, torque)) < 1e-2 * np.abs(torque).max()
        assert np.abs(torque).max() > 0.5


def test_an_impossible_speed_or_place_is_refused() -> None:
    with pytest.raises(pid.InputError, match="expected positive speeds"):
        LearnedPositionFriction((1,), smoothing=(0.0,))
    with pytest.raises(pid.InputError, match="expected positions"):
        LearnedPositionFriction((1,), zero=(np.nan,))


def test_it_leaves_dry_friction_as_dry_as_it_is(ur5: pid.Robot) -> None:
    """Its constant is dry friction itself: beside it no speed over which dry friction turns could be told from another."""
    nominal = pid.Model.nominal(ur5)
    friction = {"viscous_friction": 5.0, "coulomb_friction": 4.0}
    theta = [friction.get(c.effect, value) for c, value in zip(nominal.columns, nominal.theta, strict=True)]
    arm = pid.Model(ur5, nominal.effects, np.array(theta))
    sensors = pid.Sensors(encoder_step=5e-5, velocity_noise=1e-3, torque_noise=0.3)
    motions = [pid.random_trajectory(ur5, seed=seed, duration=20.0, base_frequency=0.1) for seed in (1, 2)]
    runs = [followed(arm, motion, sensors, seed=seed) for seed, motion in enumerate(motions)]
    widths = []
    for effects in (nominal.effects, (*nominal.effects, LearnedPositionFriction((6,)))):
        model = pid.identify(ur5, runs, effects).model
        widths.append([e.smoothing for e in model.effects if isinstance(e, CoulombFriction)])
    assert widths[1] == widths[0]


def test_friction_over_temperature_is_learned_where_there_is_one(ur5: pid.Robot, runs: list[pid.Recording]) -> None:
    """Friction of the second joint falls by half in twelve degrees, not along a line; each recording warms up differently."""
    warm = []
    for run, top in zip(runs, (40.0, 35.0, 45.0), strict=True):
        degrees = 20.0 + (top - 20.0) * (run.time - run.time[0]) / np.ptp(run.time)
        assert run.dq is not None
        more = np.zeros_like(run.effort)
        more[:, 1] = 6.0 * 0.5 ** ((degrees - 20.0) / 12.0) * np.sign(run.dq[:, 1])
        warm.append(replace(run, effort=run.effort + more, temperature=np.tile(degrees[:, None], (1, run.n))))
    curve = LearnedTemperature((2,))
    found = pid.identify(ur5, warm, (*pid.Model.nominal(ur5).effects, curve)).model
    ((effect, theta),) = [(e, t) for e, t in found.effect_parameters() if isinstance(e, LearnedTemperature)]
    x, torque, _ = effect.curve(ur5, theta)
    apart = torque - 6.0 * 0.5 ** ((x - 20.0) / 12.0)
    assert np.abs(apart - apart.mean()).max() < 0.15 * 6.0
    signals = [pid.prepare(one, pid.Filter()) for one in (*warm, runs[0])]
    assert LearnedTemperature.is_shown(signals[:3], 1)
    assert not LearnedTemperature.is_shown(signals, 1)  # the last one has no temperature


def test_time_is_no_quantity_of_its_own_where_two_recordings_are_of_one_motion(
    ur5: pid.Robot, runs: list[pid.Recording]
) -> None:
    signals = [pid.prepare(one, pid.Filter()) for one in runs]
    later = replace(signals[0], time=signals[0].time + 100.0, origin=signals[0].origin + 100.0)
    noisy = replace(later, q=later.q + 1e-3 * np.random.default_rng(0).standard_normal(later.q.shape))
    for joint in range(ur5.n):
        assert LearnedTime.is_shown(signals, joint)
        assert not LearnedTime.is_shown(signals[:1], joint)  # one alone does not show that anything repeats
        assert not LearnedTime.is_shown([signals[0], signals[1], noisy], joint)
