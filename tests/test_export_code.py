"""Generated C code and CasADi functions give the model's torque, derivatives and regressor, and allocate nothing."""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from physident.effects.friction import NonlinearViscousFriction, StribeckFriction
from physident.effects.hysteresis import PreslidingHysteresis
from physident.effects.thermal import WarmUp
from physident.effects.transmission import CoupledFriction, TorqueRipple
from physident.export.code import c_of, export_c
from physident.identifiability.base_parameters import random_motion
from tests.exported_arms import lumped, named_after_code, physical_model

Array = np.ndarray
COMPILER = shutil.which("cc") or shutil.which("gcc")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler (cc or gcc) on this machine")
POINTER = ctypes.POINTER(ctypes.c_double)


def compiled(model: pid.Model, folder: Path) -> Callable[..., None]:
    """A function that calls ``physident_NAME`` of the compiled code with arrays."""
    export_c(model, folder / "torque.c")
    assert COMPILER is not None
    command = [COMPILER, "-std=c99", "-O1", "-shared", "-fPIC", "-o", "torque.so", "torque.c", "-lm"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True, timeout=120)
    library: Any = ctypes.CDLL(str(folder / "torque.so"))

    def call(name: str, *arrays: Array) -> None:
        library[f"physident_{name}"](*(x.ctypes.data_as(POINTER) for x in arrays))

    return call


def every_law(robot: pid.Robot) -> pid.Model:
    named = "rigid_body rotor_inertia payload gravity_tilt gravity_magnitude viscous_friction coulomb_friction friction_asymmetry"
    more = "load_dependent_friction joint_spring torque_constant torque_offset"
    shaped = StribeckFriction((2,), (0.1,)), NonlinearViscousFriction(None, (0.5, 2.0)), TorqueRipple((2,), (3.0,))
    memory = PreslidingHysteresis((2,), (0.02,)), WarmUp((1,), (4.0,)), PreslidingHysteresis((1,), (0.1,))
    effects = pid.make_effects([*named.split(), *more.split(), *shaped, CoupledFriction((2, 1)), *memory])
    count = len(pid.Model.nominal(robot, effects).theta)
    return pid.Model(robot, effects, np.random.default_rng(14).uniform(0.1, 1.0, size=count))


@needs_compiler
def test_c_code_is_the_model_with_all_its_laws(tmp_path: Path) -> None:
    model = every_law(replace(lumped(), gravity=(1.0, -2.0, 9.0)))
    call = compiled(model, tmp_path)
    time, q, v, a = pid.random_trajectory(model.robot, seed=20, duration=10.0).sample(50.0)
    expected = model.torque(pid.Signals(time, q, v, a, rate=50.0))
    state, tau = np.zeros(4), np.zeros(2)
    found = np.zeros_like(expected)
    for k in range(len(time)):
        if k:
            after = np.zeros(4)
            call("advance", state, 0.5 * (v[k - 1] + v[k]), np.array([time[k] - time[k - 1]]), after)
            state = after
        call("torque", q[k], v[k], a[k], state, time[k : k + 1], tau)
        found[k] = tau
    assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()


@needs_compiler
def test_regressor_and_derivatives(tmp_path: Path) -> None:
    kept = "rigid_body rotor_inertia payload gravity_tilt gravity_magnitude viscous_friction coulomb_friction load_dependent_friction"
    effects = pid.make_effects([*kept.split(), "torque_constant", TorqueRipple((2,), (3.0,))])
    robot = lumped()
    count = len(pid.Model.nominal(robot, effects).theta)
    model = pid.Model(robot, effects, np.random.default_rng(15).uniform(0.1, 1.0, size=count))
    call = compiled(model, tmp_path)
    s = model.refer(random_motion(robot, seed=16, count=10))
    for k in range(10):
        state = s.q[k].copy(), s.v[k].copy(), s.a[k].copy()
        Y = np.zeros((2, count))
        call("regressor", *state, Y)
        expected = np.concatenate([e.regressor(robot, s)[k] for e in effects], axis=1)
        np.testing.assert_allclose(Y, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())
        derivatives = np.zeros((3, 2, 2))
        call("derivatives", *state, *derivatives)
        for part in range(3):
            for j in range(2):
                shifted = [[x.copy() for x in state] for _ in range(2)]
                shifted[0][part][j] -= 1e-6
                shifted[1][part][j] += 1e-6
                low, high = (model.torque(pid.Signals.of_states(*x))[0] for x in shifted)
                scale = np.abs(derivatives).max()
                np.testing.assert_allclose(derivatives[part, :, j], (high - low) / 2e-6, atol=1e-6 * scale)


@needs_compiler
def test_code_allocates_nothing_and_names_stay_in_comments(tmp_path: Path) -> None:
    model = physical_model(named_after_code(), seed=8)
    compiled(model, tmp_path)
    source = (tmp_path / "torque.c").read_text()
    assert "import os" in source  # the name is there, in a comment that it does not end
    code = re.sub(r"/\*.*?\*/", "", source, flags=re.S)
    assert "import os" not in code
    assert not re.search(r"\b(malloc|calloc|realloc|free|alloca)\b", code)
    needed = subprocess.run(["nm", "-u", "torque.so"], cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert not re.search(r"\b(malloc|calloc|realloc|free)\b", needed)


def test_casadi_file_is_the_model(tmp_path: Path) -> None:
    import casadi

    model = every_law(lumped())
    pid.export_casadi(model, tmp_path / "arm.casadi")
    function = casadi.Function.load(str(tmp_path / "arm.casadi"))
    assert [function.name_in(i) for i in range(function.n_in())] == ["q", "v", "a", "z", "t"]
    s = random_motion(model.robot, seed=17, count=3)
    first = pid.Signals(np.zeros(1), s.q[:1], s.v[:1], s.a[:1], rate=100.0)
    found = np.ravel(function(s.q[0], s.v[0], s.a[0], np.zeros(4), 0.0))
    np.testing.assert_allclose(found, model.torque(first)[0], rtol=1e-12)


def test_what_code_cannot_express_is_refused() -> None:
    model = pid.Model.nominal(lumped(), ["rigid_body", "joint_elasticity", "time_delay"])
    with pytest.raises(pid.InputError, match="cannot express joint_elasticity, time_delay"):
        c_of(model)


def test_command_line(healthy_estimate: pid.Estimate, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    healthy_estimate.save(path := tmp_path / "m.json")
    out = [tmp_path / "a.c", tmp_path / "a.casadi"]
    for _ in range(2):  # the second replaces what the first wrote, without --force
        assert run(["export", "--model", str(path), "--c", str(out[0]), "--casadi", str(out[1])]) == 0
    assert capsys.readouterr().out.startswith("written: ")
    assert all(file.stat().st_size > 1000 for file in out)
    assert run(["export", "--model", str(path), "--c", str(out[0]), "--casadi", str(out[0])]) == 2
