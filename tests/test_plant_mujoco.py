"""The plant in MuJoCo: its physics against pinocchio and closed forms that know nothing of its integrator."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

from tests.plant_mujoco import MujocoPlant
from tests.plant_mujoco.samples import Kind, Sines, sample, sines
from tests.truth import ArmTruth, Disturbance, HiddenEffect, Run

Array = NDArray[np.float64]
PLANT = MujocoPlant()
MOVING = 2e-3  # rad/s
KINDS: tuple[Kind, ...] = ("dry", "bristle", "smooth")


def _model(arm: ArmTruth) -> Any:
    model = pin.buildModelFromXML(arm.urdf)
    for i, link in enumerate(arm.links, 1):
        model.inertias[i] = pin.Inertia.FromDynamicParameters(link)
    return model


def _rnea(model: Any, q: Array, v: Array, a: Array) -> Array:
    data = model.createData()
    return np.array([pin.rnea(model, data, *state) for state in zip(q, v, a, strict=True)])


def _load(arm: ArmTruth, run: Run) -> Array:
    return _rnea(_model(arm), run.q, run.v, run.a) + arm.rotor_inertia * run.a


def _still(n: int, duration: float = 2.0) -> Sines:
    return sines(n, duration, scale=0.0)


def _simulated(name: str, kind: Kind, duration: float = 4.0, **changes: Any) -> tuple[ArmTruth, Run]:
    arm = sample(name, kind, **changes)
    return arm, PLANT.simulate(arm, sines(arm.joints, duration))


def _sliding(run: Run) -> NDArray[np.bool_]:
    """Where joints move and do not stop or turn back within a step."""
    way = np.sign(run.v)
    stops = np.zeros_like(run.v, dtype=bool) if run.at_rest is None else run.at_rest
    return (np.abs(run.v) > MOVING) & (np.roll(way, 1, axis=0) == way) & (np.roll(way, -1, axis=0) == way) & ~stops


def _friction(arm: ArmTruth, v: Array) -> Array:
    """Steady friction away from zero speed."""
    f = arm.friction
    peak = (f.breakaway - f.coulomb) * np.exp(-((v / f.stribeck_speed) ** 2))
    return np.sign(v) * (f.coulomb + peak) + f.viscous * v


@pytest.mark.parametrize("name", ["planar", "scara", "seven"])
def test_without_friction_the_torque_is_that_of_inertia_and_gravity(name: str) -> None:
    arm, run = _simulated(name, "smooth", 2.0, strength=0.0)
    np.testing.assert_allclose(run.torque, _load(arm, run), atol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_positions_velocities_and_accelerations_belong_together(kind: Kind) -> None:
    arm, run = _simulated("seven", kind, 3.0)
    np.testing.assert_allclose(CubicSpline(run.time, run.q)(run.time, 1)[5:-5], run.v[5:-5], atol=2e-3)
    np.testing.assert_allclose(run.v[0] + np.cumsum(run.a, axis=0)[:-1] * 5e-4, run.v[1:], atol=2e-2)
    np.testing.assert_allclose(run.q, sines(arm.joints, 3.0).states(run.time)[0], atol=2e-2)


@pytest.mark.parametrize("name", ["planar", "scara", "seven"])
def test_the_motors_work_becomes_energy_and_heat(name: str) -> None:
    arm, run = _simulated(name, "dry")
    model, step = _model(arm), run.time[1]
    data = model.createData()

    def energy(k: int) -> float:
        moving = 0.5 * float(np.sum(arm.rotor_inertia * run.v[k] ** 2))
        height = pin.computePotentialEnergy(model, data, run.q[k])
        return moving + height + pin.computeKineticEnergy(model, data, run.q[k], run.v[k])

    work = float(np.sum(run.torque * run.v)) * step
    heat = float(np.sum(_friction(arm, run.v) * run.v)) * step
    assert heat > 0
    assert work - heat == pytest.approx(energy(-1) - energy(0), abs=1e-3 * heat)


def test_a_stuck_joint_does_not_creep() -> None:
    push = HiddenEffect(
        effect="contact", joints=(), size=8.0, shape={"start": 0.5, "end": 9.5, "direction": (1.0, 0, 0)}
    )
    run = PLANT.simulate(sample(effects=(push,)), _still(2, 10.0))
    assert run.at_rest is not None
    assert run.at_rest.all()
    assert np.ptp(run.q, axis=0).max() < 1e-7


@dataclass(frozen=True)
class Rising(Disturbance):
    """A torque [N m] on the first joint that grows with time."""

    rate: float

    def resist(self, time: float, q: Array, v: Array) -> Array | None:
        return np.concatenate([[self.rate * time], np.zeros(len(q) - 1)])


def test_a_joint_breaks_away_at_the_stated_torque() -> None:
    arm = sample(disturbances=(Rising(4.0),))
    run = PLANT.simulate(arm, _still(2, 3.0))
    began = run.time[np.argmax(np.abs(run.v[:, 0]) > 1e-6)]
    assert 4.0 * began == pytest.approx(arm.friction.breakaway[0], abs=4.0 * 2e-3)


def test_dry_friction_opposes_every_motion() -> None:
    arm, run = _simulated("seven", "dry")
    moving = _sliding(run)
    opposing = (run.torque - _load(arm, run)) * run.v
    assert opposing[moving].min() > 0
    slid = np.where(moving, run.torque - _load(arm, run) - _friction(arm, run.v), 0.0)
    assert np.sqrt(np.mean(slid**2)) < 2e-3
    assert run.at_rest is not None
    held = np.abs(run.torque - _load(arm, run))[run.at_rest[:, 0], 0]
    assert held.max() < arm.friction.breakaway[0] + 1e-2


def test_bristles_never_give_more_work_than_they_store() -> None:
    arm, run = _simulated("seven", "bristle")
    f = arm.friction
    force = run.torque - _load(arm, run) - f.viscous * run.v
    work = np.cumsum(force * run.v, axis=0) * run.time[1]
    assert work.min() > -1e-6
    assert np.abs(force).max(axis=0) == pytest.approx(f.breakaway, rel=0.3)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["planar", "scara", "seven"])
def test_torque_along_the_plants_own_motion_is_what_it_reported(name: str, kind: Kind) -> None:
    arm, run = _simulated(name, kind)
    along = PLANT.torque_along(arm, run)
    moving = _sliding(run)
    assert np.isfinite(along[moving]).all()
    assert np.sqrt(np.mean((along - run.torque)[moving] ** 2)) < 2e-3
    if run.at_rest is not None:
        assert np.isnan(along[run.at_rest]).all()
    else:
        assert np.isfinite(along).all()


def test_halving_the_step_changes_the_filtered_torque_by_less_than_a_hundredth_of_noise() -> None:
    arm, coarse = _simulated("seven", "dry")
    fine = PLANT.simulate(arm, sines(7), step=coarse.time[1] / 2)
    slow = [sosfiltfilt(butter(2, 8.0, fs=1 / r.time[1], output="sos"), r.torque, axis=0) for r in (coarse, fine)]
    moving = np.abs(coarse.v) > 0.02
    assert np.sqrt(np.mean((slow[0] - slow[1][::2])[moving] ** 2)) < 3e-3


PLAIN, RUN = _simulated("seven", "smooth", 3.0)
SPEED, TIME = RUN.v, RUN.time
MODEL = _model(PLAIN)
LOAD = _rnea(MODEL, RUN.q, RUN.v, RUN.a)
TORQUE = PLANT.torque_along(PLAIN, RUN)
SIGN = np.sign(SPEED)


def _row(joint: int, values: Array | float) -> Array:
    row = np.zeros_like(SPEED)
    row[:, joint - 1] = values
    return row


def _with_body(link: int, mass: float, centre: Array) -> Array:
    model = _model(PLAIN)
    model.inertias[link] = model.inertias[link] + pin.Inertia(mass, centre, 0.4 * mass * 0.05**2 * np.eye(3))
    return _rnea(model, RUN.q, RUN.v, RUN.a) - LOAD


def _tilted(angle: float, way: float) -> Array:
    model, down = _model(PLAIN), np.array([0.0, 0.0, -1.0])
    model.gravity.linear = 9.81 * pin.exp3(angle * np.cross(down, [np.cos(way), np.sin(way), 0.0])) @ down
    return _rnea(model, RUN.q, RUN.v, RUN.a) - LOAD


def _pushed(force: Array, start: float, end: float) -> Array:
    data, out = MODEL.createData(), np.zeros_like(SPEED)
    for k in np.flatnonzero((start - 1e-9 < TIME) & (end - 1e-9 > TIME)):
        J = pin.computeFrameJacobian(MODEL, data, RUN.q[k], MODEL.getFrameId("tool"), pin.LOCAL_WORLD_ALIGNED)
        out[k] = J[:3].T @ force
    return out


def _dahl(v: Array, slip: float) -> Array:
    z = np.zeros_like(v)
    for k, move in enumerate(v[:-1] * TIME[1]):
        end = slip * np.sign(move)
        z[k + 1] = end + (z[k] - end) * np.exp(-abs(move) / slip)
    return z


COM = np.array([0.03, -0.02, 0.14])
NAMED: dict[str, tuple[tuple[int, ...], float, dict[str, Any], Any]] = {
    "rotor_inertia": ((2,), 0.2, {}, lambda: _row(2, 0.2 * RUN.a[:, 1])),
    "viscous_friction": ((2,), 3.0, {}, lambda: _row(2, 3.0 * SPEED[:, 1])),
    "coulomb_friction": ((2,), 3.0, {}, lambda: _row(2, 3.0 * SIGN[:, 1])),
    "friction_asymmetry": ((2,), 2.0, {}, lambda: _row(2, 2.0 * np.abs(SPEED[:, 1]))),
    "stribeck_friction": (
        (2,),
        2.0,
        {"stribeck_speed": 0.2},
        lambda: _row(2, 2.0 * SIGN[:, 1] * np.exp(-((SPEED[:, 1] / 0.2) ** 2))),
    ),
    "nonlinear_viscous_friction": ((3,), 2.0, {}, lambda: _row(3, 2.0 * SIGN[:, 2] * np.sqrt(np.abs(SPEED[:, 2])))),
    "load_dependent_friction": ((2,), 0.1, {}, lambda: _row(2, 0.1 * SIGN[:, 1] * np.abs(LOAD[:, 1]))),
    "presliding_hysteresis": ((2,), 300.0, {}, lambda: _row(2, 300.0 * _dahl(SPEED[:, 1], 0.01))),
    "warm_up": (
        (1,),
        0.5,
        {"time": 2.0},
        lambda: _row(1, 0.5 * np.exp(-TIME / 2) * (4.0 * SIGN[:, 0] + 3.0 * SPEED[:, 0])),
    ),
    "coupled_friction": (
        (4, 5),
        1.5,
        {"viscous": 0.5},
        lambda: sum(
            _row(j, 1.5 * np.sign(SPEED[:, 3] + SPEED[:, 4]) + 0.5 * (SPEED[:, 3] + SPEED[:, 4])) for j in (4, 5)
        ),
    ),
    "torque_constant": ((2,), 0.05, {}, lambda: _row(2, 0.05 * TORQUE[:, 1])),
    "torque_offset": ((2,), 2.0, {}, lambda: _row(2, 2.0)),
    "time_delay": ((), 0.004, {}, lambda: CubicSpline(TIME, TORQUE)(np.maximum(TIME - 0.004, 0)) - TORQUE),
    "torque_ripple": ((2,), 2.0, {}, lambda: _row(2, 2.0 * np.sin(12 * RUN.q[:, 1] + 0.5))),
    "joint_spring": ((2,), 10.0, {}, lambda: _row(2, 10.0 * RUN.q[:, 1])),
    "payload": ((), 1.5, {}, lambda: _with_body(7, 1.5, COM)),
    "link_inertia": ((3,), 1.0, {}, lambda: _with_body(3, 1.0, MODEL.inertias[3].lever)),
    "gravity_tilt": ((), 0.1, {}, lambda: _tilted(0.1, 0.7)),
    "joint_zero_offset": (
        (3,),
        0.02,
        {},
        lambda: _rnea(MODEL, RUN.q + 0.02 * np.eye(7)[2], RUN.v, RUN.a) - LOAD,
    ),
    "contact": (
        (),
        10.0,
        {"start": 1.0, "end": 2.0, "direction": (0.5, 0.0, 1.0)},
        lambda: _pushed(np.array([5.0, 0.0, 10.0]), 1.0, 2.0),
    ),
    "dropped_load": ((), 1.5, {"time": 1.2}, lambda: _with_body(7, 1.5, COM) * (TIME < 1.2 - 1e-9)[:, None]),
}


@pytest.mark.parametrize("effect", NAMED)
def test_an_effect_acts_as_its_name_says(effect: str) -> None:
    joints, size, shape, expected = NAMED[effect]
    hidden = HiddenEffect(effect=effect, joints=joints, size=size, shape=shape)
    change = PLANT.torque_along(replace(PLAIN, effects=(hidden,)), RUN) - TORQUE
    far = np.isfinite(change) & (np.abs(SPEED) > 0.2).all(axis=1, keepdims=True)
    far &= np.abs(SPEED[:, [3]] + SPEED[:, [4]]) > 0.05
    tolerance = 2e-2 if effect == "presliding_hysteresis" else 1e-6
    assert far.sum() > 100
    np.testing.assert_allclose(change[far], np.asarray(expected())[far], atol=tolerance)


@pytest.mark.parametrize("effect", [*NAMED, "joint_elasticity", "swinging_load", "flexible_base"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_run_with_an_effect_needs_the_torque_of_the_arm_with_it(effect: str, kind: Kind) -> None:
    sizes = {"joint_elasticity": ((2,), 1e-4), "swinging_load": ((), 1.0)}
    joints, size = sizes.get(effect, NAMED.get(effect, ((), 2e-5)))[:2]
    shape = NAMED[effect][2] if effect in NAMED else {}
    hidden = HiddenEffect(effect=effect, joints=joints, size=size, shape=shape)
    arm, run = _simulated("seven", kind, 2.5, effects=(hidden,))
    miss = np.abs(PLANT.torque_along(arm, run) - run.torque)
    rows = _sliding(run) & np.isfinite(miss)
    miss = miss[rows]
    assert rows.sum() > 1000
    assert np.quantile(miss, 0.99) < 0.02
    without = np.abs(PLANT.torque_along(replace(arm, effects=()), run) - run.torque)[rows]
    assert np.sqrt(np.mean(miss**2)) < 0.3 * np.sqrt(np.mean(without**2))


def _held(effect: str, joints: tuple[int, ...], size: float, **shape: Any) -> tuple[ArmTruth, Run]:
    hidden = HiddenEffect(effect=effect, joints=joints, size=size, shape=shape)
    arm = sample("seven", "smooth", effects=(hidden,))
    return arm, PLANT.simulate(arm, _still(7, 0.2))


def test_an_elastic_gear_lets_the_link_sag_by_its_torque() -> None:
    arm, run = _held("joint_elasticity", (2,), 1e-3)
    q, zero = run.q[:1] - 1e-3 * run.torque[:1] * np.eye(7)[1], np.zeros((1, 7))
    np.testing.assert_allclose(run.torque[0], _rnea(_model(arm), q, zero, zero)[0], atol=2e-3)


def test_a_flexible_base_tilts_by_the_moment_of_the_arms_weight() -> None:
    arm, run = _held("flexible_base", (), 1e-4)
    model = _model(arm)
    data = model.createData()
    centre = pin.centerOfMass(model, data, run.q[0])
    moment = np.cross(centre, [0, 0, -9.81 * arm.links[:, 0].sum()])
    model.gravity.linear = pin.exp3(-1e-4 * moment) @ np.array([0, 0, -9.81])
    zero = np.zeros((1, 7))
    np.testing.assert_allclose(run.torque[0], _rnea(model, run.q[:1], zero, zero)[0], atol=0.02)


def test_a_swinging_load_hangs_and_then_swings_at_its_own_rate() -> None:
    hidden = HiddenEffect(effect="swinging_load", joints=(), size=1.0, shape={"length": 0.25})
    arm = sample("seven", "smooth", effects=(hidden,))
    run = PLANT.simulate(arm, sines(7, 8.0, scale=0.1, rest=5.0))
    model = _model(arm)
    J = pin.computeFrameJacobian(model, model.createData(), run.q[0], model.getFrameId("tool"), pin.LOCAL_WORLD_ALIGNED)
    zero = np.zeros((1, 7))
    hung = _rnea(model, run.q[:1], zero, zero)[0] + J[2] * 9.81
    np.testing.assert_allclose(run.torque[0], hung, atol=0.01)
    after = run.torque[run.time > 3.2, 0]
    spectrum = np.abs(np.fft.rfft(np.hanning(len(after)) * (after - after.mean()), 2**17))
    rate = 2 * np.pi * np.fft.rfftfreq(2**17, run.time[1])[np.argmax(spectrum)]
    assert rate == pytest.approx(np.sqrt(9.81 / 0.25), rel=0.05)


def test_in_the_play_of_a_gear_the_motor_moves_its_rotor_alone() -> None:
    hidden = HiddenEffect(effect="backlash", joints=(1,), size=0.02)
    arm = sample("scara", "smooth", strength=0.0, effects=(hidden,))
    run = PLANT.simulate(arm, sines(4))
    alone = np.abs(run.torque - arm.rotor_inertia * run.a)[:, 0] < 0.02
    rigid = np.abs(_load(arm, run)[:, 0] - arm.rotor_inertia[0] * run.a[:, 0])
    assert np.count_nonzero(alone & (rigid > 0.3)) > 10


def test_a_dropped_load_leaves_the_arm_its_speed() -> None:
    hidden = HiddenEffect(effect="dropped_load", joints=(), size=3.0, shape={"time": 1.2})
    arm = sample("seven", "smooth", effects=(hidden,))
    run = PLANT.simulate(arm, sines(7))
    k = int(np.searchsorted(run.time, 1.2 - 1e-9))
    assert np.abs(run.v[k] - run.v[k - 1]).max() < 0.05
    assert np.abs(run.torque[k] - run.torque[k - 1]).max() < 2.0
    assert np.abs(run.a[k] - run.a[k - 1]).max() > 2.0


@dataclass(frozen=True)
class Weak(Disturbance):
    """Drives that deliver less than is asked, and an instrument that shows more."""

    share: float

    def deliver(self, time: float, v: Array, torque: Array) -> Array:
        return torque - self.share * torque**3 / 1e4

    def report(self, time: Array, q: Array, v: Array, torque: Array) -> Array:
        return torque + self.share


@pytest.mark.parametrize("disturbance", [Weak(0.2), Rising(1.0)])
def test_disturbances_act_in_motion_and_along_it(disturbance: Disturbance) -> None:
    arm = sample("planar", "smooth", disturbances=(disturbance,))
    run = PLANT.simulate(arm, sines(2))
    np.testing.assert_allclose(PLANT.torque_along(arm, run), run.torque, atol=0.02)
    plain = PLANT.torque_along(replace(arm, disturbances=()), run)
    shown = run.torque - 0.2 if isinstance(disturbance, Weak) else run.torque
    acts = disturbance.deliver(0.0, run.v, shown) - plain
    assert np.abs(acts - (0.0 if isinstance(disturbance, Weak) else run.time[:, None] * [1, 0])).max() < 0.02


def test_a_warmer_arm_rubs_less() -> None:
    arm = sample("planar", "smooth")
    run = PLANT.simulate(arm, sines(2), warmer=10.0)
    assert run.temperature.mean() == pytest.approx(35.0)
    far = np.abs(run.v) > 0.3
    rubs = (run.torque - _load(arm, run))[far] / _friction(arm, run.v)[far]
    np.testing.assert_allclose(rubs, 0.9, atol=1e-3)


def test_a_setting_that_an_effect_does_not_have_is_refused() -> None:
    with pytest.raises(ValueError, match="no setting"):
        PLANT.simulate(
            sample(effects=(HiddenEffect(effect="payload", joints=(), size=1.0, shape={"lenght": 1}),)), _still(2)
        )
    with pytest.raises(ValueError, match="expected 1 to 2"):
        PLANT.simulate(sample(effects=(HiddenEffect(effect="backlash", joints=(3,), size=1e-3),)), _still(2))


def test_the_plant_knows_neither_the_package_nor_the_other_plant() -> None:
    for file in (Path(__file__).parent / "plant_mujoco").glob("*.py"):
        text = file.read_text(encoding="utf-8")
        assert "physident" not in text
        assert "tests.plant." not in text
