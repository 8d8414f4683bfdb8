"""The contract that every effect of the catalogue keeps."""

from __future__ import annotations

import numpy as np
import pytest

import physident as pid
from physident.effects.catalogue import effect_from_dict

EFFECTS = sorted(pid.CATALOGUE)


def _states(robot: pid.Robot, count: int = 40, seed: int = 0) -> pid.Signals:
    rng = np.random.default_rng(seed)
    return pid.Signals.of_states(*rng.uniform(-2, 2, size=(3, count, robot.n)))


@pytest.mark.parametrize("name", EFFECTS)
def test_shapes_names_and_units(name: str, ur5: pid.Robot) -> None:
    effect = pid.CATALOGUE[name]()
    columns, states = effect.columns(ur5), _states(ur5)
    assert effect.name == name
    assert effect.regressor(ur5, states).shape == (40, 6, len(columns))
    assert len({c.name for c in columns}) == len(columns)
    assert all(c.unit and 1 <= c.joint <= 6 and c.effect == name for c in columns)
    assert effect.acts_on in ("plant", "measurement", "sensor")
    assert effect.nominal(ur5).shape == (len(columns),)


@pytest.mark.parametrize("name", EFFECTS)
def test_regressor_times_parameters_is_the_model_torque(name: str, ur5: pid.Robot) -> None:
    effect, states = pid.CATALOGUE[name](), _states(ur5)
    theta = np.random.default_rng(1).normal(size=len(effect.columns(ur5)))
    torque = pid.Model(ur5, (effect,), theta).torque(states)
    np.testing.assert_allclose(effect.regressor(ur5, states) @ theta, torque, atol=1e-10)


@pytest.mark.parametrize("name", EFFECTS)
def test_finite_at_standstill(name: str, ur5: pid.Robot) -> None:
    zero = np.zeros((5, 6))
    assert np.isfinite(pid.CATALOGUE[name]().regressor(ur5, pid.Signals.of_states(zero, zero, zero))).all()


@pytest.mark.parametrize("name", EFFECTS)
def test_the_nominal_robot_lies_inside_the_cones(name: str, ur5: pid.Robot) -> None:
    effect = pid.CATALOGUE[name]()
    theta = effect.nominal(ur5)
    for cone in effect.cones(ur5):
        value = cone.map @ theta + cone.offset
        smallest = np.linalg.eigvalsh(value)[0] if cone.kind == "psd" else value.min()
        assert smallest >= -1e-12


@pytest.mark.parametrize("name", EFFECTS)
def test_survives_json(name: str) -> None:
    effect = pid.CATALOGUE[name]()
    assert effect_from_dict(effect.as_dict()) == effect


@pytest.mark.parametrize("name", [n for n in EFFECTS if n != "rigid_body"])
def test_restricted_to_joints_it_acts_there_only(name: str, ur5: pid.Robot) -> None:
    some, states = pid.CATALOGUE[name](joints=(2, 5)), _states(ur5)
    assert {c.joint for c in some.columns(ur5)} == {2, 5}
    rows = np.abs(some.regressor(ur5, states)).max(axis=(0, 2))
    assert np.flatnonzero(rows).tolist() == [1, 4]
    with pytest.raises(pid.InputError, match="joint 7 does not exist"):
        pid.CATALOGUE[name](joints=(7,)).columns(ur5)


@pytest.mark.parametrize("name", ["viscous_friction", "coulomb_friction"])
def test_friction_takes_energy(name: str, ur5: pid.Robot) -> None:
    effect, states = pid.CATALOGUE[name](), _states(ur5)
    power = effect.regressor(ur5, states) @ np.ones(6) * states.v
    assert (power >= 0).all()
    assert power.sum() > 0


def test_nominal_drive_values_are_the_published_ones_at_the_joint(ur5: pid.Robot) -> None:
    """Motor friction times the gear ratio; motor inertia times its square."""
    coulomb = pid.CATALOGUE["coulomb_friction"]().nominal(ur5)
    rotor = pid.CATALOGUE["rotor_inertia"]().nominal(ur5)
    np.testing.assert_allclose(coulomb[[0, 1]], [0.076 * 101, (0.083 + 0.082) / 2 * 101])
    np.testing.assert_allclose(rotor[[0, 5]], [1.87e-8 * 101**2, 2.07e-5 * 101**2])


def test_unknown_and_repeated_effects_are_refused() -> None:
    with pytest.raises(pid.InputError, match="'magic' is unknown"):
        pid.make_effects(["magic"])
    with pytest.raises(pid.InputError, match="given twice"):
        pid.make_effects(["rigid_body", "rigid_body"])
    with pytest.raises(pid.InputError, match="no effects given"):
        pid.make_effects([])
