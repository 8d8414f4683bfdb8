"""The Python function of a model gives its torques, with every effect that it can express, and needs NumPy only."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.effects.friction import NonlinearViscousFriction, StribeckFriction
from physident.effects.hysteresis import PreslidingHysteresis
from physident.effects.thermal import WarmUp
from physident.effects.transmission import CoupledFriction, TorqueRipple
from physident.estimation.estimate import as_estimate
from physident.export.formats import Targets, export_files
from physident.export.python import python_of
from physident.identifiability.base_parameters import random_motion
from tests.exported_arms import lumped, physical_model, random_states
from tests.robots import TREE


@pytest.fixture(params=["ur5", "lumped", "tree"])
def robot(request: pytest.FixtureRequest) -> pid.Robot:
    makers = {"ur5": lambda: pid.load_robot("ur5"), "lumped": lumped, "tree": lambda: pid.Robot("tree", TREE)}
    return makers[request.param]()


def test_python_function_equals_the_model(robot: pid.Robot, tmp_path: Path) -> None:
    model = physical_model(replace(robot, gravity=(1.0, -3.0, 8.0)), seed=9)
    effects = (pid.make_effects(["rigid_body"])[0], pid.CATALOGUE["coulomb_friction"]((2,)), *model.effects[1:3])
    theta = np.concatenate([model.theta[: 10 * robot.n + 1], model.theta[10 * robot.n : 12 * robot.n]])
    for one in (model, pid.Model(model.robot, effects, theta)):
        space: dict = {}
        exec(python_of(one), space)
        states = random_motion(robot, seed=10, count=30)
        expected = one.torque(states)
        np.testing.assert_allclose(space["torque"](states.q, states.v, states.a), expected, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(
            space["torque"](states.q[3], states.v[3], states.a[3]), expected[3], rtol=1e-9, atol=1e-9
        )
        with pytest.raises(ValueError, match="shapes"):
            space["torque"](states.q[:, :1], states.v, states.a)


def test_python_function_holds_every_effect_it_can(tmp_path: Path) -> None:
    robot = lumped()
    named = "rigid_body rotor_inertia payload gravity_tilt gravity_magnitude viscous_friction coulomb_friction friction_asymmetry"
    more = "load_dependent_friction joint_spring torque_constant torque_offset"
    shaped = StribeckFriction((2,), (0.1,)), NonlinearViscousFriction(None, (0.5, 2.0)), TorqueRipple((2,), (3.0,))
    effects = pid.make_effects([*named.split(), *more.split(), *shaped, CoupledFriction((2, 1))])
    count = len(pid.Model.nominal(robot, effects).theta)
    model = pid.Model(robot, effects, np.random.default_rng(14).uniform(0.1, 1.0, size=count))
    space: dict = {}
    exec(python_of(model), space)
    s = random_states(robot, seed=15, count=40)
    np.testing.assert_allclose(space["torque"](s.q, s.v, s.a), model.torque(s), rtol=1e-9, atol=1e-9)


def test_python_refuses_what_needs_other_instants() -> None:
    model = pid.Model.nominal(lumped(), ["rigid_body", "joint_elasticity", "time_delay"])
    with pytest.raises(pid.InputError, match=r"cannot express joint_elasticity, time_delay; expected .*hysteresis"):
        python_of(model)


def test_a_late_reading_is_left_out_of_a_function_of_one_instant_and_told(tmp_path: Path) -> None:
    robot = lumped()
    given = pid.make_effects(["rigid_body", "coulomb_friction"])
    late = pid.make_effects([*given, pid.CATALOGUE["torque_delay"]((2,)), "time_delay"])
    theta = np.random.default_rng(21).uniform(0.1, 1.0, size=len(pid.Model.nominal(robot, given).theta))
    model = pid.Model(robot, late, np.append(theta, [0.012, 0.004]))
    told = export_files(
        as_estimate(model, pid.Filter(5.0)), Targets(python=tmp_path / "arm.py", c=tmp_path / "arm.c")
    ).text
    assert "whose torque is that of one instant: torque_delay: The torque reading of joint 2 comes 12 ms after" in told
    assert "; time_delay [s] 0.004" in told
    space: dict = {}
    exec((tmp_path / "arm.py").read_text(), space)
    s = random_states(robot, seed=22, count=20)
    expected = pid.Model(robot, given, theta).torque(s)
    np.testing.assert_allclose(space["torque"](s.q, s.v, s.a), expected, rtol=1e-9, atol=1e-9)
    assert (tmp_path / "arm.c").stat().st_size > 1000


def test_python_function_remembers_and_ages_as_the_model_does() -> None:
    robot = lumped()
    more = PreslidingHysteresis((2,), (0.02,)), PreslidingHysteresis((1,), (0.1,)), WarmUp((1,), (4.0,))
    effects = pid.make_effects(["rigid_body", "coulomb_friction", *more, "torque_constant"])
    count = len(pid.Model.nominal(robot, effects).theta)
    model = pid.Model(robot, effects, np.random.default_rng(19).uniform(0.1, 1.0, size=count))
    space: dict = {}
    exec(python_of(model), space)
    time, q, v, a = pid.random_trajectory(robot, seed=20, duration=10.0).sample(100.0)
    expected = model.torque(pid.Signals(time, q, v, a, rate=100.0))
    without = pid.Model(robot, effects[:2], model.theta[:22]).torque(pid.Signals(time, q, v, a, rate=100.0))
    assert (np.abs(expected - without).max(axis=0) > 0.1).all()
    np.testing.assert_allclose(space["torque_along"](time + 7.0, q, v, a), expected, rtol=1e-9, atol=1e-9)
    state = np.zeros((2, 2))
    for k in range(1, 300):
        state = space["advanced"](state, 0.5 * (v[k - 1] + v[k]), 0.01)
    once = space["torque"](q[299], v[299], a[299], state, t=time[299])
    np.testing.assert_allclose(once, expected[299], rtol=1e-9, atol=1e-9)


def test_python_file_needs_numpy_only(tmp_path: Path) -> None:
    pid.export_python(physical_model(lumped(), seed=11), tmp_path / "arm.py")
    code = "import sys, arm; arm.torque([1, 2], [0, 0], [0, 0]); print([m for m in sys.modules if m.split('.')[0] in ('physident', 'casadi', 'pinocchio')])"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
