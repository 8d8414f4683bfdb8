"""A colder arm whose friction is no straight line over speed: all of it is scaled, and told as one number of the whole friction."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.effects.friction import CoulombFriction, NonlinearViscousFriction, StribeckFriction
from physident.effects.hysteresis import PreslidingHysteresis
from physident.effects.scales.friction_level import FrictionLevel
from physident.testing import check_effect
from tests.serial_arms import ARMS, swung, urdf

pytestmark = pytest.mark.slow

COLDER = 0.25
SATURATES = np.array([0.5, 0.3])  # rad/s at which the drag of oil is half of what it was on the way to
DRAG, DRY = np.array([7.0, 4.0]), np.array([1.5, 0.8])  # N m s/rad at standstill, N m


def recorded(seed: int, share: float) -> pid.Recording:
    """Two joints with parallel axes whose drag saturates, by pinocchio; sixty seconds at up to 2 rad/s."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, 60.0, 0.005)
    q, v, tau = swung(rng, time)
    tau += (1 + share) * (DRY * np.clip(v / 1e-4, -1, 1) + DRAG * v / (1 + np.abs(v) / SATURATES))
    return pid.Recording.from_arrays(
        time, q, dq=v, effort=tau + 0.05 * rng.standard_normal(tau.shape), source=f"{seed}"
    )


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> pid.Robot:
    path = tmp_path_factory.mktemp("oil") / "planar.urdf"
    path.write_text(urdf(ARMS["two"]))
    return pid.load_robot(path)


def test_a_colder_arm_is_named_by_its_whole_friction(robot: pid.Robot, tmp_path: Path) -> None:
    for seed in (1, 2):
        recorded(seed, 0.0).to_pandas().to_csv(tmp_path / f"{seed}.csv", index=False)
    model = pid.identify(robot, [tmp_path / "1.csv", tmp_path / "2.csv"])
    answer = pid.diagnose_motion(model, [recorded(seed, COLDER) for seed in (3, 4)])
    causes = [one for one in answer.findings if one.grade == "cause"]
    assert [one.effect for one in causes] == ["friction_level"]
    shares = [one.value for one in causes[0].parameters]
    np.testing.assert_allclose(shares, 100 * COLDER, rtol=0.1)


def test_it_scales_every_law_of_a_model(ur5: pid.Robot) -> None:
    effects = (
        "rigid_body",
        CoulombFriction(),
        NonlinearViscousFriction(exponent=(0.7,)),
        StribeckFriction(velocity=(0.2,)),
    )
    model = pid.Model.nominal(ur5, effects)
    theta = np.array(model.theta)
    rng = np.random.default_rng(3)
    theta[-18:] = rng.uniform(1.0, 5.0, 18)
    model, twice = (pid.Model(ur5, model.effects, one) for one in (theta, theta * np.repeat([1.0, 2.0], [60, 18])))
    level, dry, by_speed = FrictionLevel.options_beside(ur5, model.effect_parameters())
    v = np.tile(np.concatenate([np.geomspace(0.02, 2.5, 60), -np.geomspace(0.02, 2.5, 60)])[:, None], 6)
    signals = pid.Signals.of_states(np.zeros_like(v), v, np.zeros_like(v))
    more = twice.torque(signals) - model.torque(signals)
    own = level.values(ur5, signals)
    np.testing.assert_allclose(own.T, more, rtol=0.04)  # a line through a few speeds
    np.testing.assert_allclose(dry.values(ur5, signals) + by_speed.values(ur5, signals), own, atol=1e-9)


def test_a_level_on_a_level_is_of_all_the_friction_there_is(ur5: pid.Robot) -> None:
    """As of a model that was found to be of a colder arm, and is asked again."""
    model = pid.Model(
        ur5, pid.make_effects(["coulomb_friction", NonlinearViscousFriction(exponent=(0.7,))]), np.full(12, 2.0)
    )
    once, *_ = FrictionLevel.options_beside(ur5, model.effect_parameters())
    colder = pid.Model(ur5, (*model.effects, once), np.array([*model.theta, 0.5]))
    twice, *_ = FrictionLevel.options_beside(ur5, colder.effect_parameters())
    v = np.linspace(-3.0, 3.0, 101)[:, None] * np.ones(6)
    signals = pid.Signals.of_states(np.zeros_like(v), v, np.zeros_like(v))
    np.testing.assert_allclose(twice.values(ur5, signals), 1.5 * once.values(ur5, signals), rtol=1e-9, atol=1e-9)


def test_bristles_are_dry_friction(ur5: pid.Robot) -> None:
    model = pid.Model(ur5, (PreslidingHysteresis(distance=(0.01,)),), np.full(6, 300.0))
    (level,) = FrictionLevel.options_beside(ur5, model.effect_parameters())
    assert level.coulomb == pytest.approx((3.0,) * 6)  # N m where they slide
    assert not level.beyond


def test_it_keeps_what_an_effect_promises(ur5: pid.Robot) -> None:
    model = pid.Model(
        ur5, pid.make_effects(["coulomb_friction", NonlinearViscousFriction(exponent=(0.7,))]), np.full(12, 2.0)
    )
    for one in FrictionLevel.options_beside(ur5, model.effect_parameters()):
        check_effect(one)
    rest = pid.Signals.of_states(*np.zeros((3, 1, 6)))
    with pytest.raises(pid.InputError, match="speeds and beyond have 3 and 2 values, expected 6 rows"):
        FrictionLevel(speeds=(0.0, 1.0, 2.0), beyond=(0.0, 1.0)).values(ur5, rest)
