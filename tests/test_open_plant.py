"""The plant for any arm: friction near zero speed and rigid bodies against laws written here, on arms of 1 to 7 joints."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

from tests.conftest import ROOT
from tests.plant.open_plant import PinocchioPlant
from tests.serial_arms import ARMS, Kind, Ramp, Sway, make_arm
from tests.truth import ArmTruth, Disturbance, HiddenEffect, Run

Array = NDArray[np.float64]
PLANT = PinocchioPlant()
KINDS: tuple[Kind, ...] = ("dry", "bristle", "smooth")


def sway(name: str, kind: Kind, *effects: HiddenEffect, **changes: Any) -> tuple[ArmTruth, Run]:
    arm = make_arm(name, kind, effects=effects, **changes)
    size = np.where([joint.kind == "prismatic" for joint in ARMS[name]], 0.08, 0.5)
    return arm, PLANT.simulate(arm, Sway(size))


def model_of(arm: ArmTruth) -> Any:
    model = pin.buildModelFromXML(arm.urdf)
    model.armature[:] = arm.rotor_inertia
    return model


def rigid(arm: ArmTruth, run: Run) -> Array:
    model = model_of(arm)
    data = model.createData()
    return np.array([pin.rnea(model, data, *state) for state in zip(run.q, run.v, run.a, strict=True)])


def hidden(effect: str, joints: tuple[int, ...], size: float, **shape: Any) -> HiddenEffect:
    return HiddenEffect(effect=effect, joints=joints, size=size, shape=shape)


def farthest(one: Array, other: Array) -> float:
    """Largest difference where both are known, relative to the largest torque of its joint."""
    return float(np.nanmax(np.abs(one - other) / np.nanmax(np.abs(other), axis=0)))


@pytest.mark.parametrize("name", ["two", "scara", "seven"])
def test_torque_is_rigid_body_and_friction(name: str) -> None:
    arm, run = sway(name, "smooth", breakaway=2.0)
    friction = 2.0 * np.sin(np.arctan(run.v / 0.004)) + 1.5 * run.v
    np.testing.assert_allclose(run.torque, rigid(arm, run) + friction, atol=1e-9)
    # v and a are derivatives: what is missing is the few milliseconds of each reversal, between the rows
    np.testing.assert_allclose(CubicSpline(run.time, run.q)(run.time, 1), run.v, atol=2e-3)
    assert np.abs(np.median(CubicSpline(run.time, run.q)(run.time, 1) - run.v, axis=0)).max() < 1e-5
    gained = cumulative_trapezoid(run.a, run.time, axis=0, initial=0)
    np.testing.assert_allclose(gained, run.v, atol=0.03)


@pytest.mark.parametrize("name", ["two", "scara", "seven"])
def test_energy_without_friction_is_the_motors_work(name: str) -> None:
    arm, run = sway(name, "smooth", coulomb=1e-12, breakaway=1e-12)
    model = model_of(arm)
    data = model.createData()
    energy = np.array(
        [
            v @ pin.crba(model, data, q) @ v / 2 + pin.computePotentialEnergy(model, data, q)
            for q, v in zip(run.q, run.v, strict=True)
        ]
    )
    power = ((run.torque - 1.5 * run.v) * run.v).sum(axis=1)
    work = CubicSpline(run.time, power).antiderivative()(run.time)
    assert np.ptp(energy) > 0.3  # J
    assert np.abs(energy - energy[0] - work).max() < 1e-3 * np.ptp(energy)


def test_a_stuck_joint_does_not_creep_under_gravity() -> None:
    """A lost load leaves the control pushing upwards; dry friction takes the difference for as long as one looks."""
    arm = make_arm("two", "dry", effects=(hidden("dropped_load", (), 0.3, com=(0.0, 0.0, 0.3), time=1.0),))
    run = PLANT.simulate(arm, Ramp(np.array([0.7, 0.3]), np.zeros(2), duration=6.0))
    assert run.at_rest is not None
    assert run.at_rest.all()
    assert np.ptp(run.q, axis=0).max() < 1e-12
    unbalanced = run.torque[-1] - rigid(arm, run)[-1]
    assert (np.abs(unbalanced) > 0.2).all()
    assert (np.abs(unbalanced) < 2.6).all()


@pytest.mark.parametrize("payload", [0.0, 1.5])
def test_breakaway_happens_at_its_level(payload: float) -> None:
    effects = (hidden("load_dependent_friction", (1,), 0.1), hidden("payload", (), payload or 1e-6))
    arm = make_arm("pendulum", "dry", effects=effects)
    run = PLANT.simulate(arm, Ramp(np.array([0.9]), np.array([0.002]), wait=0.2, duration=6.0))
    assert run.at_rest is not None
    first = int(np.argmin(run.at_rest[:, 0]))
    model = model_of(arm)
    body = pin.Inertia(max(payload, 1e-6), np.array([0.03, -0.02, 0.14]), np.eye(3) * 1e-6)
    model.inertias[1] = model.inertias[1] + body
    load = pin.computeGeneralizedGravity(model, model.createData(), run.q[0])[0]
    level = 2.6 + 0.1 * abs(load)
    assert abs(load) > 1
    assert run.torque[first - 1, 0] - load < level
    assert run.torque[first, 0] - load == pytest.approx(level, rel=2e-3)
    assert not run.at_rest[:, 0].all()


def test_slow_motion_sticks_and_slips_and_fast_motion_does_not() -> None:
    arm = make_arm("pendulum", "dry", coulomb=1.5)
    slow = PLANT.simulate(arm, Ramp(np.zeros(1), np.array([0.003]), duration=5.0))
    fast = PLANT.simulate(arm, Ramp(np.zeros(1), np.array([0.3]), duration=3.0))
    assert slow.at_rest is not None
    assert fast.at_rest is not None
    assert np.count_nonzero(np.diff(slow.at_rest[:, 0].astype(int)) == -1) >= 3
    assert np.count_nonzero(np.diff(fast.at_rest[:, 0].astype(int)) == -1) == 1


def test_dry_friction_takes_energy_in_every_row_that_slides() -> None:
    arm, run = sway("seven", "dry")
    power = (run.torque - rigid(arm, run)) * run.v
    assert run.at_rest is not None
    np.testing.assert_array_equal(run.v[run.at_rest], 0.0)
    np.testing.assert_array_equal(run.a[run.at_rest], 0.0)
    slides = run.v != 0
    assert slides.mean() > 0.5
    assert (power[slides] > 1.99 * np.abs(run.v[slides])).all()
    level = 2.0 + 0.6 * np.exp(-np.abs(run.v) / 0.02) + 1.5 * np.abs(run.v)
    np.testing.assert_allclose(power[slides], (level * np.abs(run.v))[slides], atol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_friction_never_gives_more_than_it_took(kind: Kind) -> None:
    arm, run = sway("two", kind)
    power = (run.torque - rigid(arm, run)) * run.v
    taken = cumulative_trapezoid(power, run.time, axis=0, initial=0)
    assert (taken > -1e-6).all()
    # bristles give back no more than they store: half of level^2 / stiffness
    assert (np.maximum.accumulate(taken) - taken).max() < (1.2 * 2.6**2 / 2e4 / 2 if kind == "bristle" else 1e-9)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("speed", [-0.4, 0.15])
def test_at_even_speed_every_law_is_coulomb_and_viscous(kind: Kind, speed: float) -> None:
    arm = make_arm("scara", kind)
    run = PLANT.simulate(arm, Ramp(np.zeros(4), np.array([speed, 0, 0, 0]), duration=2.0))
    expected = 2.0 * np.sign(speed) + 1.5 * speed
    friction = (run.torque - rigid(arm, run))[-1, 0]
    assert run.v[-1, 0] == pytest.approx(speed, abs=1e-5)
    assert friction == pytest.approx(expected, abs=2e-3)


@pytest.mark.parametrize("width", [0.0005, 0.05])
def test_smooth_friction_has_its_width(width: float) -> None:
    arm = make_arm("pendulum", "smooth", breakaway=2.0)
    arm = replace(arm, friction=replace(arm.friction, width=np.array([width])))
    run = PLANT.simulate(arm, Ramp(np.zeros(1), np.array([4 * width]), duration=6.0), step=1e-3)
    dry = (run.torque - rigid(arm, run) - 1.5 * run.v)[:, 0]
    order = np.argsort(run.v[:, 0])
    at = np.interp(np.array([0.3, 1.0, 3.0]) * width, run.v[order, 0], dry[order]) / 2.0
    np.testing.assert_allclose(at, np.sin(np.arctan([0.3, 1.0, 3.0])), atol=0.03)


EFFECTS = (
    (), ("coulomb_friction", (1,), -0.8), ("load_dependent_friction", (2,), 0.1), ("stribeck_friction", (1, 2), 0.7),
    ("presliding_hysteresis", (2,), 60.0), ("coupled_friction", (1, 2), 0.8), ("warm_up", (1,), 0.4), ("time_delay", (), 3e-3),
    ("torque_delay", (2,), 5e-3),
    ("torque_constant", (2,), 0.1), ("joint_zero_offset", (2,), 0.02), ("dropped_load", (), 0.8), ("contact", (), 8.0),
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect[0] if effect else "none")
@pytest.mark.parametrize("kind", KINDS)
def test_an_arm_obeys_the_torque_of_its_own_description(kind: Kind, effect: tuple) -> None:
    times = {"dropped_load": {"time": 1.5}, "contact": {"start": 1.0, "end": 2.5}}
    effects = (hidden(*effect, **times.get(effect[0], {})),) if effect else ()
    arm, run = sway("two", kind, *effects)
    again = PLANT.torque_along(arm, run)
    assert farthest(again, run.torque) < 1e-9
    if run.at_rest is None:
        assert np.isfinite(again).all()
    else:
        assert np.isnan(again[run.at_rest]).all()
        assert np.isfinite(again).mean() > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_an_elastic_gear_is_followed_from_its_rotor(kind: Kind) -> None:
    arm, run = sway("two", kind, hidden("joint_elasticity", (1,), 2e-4), hidden("load_dependent_friction", (1,), 0.1))
    stiff, _ = sway("two", kind, hidden("load_dependent_friction", (1,), 0.1))
    missed = PLANT.torque_along(arm, run) - run.torque
    effect = PLANT.torque_along(stiff, run) - run.torque
    assert np.nanmean(missed**2) < (0.05 * np.nanstd(effect)) ** 2


def test_hidden_effects_change_the_torque_as_named() -> None:
    """Along one motion, each effect adds its own formula to the row of its joint."""
    arm, run = sway("seven", "smooth", breakaway=2.0)
    v, q, sign = run.v, run.q, np.sin(np.arctan(run.v / 0.004))
    load, t = rigid(arm, run) - arm.rotor_inertia * run.a, run.time  # rotors turn before their gears
    pair = v[:, 4] + v[:, 5]
    bump = lambda x: np.exp(-np.square(x / 0.1))  # noqa: E731
    cases: list[tuple[HiddenEffect, int, Array]] = [
        (hidden("rotor_inertia", (3,), 0.2), 3, 0.2 * run.a[:, 2]),
        (hidden("viscous_friction", (3,), 0.9), 3, 0.9 * v[:, 2]),
        (hidden("coulomb_friction", (2,), 0.5), 2, 0.5 * sign[:, 1]),
        (hidden("friction_asymmetry", (4,), 0.5), 4, 0.5 * np.abs(v[:, 3])),
        (hidden("stribeck_friction", (1,), 0.6, stribeck_speed=0.1), 1, 0.6 * sign[:, 0] * bump(v[:, 0])),
        (hidden("nonlinear_viscous_friction", (1,), 0.6, exponent=0.7), 1, 0.6 * sign[:, 0] * np.abs(v[:, 0]) ** 0.7),
        (hidden("load_dependent_friction", (2,), 0.08), 2, 0.08 * sign[:, 1] * np.abs(load[:, 1])),
        (hidden("warm_up", (2,), 0.3, time=2.0), 2, 0.3 * np.exp(-t / 2) * (2 * sign + 1.5 * v)[:, 1]),
        (hidden("coupled_friction", (5, 6), 0.4, viscous=0.3), 6, 0.4 * np.sin(np.arctan(pair / 0.004)) + 0.3 * pair),
        (hidden("torque_constant", (4,), 0.1), 4, 0.1 * run.torque[:, 3]),
        (hidden("torque_offset", (7,), 0.3), 7, np.full(len(t), 0.3)),
        (hidden("torque_ripple", (2,), 0.7, order=9, phase=0.2), 2, 0.7 * np.sin(9 * q[:, 1] + 0.2)),
        (hidden("joint_spring", (1,), 4.0), 1, 4.0 * q[:, 0]),
    ]
    for effect, joint, expected in cases:
        change = PLANT.torque_along(replace(arm, effects=(effect,)), run) - run.torque
        np.testing.assert_allclose(change[:, joint - 1], expected, atol=1e-8, err_msg=effect.effect)
        others = np.delete(change, [j - 1 for j in effect.joints], axis=1)
        np.testing.assert_allclose(others, 0, atol=1e-9, err_msg=effect.effect)


def test_a_lost_load_was_a_payload() -> None:
    arm, run = sway("seven", "bristle")
    load = {"com": (0.0, 0.05, 0.1), "radius": 0.04}
    plain = PLANT.torque_along(arm, run)
    carrying = PLANT.torque_along(replace(arm, effects=(hidden("payload", (), 1.2, **load),)), run)
    losing = PLANT.torque_along(replace(arm, effects=(hidden("dropped_load", (), 1.2, time=1.6, **load),)), run)
    before = run.time < 1.6
    np.testing.assert_allclose(losing[before], carrying[before], atol=1e-9)
    np.testing.assert_allclose(losing[~before], plain[~before], atol=1e-9)
    assert np.abs(carrying - plain).max() > 1


def test_temperature_lowers_friction() -> None:
    arm = make_arm("two", "smooth", breakaway=2.0)
    run = PLANT.simulate(arm, Sway(np.full(2, 0.5)), warmer=20.0)
    np.testing.assert_allclose(run.temperature, 45.0)
    friction = 0.88 * (2.0 * np.sin(np.arctan(run.v / 0.004)) + 1.5 * run.v)
    np.testing.assert_allclose(run.torque, rigid(arm, run) + friction, atol=1e-9)
    assert farthest(PLANT.torque_along(arm, run), run.torque) < 1e-9


@dataclass(frozen=True)
class _Odd(Disturbance):
    """A soft spring that wanders in time, a gain that falls with speed, and channels that mix."""

    def resist(self, time: float, q: Array, v: Array) -> Array:
        return 0.6 * np.sin(2 * q + time)

    def deliver(self, time: float, v: Array, torque: Array) -> Array:
        return torque * (1 - 0.04 * np.abs(v))

    def report(self, time: Array, q: Array, v: Array, torque: Array) -> Array:
        return torque + 0.05 * np.roll(torque, 1, axis=1) + 0.01 * q


@pytest.mark.parametrize("kind", KINDS)
def test_disturbances_act_in_motion_and_along_it(kind: Kind) -> None:
    arm, run = sway("seven", kind, disturbances=(_Odd(),))
    assert farthest(PLANT.torque_along(arm, run), run.torque) < 1e-7
    plain = PLANT.torque_along(replace(arm, disturbances=()), run)
    assert np.nanstd(plain - run.torque) > 0.3
    if kind == "smooth":
        friction = 2.0 + 0.6 * np.exp(-np.abs(run.v) / 0.02)
        acting = rigid(arm, run) + friction * np.sin(np.arctan(run.v / 0.004)) + 1.5 * run.v
        acting += 0.6 * np.sin(2 * run.q + run.time[:, None])
        motor = acting / (1 - 0.04 * np.abs(run.v))
        np.testing.assert_allclose(run.torque, motor + 0.05 * np.roll(motor, 1, axis=1) + 0.01 * run.q, atol=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_half_the_step_is_the_same_recording(kind: Kind) -> None:
    """Below 8 Hz, the torque of moving rows changes by far less than instruments show, as fast as the arm may move."""
    arm = make_arm("seven", kind)
    motion = Sway(np.full(7, 0.2))
    assert np.abs(motion.states(np.linspace(0, motion.duration, 500))[2]).max() == pytest.approx(6.0, rel=0.03)
    coarse, fine = (PLANT.simulate(arm, motion, step=step) for step in (1.6e-3, 0.8e-3))
    low = butter(4, 8, fs=625, output="sos")
    change = sosfiltfilt(low, coarse.torque - fine.torque[::2], axis=0)
    moves = np.abs(coarse.v) > 0.02
    assert np.sqrt(np.mean(change**2, axis=0, where=moves)).max() < 0.003


def test_the_plant_shares_nothing_with_what_it_tests() -> None:
    code = (
        "import sys; import tests.plant.open_plant, tests.truth, tests.serial_arms\n"
        "print([name for name in sys.modules if name.split('.')[0] in ('physident', 'casadi', 'cvxpy')])"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
