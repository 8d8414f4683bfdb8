"""The contract that every effect of the catalogue keeps, and each one's torque against a closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physident as pid
from physident.effects.catalogue import effect_from_dict
from physident.effects.classification import Family, Scope
from physident.estimation.physical.cones import physical_cones
from physident.identifiability.base_parameters import random_motion

EFFECTS = sorted(pid.CATALOGUE)


def ready(name: str, robot: pid.Robot, joints: tuple[int, ...] | None = None) -> pid.Effect:
    """An effect of the catalogue with each shape parameter at the middle of its grid."""
    return pid.CATALOGUE[name].at_grid_middle(robot, joints)


def motion(robot: pid.Robot, seed: int = 0) -> pid.Signals:
    """A random motion that a model with the five default effects has been evaluated on."""
    model = pid.Model.nominal(robot)
    theta = model.theta.copy()
    theta[60:] = np.random.default_rng(seed).uniform(0.5, 2.0, size=24)
    return pid.Model(robot, model.effects, theta).refer(random_motion(robot, seed))


@pytest.mark.parametrize("name", EFFECTS)
def test_shapes_names_and_units(name: str, ur5: pid.Robot) -> None:
    effect, signals = ready(name, ur5), motion(ur5)
    columns = effect.columns(ur5)
    assert effect.name == name
    assert effect.regressor(ur5, signals).shape == (len(signals.time), 6, len(columns))
    assert len({c.name for c in columns}) == len(columns)
    assert all(c.unit and 1 <= c.joint <= 6 and c.effect == name for c in columns)
    assert effect.acts_on in ("plant", "measurement", "sensor")
    assert effect.family in Family
    assert effect.nominal(ur5).shape == (len(columns),)
    pattern = effect.pattern(ur5)
    assert len({tuple(p) for p in pattern.tolist()}) == len(pattern)
    if name != "rigid_body":
        assert effect.signature
        assert effect.mistaken_for


@pytest.mark.parametrize("name", EFFECTS)
def test_regressor_times_parameters_is_the_model_torque(name: str, ur5: pid.Robot) -> None:
    """A model's torque is the sum of its effects' regressors times their parameters, at the model's own reference."""
    effect = ready(name, ur5)
    rng = np.random.default_rng(1)
    base = pid.Model.nominal(ur5)
    effects = (*base.effects, effect) if name not in {e.name for e in base.effects} else base.effects
    count = len(effect.columns(ur5)) if len(effects) > 5 else 0
    model = pid.Model(ur5, effects, np.concatenate([base.theta, 0.01 * rng.normal(size=count)]))
    signals = model.refer(random_motion(ur5, 2))
    Y = np.concatenate([e.regressor(ur5, signals) for e in effects], axis=2)
    np.testing.assert_allclose(Y @ model.theta, model.torque(random_motion(ur5, 2)), atol=1e-9)


@pytest.mark.parametrize("name", EFFECTS)
def test_finite_at_standstill(name: str, ur5: pid.Robot) -> None:
    still = replace(random_motion(ur5, 0), **{k: np.zeros((400, 6)) for k in "qva"})
    signals = pid.Model.nominal(ur5).refer(still)
    assert np.isfinite(ready(name, ur5).regressor(ur5, signals)).all()


@pytest.mark.parametrize("name", EFFECTS)
def test_the_nominal_robot_lies_inside_the_cones(name: str, ur5: pid.Robot) -> None:
    effects = (ready(name, ur5),) if name == "rigid_body" else (ready("rigid_body", ur5), ready(name, ur5))
    theta = np.concatenate([effect.nominal(ur5) for effect in effects])
    cones = physical_cones(ur5, effects)
    assert len(cones.matrices) == 6
    assert cones.broken(theta) == []
    assert cones.broken(-theta) != []


@pytest.mark.parametrize("name", EFFECTS)
def test_survives_json(name: str, ur5: pid.Robot) -> None:
    effect = ready(name, ur5)
    assert effect_from_dict(effect.as_dict()) == effect


@pytest.mark.parametrize("name", [n for n in EFFECTS if pid.CATALOGUE[n].scope is Scope.JOINT])
def test_restricted_to_joints_it_is_that_part_of_the_whole(name: str, ur5: pid.Robot) -> None:
    signals = motion(ur5)
    some, every = ready(name, ur5, (2, 5)), ready(name, ur5)
    assert {c.joint for c in some.columns(ur5)} == {2, 5}
    chosen = [i for i, c in enumerate(every.columns(ur5)) if c.joint in (2, 5)]
    np.testing.assert_array_equal(some.regressor(ur5, signals), every.regressor(ur5, signals)[:, :, chosen])
    with pytest.raises(pid.InputError, match="joint 7 does not exist"):
        ready(name, ur5, (7,)).columns(ur5)


@pytest.mark.parametrize("name", [n for n in EFFECTS if pid.CATALOGUE[n].pointwise])
def test_pointwise_effects_have_no_memory(name: str, ur5: pid.Robot) -> None:
    effect, signals = ready(name, ur5), motion(ur5)
    whole = effect.values(ur5, signals)
    part = effect.values(ur5, signals.part(slice(100, 110)))
    np.testing.assert_allclose(part, whole[:, 100:110], atol=1e-9)


@pytest.mark.parametrize("name", EFFECTS)
def test_places_are_joints_that_the_effect_accepts(name: str, ur5: pid.Robot) -> None:
    cls = pid.CATALOGUE[name]
    places = cls.places(ur5)
    assert places
    for place in places:
        columns = cls.at_grid_middle(ur5, place or None).columns(ur5)
        assert not place or {column.joint for column in columns} == {place[0]}
        assert cls.search_options(ur5, place, [motion(ur5)])
    if cls.scope is Scope.WHOLE_ARM:
        with pytest.raises(pid.InputError, match="whole arm"):
            cls(joints=(1,))


@pytest.mark.parametrize("name", [n for n in EFFECTS if pid.CATALOGUE[n].formulas or n == "coupled_friction"])
def test_exported_source_is_the_torque(name: str, ur5: pid.Robot) -> None:
    effect, signals = ready(name, ur5, (5, 2)), motion(ur5)
    theta = np.random.default_rng(3).uniform(0.5, 2.0, size=len(effect.columns(ur5)))
    source = effect.numpy_source(ur5, theta)
    assert source is not None
    known = {key: getattr(signals, key) for key in ("q", "v", "a", "load", "motor")}
    known["t"] = (signals.time - signals.origin)[:, None]
    known["z"] = np.zeros_like(signals.v)
    if (advance := effect.advance_source(ur5)) is not None:
        for k in range(1, len(signals.time)):
            mean = 0.5 * (signals.v[k - 1] + signals.v[k])
            step = {"z": known["z"][k - 1], "v": mean, "dt": 1 / signals.rate}
            known["z"][k] = eval(advance, {"np": np}, step)
    found = eval(source, {"np": np}, known)
    np.testing.assert_allclose(found, effect.regressor(ur5, signals) @ theta, rtol=1e-12, atol=1e-12)


def test_ripple_is_searched_at_the_orders_of_the_motor(ur5: pid.Robot) -> None:
    assert ur5.drives is not None
    cls = pid.CATALOGUE["torque_ripple"]
    (shape,) = cls.shape_parameters
    ratio = ur5.drives[1].gear_ratio
    grid = cls.search_grid(ur5, (2,), shape)
    # a strain-wave gear makes two periods a turn of the motor, an offset of a current sensor one for each of its two to six pairs of poles,
    # unequal gains of the sensors twice as many
    assert {*shape.grid, *(periods * ratio for periods in (1, 2, 3, 4, 5, 6, 8, 10, 12))} <= set(grid)
    assert len(grid) == len(set(grid))
    assert max(grid) == 12 * ratio
    direct = replace(ur5, drives=tuple(replace(drive, gear_ratio=1.0) for drive in ur5.drives))
    assert cls.search_grid(direct, (2,), shape) == shape.grid
    assert cls.search_grid(replace(ur5, drives=None), (2,), shape) == shape.grid


def test_a_ripple_must_repeat_to_be_looked_for(ur5: pid.Robot) -> None:
    """A quarter of a turn shows two periods of order 8, and not of order 7, which may be any bend."""
    cls, signals = pid.CATALOGUE["torque_ripple"], motion(ur5)
    q = signals.q.copy()
    q[:, 1] = np.linspace(-np.pi / 4, np.pi / 4, len(q)) * 1.000001
    q[:, 2] = 0.3
    orders = [effect.order[0] for effect in cls.search_options(ur5, (2,), [replace(signals, q=q)])]
    assert min(orders) == 8.0
    assert max(orders) > 40.0  # of the motor
    assert not cls.search_options(ur5, (3,), [replace(signals, q=q)])


def test_warm_up_is_searched_within_the_recording_and_by_temperature(ur5: pid.Robot) -> None:
    cls, cold = pid.CATALOGUE["warm_up"], replace(motion(ur5), temperature=None)  # 20 s
    assert [effect.time_constant for effect in cls.search_options(ur5, (1,), [cold])] == [(3.0,), (6.0,), (12.0,)]
    warm = replace(cold, temperature=np.linspace(20.0, 30.0, len(cold.time))[:, None] * np.ones(6))
    *_, last = cls.search_options(ur5, (1,), [warm])
    assert (last.time_constant, last.reference_temperature) == (None, 20.0)
    *_, last = cls.search_options(ur5, (1,), [warm, cold])
    assert last.reference_temperature is None


def test_friction_takes_energy(ur5: pid.Robot) -> None:
    signals = motion(ur5)
    names = ("viscous_friction", "coulomb_friction", "nonlinear_viscous_friction", "load_dependent_friction")
    for name in (*names, "stribeck_friction", "presliding_hysteresis"):
        effect = ready(name, ur5)
        power = (effect.regressor(ur5, signals) @ np.ones(len(effect.columns(ur5)))) * signals.v
        assert power.sum() > 0, name
        if name != "presliding_hysteresis":  # a bent bristle gives back a part of what it took
            assert (power >= 0).all(), name


@pytest.mark.parametrize("width", [None, 0.01])
def test_velocity_friction_is_the_stated_law(width: float | None, ur5: pid.Robot) -> None:
    """Of single states; the sign of all dry friction turns over the width of the arm's own, or sharply."""
    signals = replace(motion(ur5), transition=None if width is None else np.full(6, width))
    v = signals.v[:, 2]
    smooth = np.tanh(v / (width or 1e-3))
    assert signals.load is not None
    laws = {
        "viscous_friction": v,
        "coulomb_friction": smooth,
        "friction_asymmetry": np.abs(v),
        "stribeck_friction": smooth * np.exp(-((v / 0.1) ** 2)),
        "nonlinear_viscous_friction": np.sign(v) * np.abs(v) ** 1.5,
        "load_dependent_friction": smooth * np.abs(signals.load[:, 2]),
        "joint_spring": signals.q[:, 2],
        "rotor_inertia": signals.a[:, 2],
        "torque_offset": np.ones_like(v),
    }
    for name, law in laws.items():
        np.testing.assert_allclose(ready(name, ur5).regressor(ur5, signals)[:, 2, 2], law, atol=1e-12, err_msg=name)
    coupled = pid.CATALOGUE["coupled_friction"](joints=(5, 6)).regressor(ur5, signals)
    together = signals.v[:, 4] + signals.v[:, 5]
    for row in (4, 5):
        np.testing.assert_allclose(coupled[:, row], np.column_stack([np.tanh(together / 1e-3), together]), atol=1e-12)
    assert np.abs(coupled[:, :4]).max() == 0


def test_bristle_follows_its_differential_equation() -> None:
    """Against a fine explicit integration, and against the closed form at constant velocity."""
    from physident.effects.hysteresis import bristle

    rate, xs = 200.0, np.array([0.01])
    time = np.arange(600) / rate
    constant = bristle(np.full((1, 600), 0.05), xs, rate)[0]
    np.testing.assert_allclose(constant, 0.01 * (1 - np.exp(-0.05 * time / 0.01)), atol=1e-12)
    fine = np.arange(600 * 50) / (rate * 50)

    def speed(t: np.ndarray) -> np.ndarray:
        return 0.1 * np.sin(2 * np.pi * 0.7 * t) + 0.03

    z, reference = 0.0, []
    for k, v in enumerate(speed(fine)):
        if k % 50 == 0:
            reference.append(z)
        z += (v - abs(v) * z / 0.01) / (rate * 50)
    found = bristle(speed(time)[None], xs, rate)[0]
    np.testing.assert_allclose(found, reference, atol=2e-4)
    assert np.abs(found).max() <= 0.01


def test_ripple_is_periodic_in_the_angle(ur5: pid.Robot) -> None:
    signals = motion(ur5)
    effect = pid.CATALOGUE["torque_ripple"](joints=(3,), order=(7.0,))
    turned = replace(signals, q=signals.q + 2 * np.pi / 7)
    np.testing.assert_allclose(effect.values(ur5, turned), effect.values(ur5, signals), atol=1e-9)
    np.testing.assert_allclose((effect.values(ur5, signals) ** 2).sum(axis=0), 1.0, atol=1e-12)
    assert effect.cutoff_needed(ur5, signals) == pytest.approx(7 * np.abs(signals.v[:, 2]).max() / 2 / np.pi)


def test_warm_up_fades_from_the_recordings_start(ur5: pid.Robot) -> None:
    signals = motion(ur5)
    effect = pid.CATALOGUE["warm_up"](joints=(1,), time_constant=(6.0,))
    dry, viscous = effect.values(ur5, signals)
    np.testing.assert_allclose(viscous, signals.v[:, 0] * np.exp(-signals.time / 6), atol=1e-12)
    late = effect.values(ur5, replace(signals, time=signals.time + 12, origin=0.0))
    np.testing.assert_allclose(late[0], dry * np.exp(-2), atol=1e-12)
    warm = pid.CATALOGUE["warm_up"](joints=(1,), reference_temperature=20.0)
    assert signals.temperature is not None
    np.testing.assert_allclose(
        warm.values(ur5, signals)[1], signals.v[:, 0] * (signals.temperature[:, 0] - 20), atol=1e-12
    )
    with pytest.raises(pid.InputError, match="no temperature channel"):
        warm.values(ur5, replace(signals, temperature=None))


def test_neighbouring_pairs_that_share_a_joint_are_different_effects(ur5: pid.Robot) -> None:
    pairs = [pid.CATALOGUE["coupled_friction"](joints=joints) for joints in ((1, 2), (2, 3))]
    assert len(pid.make_effects(pairs)) == 2
    with pytest.raises(pid.InputError, match="given twice"):
        pid.make_effects([*pairs, pairs[0]])
