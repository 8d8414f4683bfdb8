"""The table of parameters agrees with the estimate, and the command writes all its files or none."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from physident.estimation.uncertainty import t_quantile
from physident.export.parameters import parameters_of
from physident.robots import urdf as reader
from tests.exported_arms import lumped, physical_model


@pytest.fixture(scope="module")
def estimate(tmp_path_factory: pytest.TempPathFactory) -> pid.Estimate:
    """A two-joint arm identified from a noisy motion."""
    robot = lumped()
    time, q, v, a = pid.random_trajectory(robot, seed=1, duration=20.0).sample(100.0)
    torque = physical_model(robot, seed=12).torque(pid.Signals.of_states(q, v, a))
    torque = torque + 0.05 * np.random.default_rng(0).normal(size=torque.shape)
    return pid.identify(robot, [pid.Recording(time, q, torque, "torque", dq=v)])


def test_json_has_units_and_intervals_that_agree_with_the_estimate(estimate: pid.Estimate, tmp_path: Path) -> None:
    pid.export_parameters(estimate, tmp_path / "p.json")
    data = json.loads((tmp_path / "p.json").read_text())
    assert data == json.loads(json.dumps(parameters_of(estimate)))
    assert [p["value"] for p in data["parameters"]] == list(estimate.theta)
    for parameter, std in zip(data["parameters"], estimate.standard_errors, strict=True):
        assert (parameter["interval"] is None) == bool(np.isnan(std))
        if parameter["interval"]:
            low, high = parameter["interval"]
            assert low < parameter["value"] < high
            assert high - low == pytest.approx(2 * t_quantile(estimate.blocks) * std, rel=1e-9)
    assert {p["unit"] for p in data["parameters"]} == {"kg", "kg m", "kg m^2", "N m", "N m s/rad"}
    assert [p["interval"] for p in data["base_parameters"]] == estimate.intervals().tolist()
    truth = physical_model(lumped(), seed=12)
    friction = [p for p in data["parameters"] if p["effect"] == "viscous_friction"]
    for parameter, value in zip(friction, truth.parameters("viscous_friction"), strict=True):
        assert abs(parameter["value"] - value) < 5 * parameter["std"]


def test_command_line_writes_all_or_nothing(
    estimate: pid.Estimate, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    model = physical_model(lumped(), seed=13)
    good, bad = tmp_path / "good.json", tmp_path / "bad.json"
    replace(estimate, model=model).save(good)
    theta = np.array(model.theta)
    theta[0] = -1.0
    replace(estimate, model=replace(model, theta=theta)).save(bad)
    out = [tmp_path / name for name in ("a.urdf", "a.json", "a.py")]
    options = ["--urdf", str(out[0]), "--json", str(out[1]), "--python", str(out[2])]
    assert run(["export", "--model", str(bad), *options]) == 2
    assert "link 1 (arm, moved by shoulder)" in capsys.readouterr().err
    assert not any(path.exists() for path in out)
    assert run(["export", "--model", str(good)]) == 2
    assert run(["export", "--model", str(good), "--urdf", str(out[0]), "--json", str(out[0])]) == 2
    assert not any(path.exists() for path in out)
    assert run(["export", "--model", str(good), *options]) == 0
    assert run(["export", "--model", str(good), *options]) == 0  # replaces what it wrote, without --force
    assert "not expressible in URDF: rotor_inertia" in capsys.readouterr().out
    assert all(path.exists() for path in out)
    assert reader.parse_urdf(out[0].read_text(), "a.urdf").get("name") == "lumped"
