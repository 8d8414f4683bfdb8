"""Poses at rest: friction may hold what it can hold, and nothing beyond; checked against Pinocchio's own gravity."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.cli import run
from physident.diagnosis.at_rest.at_rest import breakaway, is_at_rest

Q = np.array([0.3, -1.2, 0.9, -0.4, 1.1, 0.2])
DRY = np.array([10.0, 12.0, 8.0, 2.0, 2.5, 1.5])  # N m
MU = 0.06


def gravity(robot: pid.Robot, q: np.ndarray) -> np.ndarray:
    model = robot.pinocchio
    return np.asarray(pin.computeGeneralizedGravity(model, model.createData(), q))


@pytest.fixture(scope="module")
def model(ur5: pid.Robot) -> pid.Model:
    effects = pid.make_effects(["rigid_body", "viscous_friction", "coulomb_friction"])
    return pid.Model(ur5, effects, np.concatenate([ur5.nominal, np.full(6, 5.0), DRY]))


def pose(folder: Path, name: str, torque: np.ndarray, q: np.ndarray = Q) -> pid.Recording:
    """Four seconds at rest with a sensor's noise, as a file."""
    rng = np.random.default_rng(5)
    time = np.arange(500) / 125
    tau = torque + rng.normal(0, 0.2, (500, 6))
    names = ["time", *(f"{x}_{j}" for x in ("q", "tau") for j in range(1, 7))]
    table = np.column_stack([time, np.tile(q, (500, 1)), tau])
    np.savetxt(folder / name, table, delimiter=",", comments="", header=",".join(names), encoding="utf-8")
    return pid.load_recording(folder / name)


def test_what_friction_holds_contradicts_nothing(model: pid.Model, tmp_path: Path) -> None:
    signs = np.array([1, -1, 1, -1, 1, -1])
    held = [
        pose(tmp_path, f"{k}.csv", gravity(model.robot, Q) + share * signs * DRY) for k, share in enumerate((-0.9, 0.9))
    ]
    found = pid.diagnose_at_rest(model, held)
    assert found.outside == ()
    np.testing.assert_allclose(found.poses[0].gravity, gravity(model.robot, Q), atol=1e-9)
    np.testing.assert_allclose(found.poses[1].held, 0.9 * signs * DRY, atol=0.05)
    assert "nothing contradicts the model" in repr(found)
    assert max(map(len, repr(found).splitlines())) <= 100


def test_more_than_friction_can_hold_is_named(model: pid.Model, tmp_path: Path) -> None:
    """A load of 12 kg at the last flange: joints 2 and 3 carry more than their friction, joint 1 carries none of it."""
    loaded = model.robot.nominal.copy()
    loaded[50] += 12.0
    heavier = pid.Model(model.robot, model.effects, np.concatenate([loaded, model.theta[60:]]))
    still = pid.Signals.of_states(Q, np.zeros(6), np.zeros(6))
    found = pid.diagnose_at_rest(model, [pose(tmp_path, "load.csv", heavier.torque(still)[0])])
    assert {2, 3} <= set(found.outside)
    assert 1 not in found.outside
    assert "joints 2, 3" in repr(found)


def test_friction_that_grows_with_load_holds_more(model: pid.Model, ur5: pid.Robot) -> None:
    """Coulomb and load-dependent friction add; presliding bristles hold stiffness times distance."""
    effects = pid.make_effects(["rigid_body", "coulomb_friction", "load_dependent_friction", "presliding_hysteresis"])
    bristles = replace(effects[3], distance=(0.001,) * 6)
    theta = np.concatenate([ur5.nominal, DRY, np.full(6, MU), np.full(6, 1000.0)])
    expected = DRY + MU * np.abs(gravity(ur5, Q)) + 1.0
    np.testing.assert_allclose(breakaway(pid.Model(ur5, (*effects[:3], bristles), theta), Q), expected, rtol=0.01)
    viscous = breakaway(model, Q) - DRY
    assert (np.abs(viscous) < 0.05 * DRY + 0.15).all()  # at a creep


def test_an_uncertain_model_is_contradicted_later(model: pid.Model, ur5: pid.Robot, tmp_path: Path) -> None:
    """The same torque, one friction and a half from gravity, leaves the band of a known model alone."""
    from physident.estimation.estimate import as_estimate

    recording = pose(tmp_path, "pose.csv", gravity(ur5, Q) + 1.5 * np.array([0, 1, 0, 0, 0, 0]) * DRY)
    known = as_estimate(model, pid.Filter())
    vague = replace(known, covariance=np.eye(known.base.r) * 4.0)
    assert pid.diagnose_at_rest(known, [recording]).outside == (2,)
    assert pid.diagnose_at_rest(vague, [recording]).outside == ()


def test_the_command_line_takes_poses_as_they_are(
    model: pid.Model, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from physident.estimation.estimate import as_estimate

    as_estimate(model, pid.Filter()).save(tmp_path / "model.json")
    recording = pose(tmp_path, "pose.csv", gravity(model.robot, Q) + 0.5 * DRY)
    assert is_at_rest([recording])
    base = ["diagnose", "--model", str(tmp_path / "model.json"), recording.source]
    assert run([*base, "--json", str(tmp_path / "found.json")]) == 0
    assert "breakaway torque" in capsys.readouterr().out
    kept = json.loads((tmp_path / "found.json").read_text(encoding="utf-8"))
    assert kept["schema"] == "physident.at_rest/1"
    np.testing.assert_allclose(kept["poses"][0]["held"], 0.5 * DRY, atol=0.05)
    assert run([*base, "--out", str(tmp_path / "out.json")]) == 2
    assert "no recording moves" in capsys.readouterr().err
    assert not (tmp_path / "out.json").exists()


def test_a_motion_is_not_a_pose(model: pid.Model, tmp_path: Path) -> None:
    path = tmp_path / "moving.csv"
    time = np.arange(500) / 125
    q = Q + 0.2 * np.sin(time)[:, None]
    names = ["time", *(f"{x}_{j}" for x in ("q", "tau") for j in range(1, 7))]
    np.savetxt(
        path, np.column_stack([time, q, q]), delimiter=",", comments="", header=",".join(names), encoding="utf-8"
    )
    with pytest.raises(pid.InputError, match="the arm moves"):
        pid.diagnose_at_rest(model, [pid.load_recording(path)])
    with pytest.raises(pid.InputError, match="no recordings given"):
        pid.diagnose_at_rest(model, [])
