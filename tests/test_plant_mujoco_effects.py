"""The hidden effects of the plant in MuJoCo: each acts as its name says."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from tests.plant_mujoco.expected import (
    KINDS,
    PLANT,
    load_of,
    model_of,
    rnea,
    simulated,
    sliding,
    steady_friction,
    still,
)
from tests.plant_mujoco.samples import Kind, sample, sines
from tests.truth import ArmTruth, HiddenEffect, Run

Array = NDArray[np.float64]


PLAIN, RUN = simulated("seven", "smooth", 3.0)
SPEED, TIME = RUN.v, RUN.time
MODEL = model_of(PLAIN)
LOAD = rnea(MODEL, RUN.q, RUN.v, RUN.a)
TORQUE = PLANT.torque_along(PLAIN, RUN)
SIGN = np.sign(SPEED)


def _row(joint: int, values: Array | float) -> Array:
    row = np.zeros_like(SPEED)
    row[:, joint - 1] = values
    return row


def _with_body(link: int, mass: float, centre: Array) -> Array:
    model = model_of(PLAIN)
    model.inertias[link] = model.inertias[link] + pin.Inertia(mass, centre, 0.4 * mass * 0.05**2 * np.eye(3))
    return rnea(model, RUN.q, RUN.v, RUN.a) - LOAD


def _tilted(angle: float, way: float) -> Array:
    model, down = model_of(PLAIN), np.array([0.0, 0.0, -1.0])
    model.gravity.linear = 9.81 * pin.exp3(angle * np.cross(down, [np.cos(way), np.sin(way), 0.0])) @ down
    return rnea(model, RUN.q, RUN.v, RUN.a) - LOAD


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
        lambda: _row(1, 0.5 * np.exp(-TIME / 2) * steady_friction(PLAIN, SPEED)[:, 0]),  # breakaway's rest included
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
    "torque_delay": (
        (4,),
        0.008,
        {},
        lambda: _row(4, CubicSpline(TIME, TORQUE[:, 3])(np.maximum(TIME - 0.008, 0)) - TORQUE[:, 3]),
    ),
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
        lambda: rnea(MODEL, RUN.q + 0.02 * np.eye(7)[2], RUN.v, RUN.a) - LOAD,
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


@pytest.mark.slow
@pytest.mark.parametrize("effect", [*NAMED, "joint_elasticity", "swinging_load", "flexible_base"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_run_with_an_effect_needs_the_torque_of_the_arm_with_it(effect: str, kind: Kind) -> None:
    sizes = {"joint_elasticity": ((2,), 1e-4), "swinging_load": ((), 1.0)}
    joints, size = sizes.get(effect, NAMED.get(effect, ((), 2e-5)))[:2]
    shape = NAMED[effect][2] if effect in NAMED else {}
    hidden = HiddenEffect(effect=effect, joints=joints, size=size, shape=shape)
    arm, run = simulated("seven", kind, 2.5, effects=(hidden,))
    miss = np.abs(PLANT.torque_along(arm, run) - run.torque)
    rows = sliding(run) & np.isfinite(miss)
    miss = miss[rows]
    assert rows.sum() > 1000
    assert np.quantile(miss, 0.99) < 0.02
    without = np.abs(PLANT.torque_along(replace(arm, effects=()), run) - run.torque)[rows]
    assert np.sqrt(np.mean(miss**2)) < 0.3 * np.sqrt(np.mean(without**2))


def _held(effect: str, joints: tuple[int, ...], size: float, **shape: Any) -> tuple[ArmTruth, Run]:
    hidden = HiddenEffect(effect=effect, joints=joints, size=size, shape=shape)
    arm = sample("seven", "smooth", effects=(hidden,))
    return arm, PLANT.simulate(arm, still(7, 0.2))


def test_an_elastic_gear_lets_the_link_sag_by_its_torque() -> None:
    arm, run = _held("joint_elasticity", (2,), 1e-3)
    q, zero = run.q[:1] - 1e-3 * run.torque[:1] * np.eye(7)[1], np.zeros((1, 7))
    np.testing.assert_allclose(run.torque[0], rnea(model_of(arm), q, zero, zero)[0], atol=2e-3)


def test_a_flexible_base_tilts_by_the_moment_of_the_arms_weight() -> None:
    arm, run = _held("flexible_base", (), 1e-4)
    model = model_of(arm)
    data = model.createData()
    centre = pin.centerOfMass(model, data, run.q[0])
    moment = np.cross(centre, [0, 0, -9.81 * arm.links[:, 0].sum()])
    model.gravity.linear = pin.exp3(-1e-4 * moment) @ np.array([0, 0, -9.81])
    zero = np.zeros((1, 7))
    np.testing.assert_allclose(run.torque[0], rnea(model, run.q[:1], zero, zero)[0], atol=0.02)


def test_a_swinging_load_hangs_and_then_swings_at_its_own_rate() -> None:
    hidden = HiddenEffect(effect="swinging_load", joints=(), size=1.0, shape={"length": 0.25})
    arm = sample("seven", "smooth", effects=(hidden,))
    run = PLANT.simulate(arm, sines(7, 8.0, scale=0.1, rest=5.0))
    model = model_of(arm)
    J = pin.computeFrameJacobian(model, model.createData(), run.q[0], model.getFrameId("tool"), pin.LOCAL_WORLD_ALIGNED)
    zero = np.zeros((1, 7))
    hung = rnea(model, run.q[:1], zero, zero)[0] + J[2] * 9.81
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
    rigid = np.abs(load_of(arm, run)[:, 0] - arm.rotor_inertia[0] * run.a[:, 0])
    assert np.count_nonzero(alone & (rigid > 0.3)) > 10


def test_a_dropped_load_leaves_the_arm_its_speed() -> None:
    hidden = HiddenEffect(effect="dropped_load", joints=(), size=3.0, shape={"time": 1.2})
    arm = sample("seven", "smooth", effects=(hidden,))
    run = PLANT.simulate(arm, sines(7))
    k = int(np.searchsorted(run.time, 1.2 - 1e-9))
    assert np.abs(run.v[k] - run.v[k - 1]).max() < 0.05
    assert np.abs(run.torque[k] - run.torque[k - 1]).max() < 2.0
    assert np.abs(run.a[k] - run.a[k - 1]).max() > 2.0
