"""Effects with a memory, on the measurement and on sensors: a simulated recording shows what the model predicts of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import physident as pid
from physident.simulation.simulate import simulate

CASES: dict[str, tuple[dict[str, Any], list[float]]] = {
    "presliding_hysteresis": ({"joints": (2, 3), "distance": (0.02,)}, [300.0, 200.0]),
    "joint_elasticity": ({"joints": (2,)}, [5e-5]),
    "torque_delay": ({"joints": (2,)}, [0.02]),
    "time_delay": ({}, [0.01]),
    "torque_constant": ({"joints": (3,)}, [0.1]),
    "torque_offset": ({"joints": (4,)}, [0.8]),
    "joint_zero_offset": ({"joints": (3,)}, [0.02]),
    "gravity_tilt": ({}, [0.4, -0.3]),
    "gravity_magnitude": ({}, [-0.5]),
    "warm_up": ({"joints": (1,), "time_constant": (4.0,)}, [4.0, 3.0]),
}


def _predicted(model: pid.Model, recording: pid.Recording) -> tuple[np.ndarray, np.ndarray]:
    """Filtered torque of the model and of the measurement (M, n)."""
    filter = pid.Filter(5.0)
    signals = [pid.prepare(recording, filter)]
    regressor = pid.build_regressor(model.robot, model.effects, signals, filter, theta=model.theta)
    return regressor.predict(model.theta), regressor.torque


@pytest.mark.parametrize("name", sorted(CASES))
def test_the_model_predicts_its_own_simulation(name: str, ur5: pid.Robot) -> None:
    """With the effect the prediction is right; without it, it misses by far more."""
    settings, theta = CASES[name]
    # the plant's sign is a tanh and the model's an expectation: what they differ by exceeds the torque of a stiff gear
    level = 0.0 if name == "joint_elasticity" else 2.0
    smooth = pid.CATALOGUE["coulomb_friction"](smoothing=0.01, presliding=0.0)
    base = pid.Model.nominal(ur5, ["rigid_body", "viscous_friction", smooth])
    base = pid.Model(ur5, base.effects, np.concatenate([base.theta[:60], np.full(6, 5.0), np.full(6, level)]))
    model = pid.Model(ur5, (*base.effects, pid.CATALOGUE[name](**settings)), np.concatenate([base.theta, theta]))
    plan = pid.random_trajectory(ur5, seed=4, harmonics=3, base_frequency=0.125, duration=8.0)
    recording = simulate(model, plan)
    with_effect, measured = _predicted(model, recording)
    without, _ = _predicted(base, recording)
    missed = np.linalg.norm(with_effect - measured)
    assert missed < 0.3 * np.linalg.norm(without - measured)  # effects of measurement and sensors are of first order


@pytest.mark.parametrize(
    "name", ["stribeck_friction", "nonlinear_viscous_friction", "load_dependent_friction", "presliding_hysteresis"]
)
def test_friction_never_gives_energy_over_a_motion(name: str, ur5: pid.Robot) -> None:
    """The work that friction has taken since the start of a simulated motion never falls below zero."""
    cls = pid.CATALOGUE[name]
    effect = cls.at_grid_middle(ur5, (2, 4))
    size = {"presliding_hysteresis": 200.0, "load_dependent_friction": 0.2}.get(name, 4.0)
    rigid = pid.Model.nominal(ur5, ["rigid_body"])
    model = pid.Model(ur5, (*rigid.effects, effect), np.concatenate([rigid.theta, np.full(2, size)]))
    plan = pid.random_trajectory(ur5, seed=5, harmonics=3, base_frequency=0.125, duration=8.0)
    recording = simulate(model, plan)
    assert recording.dq is not None
    signals = rigid.refer(pid.prepare(recording, pid.Filter()))
    torque = effect.regressor(ur5, signals) @ np.full(2, size)
    work = np.cumsum((torque * signals.v).sum(axis=1)) / signals.rate
    assert work.min() > -1e-3 * work.max()
    assert work[-1] > 0
