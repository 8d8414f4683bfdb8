"""The plant that hides effects: its physics against closed forms that know nothing of its integrator."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d

import physident as pid
from tests.conftest import ROOT
from tests.plant import (
    EFFECTS,
    Arm,
    Friction,
    Multisine,
    Record,
    Sensors,
    hide,
    multisine,
    point_to_point,
    record,
    simulate,
    torque_along,
)
from tests.plant.motions import LOWER, TOP_SPEED, UPPER

Array = NDArray[np.float64]
DENSE = Sensors(rate=1000.0, jitter=0.0)
NEGLIGIBLE = 0.004  # N m: a hundredth of the torque's noise
MOTION = multisine(seed=7, duration=4.0)
WIDTH = 0.0035  # rad/s: of the ordinary arm's friction about zero speed


def _ordinary(**changes: Any) -> tuple[Any, Any]:
    model = Arm().bodies.copy()
    model.armature[:] = 0.0
    for name, value in changes.items():
        setattr(model, name, value)
    return model, model.createData()


def _rnea(model: Any, q: Array, v: Array, a: Array) -> Array:
    data = model.createData()
    return np.array([pin.rnea(model, data, *state) for state in zip(q, v, a, strict=True)])


class Known:
    """The recorded states with accelerations by differences, and what the ordinary arm's torque is there."""

    def __init__(self, made: Record) -> None:
        self.t, self.q, self.v = made.time, made.true_q, made.true_v
        self.a = CubicSpline(self.t, self.v)(self.t, 1)
        self.model, _ = _ordinary()
        arm = Arm()
        self.sign = np.sin(np.arctan(self.v / WIDTH))
        self.load = _rnea(self.model, self.q, self.v, self.a)  # what gears carry: rotors turn before them
        self.coulomb, self.viscous = arm.friction.coulomb * self.sign, arm.friction.viscous * self.v
        self.torque = self.load + arm.drives.rotor_inertia * self.a + self.coulomb + self.viscous

    def row(self, joint: int, values: Array) -> Array:
        out = np.zeros_like(self.q)
        out[:, joint - 1] = values
        return out


def _dahl(k: Known, joint: int, slip: float) -> Array:
    speed = CubicSpline(k.t, k.v[:, joint - 1])
    solved = solve_ivp(
        lambda t, z: speed(t) - abs(speed(t)) * z / slip, (0, k.t[-1]), [0.0], t_eval=k.t, max_step=0.01, rtol=1e-7
    )
    return solved.y[0]


def _with_body(k: Known, link: int, mass: float, com: Array, radius: float = 0.05) -> Array:
    model, _ = _ordinary()
    model.inertias[link] = model.inertias[link] + pin.Inertia(mass, com, 0.4 * mass * radius**2 * np.eye(3))
    return _rnea(model, k.q, k.v, k.a) - _rnea(k.model, k.q, k.v, k.a)


def _tilted(k: Known) -> Array:
    down, way = np.array([0.0, 0.0, -1.0]), np.array([np.cos(0.7), np.sin(0.7), 0.0])
    model, _ = _ordinary()
    model.gravity.linear = 9.81 * pin.exp3(0.1 * np.cross(down, way)) @ down
    return _rnea(model, k.q, k.v, k.a) - _rnea(k.model, k.q, k.v, k.a)


def _zero(k: Known, joint: int, offset: float) -> Array:
    data = k.model.createData()
    slopes = [pin.computeRNEADerivatives(k.model, data, *s)[0].copy() for s in zip(k.q, k.v, k.a, strict=True)]
    return offset * np.array(slopes)[:, :, joint - 1]


def _pushed(k: Known, start: float, end: float, force: Array) -> Array:
    """Virtual work: the tool's shift along the force for a small turn of each joint."""
    data, frame, tiny = k.model.createData(), k.model.getFrameId("tool0"), 1e-6

    def height(q: Array) -> float:
        pin.framesForwardKinematics(k.model, data, q)
        return float(data.oMf[frame].translation @ force)

    turns = tiny * np.eye(6)
    out = np.zeros_like(k.q)
    for i in np.flatnonzero((k.t > start - 1e-9) & (k.t < end - 1e-9)):
        out[i] = [(height(k.q[i] + turn) - height(k.q[i] - turn)) / (2 * tiny) for turn in turns]
    return out


def _wound(k: Known, joint: int, compliance: float) -> Array:
    """First order in the compliance: what the lag of the link behind the rotor changes."""
    carried = CubicSpline(k.t, _rnea(k.model, k.q, k.v, k.a)[:, joint - 1])
    lag = [compliance * k.row(joint, carried(k.t, order)) for order in (0, 1, 2)]
    return _rnea(k.model, k.q - lag[0], k.v - lag[1], k.a - lag[2]) - _rnea(k.model, k.q, k.v, k.a)


def _rate(k: Known) -> Array:
    return CubicSpline(k.t, k.torque)(k.t, 1)


def _centre(link: int) -> Array:
    return np.array(Arm().bodies.inertias[link].lever)


# effect: joints, magnitude, settings, closed form, and the error allowed relative to the effect
CASES: dict[str, tuple[tuple[int, ...], float, dict[str, Any], Callable[[Known], Array], float]] = {
    "rotor_inertia": ((4,), 0.3, {}, lambda k: k.row(4, 0.3 * k.a[:, 3]), 0.01),
    "viscous_friction": ((1,), 4.0, {}, lambda k: k.row(1, 4 * k.v[:, 0]), 0.01),
    "coulomb_friction": ((3,), -3.0, {}, lambda k: k.row(3, -3 * k.sign[:, 2]), 0.01),
    "friction_asymmetry": ((2,), 3.0, {}, lambda k: k.row(2, 3 * abs(k.v[:, 1])), 0.01),
    "stribeck_friction": (
        (1,), 5.0, {"stribeck_speed": 0.06}, lambda k: k.row(1, 5 * (k.sign * np.exp(-((k.v / 0.06) ** 2)))[:, 0]), 0.01,
    ),
    "nonlinear_viscous_friction": (
        (5,), 2.0, {"exponent": 0.4}, lambda k: k.row(5, 2 * (k.sign * abs(k.v) ** 0.4)[:, 4]), 0.01,
    ),
    "load_dependent_friction": ((2,), 0.1, {}, lambda k: k.row(2, 0.1 * (k.sign * abs(k.load))[:, 1]), 0.01),
    "presliding_hysteresis": ((3,), 400.0, {"slip": 0.02}, lambda k: k.row(3, 400 * _dahl(k, 3, 0.02)), 0.01),
    "warm_up": (
        (2,), 0.5, {"time": 3.0}, lambda k: k.row(2, 0.5 * np.exp(-k.t / 3) * (k.coulomb + k.viscous)[:, 1]), 0.01,
    ),
    "coupled_friction": (
        (5, 6), 1.0, {"viscous": 0.7},
        lambda k: (np.sin(np.arctan((u := k.v[:, 4] + k.v[:, 5]) / WIDTH)) + 0.7 * u)[:, None] * [0, 0, 0, 0, 1, 1], 0.01,
    ),
    "torque_constant": ((2,), 0.1, {}, lambda k: k.row(2, 0.1 * k.torque[:, 1]), 0.01),
    "torque_offset": ((6,), 0.5, {}, lambda k: k.row(6, np.full(len(k.t), 0.5)), 0.01),
    "torque_delay": ((2,), 2e-3, {}, lambda k: k.row(2, -2e-3 * _rate(k)[:, 1]), 0.05),
    "time_delay": ((), 2e-3, {}, lambda k: -2e-3 * _rate(k), 0.05),
    "torque_ripple": (
        (2,), 2.0, {"order": 15.0, "phase": 1.0}, lambda k: k.row(2, 2 * np.sin(15 * k.q[:, 1] + 1)), 0.01,
    ),
    "joint_spring": ((1,), 6.0, {}, lambda k: k.row(1, 6 * k.q[:, 0]), 0.01),
    "joint_elasticity": ((2,), 3e-5, {}, lambda k: _wound(k, 2, 3e-5), 0.1),
    "payload": ((), 2.0, {}, lambda k: _with_body(k, 6, 2.0, np.array([0.03, -0.02, 0.14])), 0.01),
    "dropped_load": (
        (), 2.0, {"time": 2.5}, lambda k: (k.t < 2.5)[:, None] * _with_body(k, 6, 2.0, np.array([0.03, -0.02, 0.14])), 0.03,
    ),
    "link_inertia": ((3,), 1.5, {}, lambda k: _with_body(k, 3, 1.5, _centre(3)), 0.01),
    "gravity_tilt": ((), 0.1, {}, _tilted, 0.01),
    "joint_zero_offset": ((2,), 0.01, {}, lambda k: _zero(k, 2, 0.01), 0.02),
    "contact": (
        (), 30.0, {"start": 1.2, "end": 3.2, "direction": (0.0, 0.6, 0.8)},
        lambda k: _pushed(k, 1.2, 3.2, np.array([0.0, 18.0, 24.0])), 0.03,
    ),
}  # fmt: skip


# width [ms] of the smoothing below which a closed form of first order, or one that jumps, is not to be compared
SLOW_PART = {"joint_elasticity": 40, "torque_delay": 12, "time_delay": 12, "contact": 8, "dropped_load": 8}


def test_every_effect_has_a_case() -> None:
    assert set(CASES) == set(EFFECTS)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_effect_against_its_closed_form(name: str) -> None:
    joints, magnitude, shape, closed_form, allowed = CASES[name]
    arm = hide(Arm(), name, joints, magnitude, **shape)
    made = record(arm, MOTION, DENSE)
    known = Known(made)
    change, expected = made.with_effect - known.torque, closed_form(known)
    missed = made.with_effect - made.without_effect
    if name in SLOW_PART:
        change, expected, missed = (gaussian_filter1d(x, SLOW_PART[name], axis=0) for x in (change, expected, missed))
    size = np.sqrt(np.mean(expected**2))
    assert size > 0.01
    assert np.sqrt(np.mean((change - expected) ** 2)) < max(allowed * size, 1e-3)
    # what a perfect model without the effect misses is the effect; one with it misses nothing
    assert np.sqrt(np.mean((missed - change) ** 2)) < max(NEGLIGIBLE, 0.01 * size)
    own = torque_along(arm, made.time, made.true_q, made.true_v, made.true_a)
    assert np.sqrt(np.mean((own - made.with_effect) ** 2)) < NEGLIGIBLE


@pytest.mark.slow
@pytest.mark.parametrize(("left_out", "allowed"), [("joint_elasticity", NEGLIGIBLE), ("contact", 0.02)])
def test_many_effects_at_once_are_consistent(left_out: str, allowed: float) -> None:
    """An arm with nearly everything wrong obeys the torque of its own description; a link behind an elastic gear has to
    be simulated again for it, to the integrator's accuracy."""
    arm = Arm()
    for name, (joints, magnitude, shape, _, _) in CASES.items():
        arm = arm if name == left_out else hide(arm, name, joints, magnitude, **shape)
    assert len(arm.hidden) == len(EFFECTS) - 1
    assert record(arm, MOTION, DENSE, without=arm).change.max() < allowed


def test_temperature_moves_friction_and_is_recorded() -> None:
    arm = hide(Arm(), "warm_up", 3, -0.02, rise=20.0, time=5.0)
    made = record(arm, MOTION, DENSE)
    known = Known(made)
    assert made.temperature is not None
    warmth = made.temperature - made.temperature[0]
    assert warmth[-1, 2] == pytest.approx(20 * (1 - np.exp(-MOTION.duration / 5)), rel=1e-3)
    expected = known.row(3, (-0.02 * warmth * (known.coulomb + known.viscous))[:, 2])
    change = made.with_effect - known.torque
    # the acceleration by differences misses the few milliseconds of each reversal
    assert np.sqrt(np.mean((change - expected) ** 2)) < 0.01 * np.sqrt(np.mean(expected**2))


@pytest.mark.slow
@pytest.mark.parametrize("effect", [None, "stribeck_friction", "presliding_hysteresis", "joint_elasticity"])
def test_step_halving(effect: str | None) -> None:
    """Second order, and at the step in use far below the noise of the torque."""
    arm = Arm() if effect is None else hide(Arm(), effect, CASES[effect][0], CASES[effect][1], **CASES[effect][2])
    errors = []
    motion = multisine(seed=7, duration=3.2)
    finest = simulate(arm, motion, step=2.5e-4).torque[::8]
    for step, every in ((2e-3, 1), (1e-3, 2)):
        error = simulate(arm, motion, step=step).torque[::every] - finest
        errors.append(np.sqrt(np.mean(error**2, axis=0)))
    assert (errors[1] < 0.01 * np.array(Sensors().torque_noise)).all()
    assert np.linalg.norm(errors[0]) > 3 * np.linalg.norm(errors[1])


def test_energy_without_friction_is_the_motors_work() -> None:
    arm = Arm(friction=Friction(np.zeros(6), np.zeros(6)))
    run = simulate(arm, MOTION)
    model, data = arm.bodies, arm.bodies.createData()
    kinetic = [v @ pin.crba(model, data, q) @ v / 2 for q, v in zip(run.q, run.v, strict=True)]
    potential = [pin.computePotentialEnergy(model, data, q) for q in run.q]
    energy = np.array(kinetic) + np.array(potential)
    work = CubicSpline(run.time, (run.torque * run.v).sum(axis=1)).antiderivative()(run.time)
    assert np.ptp(energy) > 5  # J
    assert np.abs(energy - energy[0] - work).max() < 1e-4 * np.ptp(energy)


@pytest.mark.slow
# friction_asymmetry takes energy in one direction and gives it in the other: only the joint's sum dissipates
@pytest.mark.parametrize("name", [n for n in CASES if n.endswith(("friction", "hysteresis"))])
def test_friction_never_gives_energy(name: str) -> None:
    """Over a run from rest to rest each friction takes energy out of the joint it acts on, more so where it grows."""
    joints, magnitude, shape, _, _ = CASES[name]
    bare = Arm(friction=Friction(np.full(6, 0.5), np.zeros(6)))
    arm = hide(bare, name, joints, abs(magnitude), **shape)
    made = record(arm, MOTION, DENSE, without=bare)
    power = ((made.with_effect - made.without_effect) * made.true_v).sum(axis=1)
    assert CubicSpline(made.time, power).integrate(0, made.time[-1]) > 0.02  # J


@pytest.mark.parametrize("effect", ["payload", "joint_elasticity", "joint_zero_offset", "joint_spring", "gravity_tilt"])
def test_standstill(effect: str) -> None:
    """An arm told to stand stands, and its torque is what statics asks for."""
    arm = hide(Arm(), effect, CASES[effect][0], CASES[effect][1])
    still = Multisine(2.0, np.array([0.3, -1.2, 0.8, -0.5, 0.4, 0.2]), *np.zeros((3, 1, 6)))
    run = simulate(arm, still)
    assert np.abs(run.v).max() < 1e-9
    static = pin.computeGeneralizedGravity(arm.bodies, arm.bodies.createData(), run.link_q[-1])
    np.testing.assert_allclose(run.torque, np.tile(static + arm.spring * run.link_q[-1], (len(run.time), 1)), atol=1e-6)


@pytest.mark.parametrize("make", [multisine, point_to_point])
@pytest.mark.parametrize("speed", [0.3, 1.0])
def test_motions(make: Callable[..., Any], speed: float) -> None:
    """Inside the limits, at rest at both ends, and their derivatives are derivatives."""
    time = np.arange(0, 20.001, 0.005)
    for seed in range(5):
        motion = make(seed, speed=speed)
        q, v, a = motion.states(time)
        assert (q > LOWER - 1e-9).all()
        assert (q < UPPER + 1e-9).all()
        assert 0.3 * TOP_SPEED * speed < np.abs(v).max() <= 1.02 * TOP_SPEED * speed
        assert not v[[0, -1]].any()
        assert not a[[0, -1]].any()
        np.testing.assert_allclose(CubicSpline(time, q)(time, 1), v, atol=2e-3)
        np.testing.assert_allclose(CubicSpline(time, q).antiderivative(0)(time, 2), a, atol=0.15)


def test_seeds_decide_everything() -> None:
    one, same, other = (record(Arm(), multisine(s, duration=3.0), seed=s).table() for s in (3, 3, 4))
    assert all(np.array_equal(one[name], same[name]) for name in one)
    assert all(not np.array_equal(one[name], other[name]) for name in one if name != "time")


def test_instruments() -> None:
    gains = (10.0, 10.0, 10.0, 5.0, 5.0, 5.0)
    sensors = Sensors(dropped=0.1, drive_gains=gains, noise_memory=0.2, velocity="derived", resolution=1e-3)
    motion = multisine(5, duration=8.0)
    made = record(Arm(), motion, sensors, seed=2)
    assert 0.85 < len(made.time) / 1001 < 0.95
    assert made.dq is not None
    steps = made.q / 1e-3
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    assert np.abs(made.q - made.true_q).max() <= 0.5e-3 + 1e-12
    noise = made.effort * np.array(gains) - made.with_effect
    np.testing.assert_allclose(noise.std(axis=0), sensors.torque_noise, rtol=0.5)
    lag = np.mean(noise[1:] * noise[:-1], axis=0) / np.mean(noise**2, axis=0)
    assert (lag > 0.9).all()
    white = record(Arm(), motion, Sensors(jitter=0.0, resolution=0.0), seed=2)
    noise = white.effort - white.with_effect
    np.testing.assert_allclose(noise.std(axis=0), Sensors().torque_noise, rtol=0.1)
    assert np.array_equal(white.q, white.true_q)


def test_written_recording_is_read_as_it_was(tmp_path: Path) -> None:
    for sensors in (Sensors(), Sensors(velocity="absent", drive_gains=(8.0,) * 6)):
        made = record(hide(Arm(), "warm_up", 1, 0.01, rise=5.0), multisine(1, duration=3.0), sensors)
        made.write_csv(tmp_path / "run.csv")
        read = pid.load_recording(tmp_path / "run.csv")
        assert read.effort_kind == made.effort_kind
        assert (read.dq is None) == (made.dq is None)
        for name in ("time", "q", "effort", "temperature"):
            np.testing.assert_allclose(getattr(read, name), getattr(made, name), atol=1e-8)


def test_hiding_adds_up_and_refuses_nonsense() -> None:
    arm = hide(hide(Arm(), "coulomb_friction", 2, 1.5), "coulomb_friction", (2, 3), (-0.5, 2.0))
    np.testing.assert_allclose(arm.friction.coulomb - Arm().friction.coulomb, [0, 1.0, 2.0, 0, 0, 0])
    assert [h.effect for h in arm.hidden] == ["coulomb_friction"] * 2
    assert replace(Arm()).friction.coulomb[1] == 9.0
    for joints, magnitude, shape in ((7, 1.0, {}), ((1, 2), (1.0,), {}), (1, 1.0, {"slip": 1.0})):
        with pytest.raises(ValueError, match="coulomb_friction"):
            hide(Arm(), "coulomb_friction", joints, magnitude, **shape)


def test_plant_shares_nothing_with_what_it_tests() -> None:
    code = (
        "import sys; from tests.plant import *\n"
        "arm = hide(hide(Arm(), 'payload', (), 1.0), 'joint_elasticity', 2, 1e-5)\n"
        "record(arm, multisine(0, duration=2.0)); record(arm, point_to_point(0, duration=3.0))\n"
        "print([name for name in sys.modules if name.split('.')[0] in ('physident', 'casadi', 'cvxpy')])"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
