"""What an export loses of a model: hysteresis keeps its sliding level as Coulomb friction, and a worse torque is stated."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from physident.effects.hysteresis import PreslidingHysteresis
from physident.estimation.results.fitted import fitted_recordings
from physident.export.held import loss_of_torque
from physident.export.urdf import urdf_of
from physident.export.urdf_edit import parse_elements

EFFECTS = ("rigid_body", "viscous_friction", "coulomb_friction")


@pytest.fixture(scope="module")
def arm() -> pid.Model:
    """A UR5 whose dry friction is half Coulomb friction, half hysteresis over a tenth of a milliradian."""
    robot = pid.load_robot("ur5")
    effects = pid.make_effects([*EFFECTS, PreslidingHysteresis((2, 3), (1e-4, 2e-4))])
    theta = pid.Model.nominal(robot, effects).theta.copy()
    theta[60:72] = [10.0] * 3 + [3.0] * 3 + [8.0] * 3 + [2.0] * 3
    theta[72:] = [8.0 / 1e-4, 4.0 / 2e-4]
    return pid.Model(robot, effects, theta)


def test_hysteresis_is_folded_into_the_dry_friction_that_it_reaches(arm: pid.Model) -> None:
    exported = urdf_of(arm)
    friction = [
        float(joint.find_all("dynamics")[0].attributes["friction"])
        for joint in parse_elements(exported.text).find_all("joint")
        if joint.find_all("dynamics")
    ]
    np.testing.assert_allclose(friction, [8.0, 16.0, 12.0, 2.0, 2.0, 2.0])
    # the torque of sliding at a constant speed, well beyond the presliding distance
    time = np.arange(200) / 100.0
    v = np.full((200, 6), 0.3)
    s = pid.Signals(time, v * time[:, None], v, np.zeros_like(v), rate=100.0)
    np.testing.assert_allclose(exported.held.model.torque(s)[100:], arm.torque(s)[100:], rtol=1e-9, atol=1e-9)
    assert "presliding_hysteresis on joints 2, 3 written as coulomb_friction [N m] 8, 4" in repr(exported)
    assert not [text for text in exported.inexpressible if "hysteresis" in text]


def test_a_torque_that_errs_more_is_stated_with_and_without_the_recordings(
    arm: pid.Model, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    motion = pid.random_trajectory(arm.robot, seed=1, duration=20.0)
    time, q, v, a = motion.sample(125.0)
    signals = pid.Signals(time, q, v, a, rate=125.0)
    dry = pid.Model(arm.robot, arm.effects[:3], arm.theta[:72])
    theta = np.concatenate([dry.theta, [0.0, 0.0, 0.0, 20.0, 0.0, 0.0]])
    model = pid.Model(arm.robot, (*dry.effects, *pid.make_effects(["rotor_inertia"])), theta)
    torque = model.torque(signals) + 0.3 * np.random.default_rng(0).normal(size=q.shape)
    table = np.column_stack([time, q, v, torque])
    names = [f"{name}_{j}" for name in ("q", "dq", "tau") for j in range(1, 7)]
    np.savetxt(path := tmp_path / "a.csv", table, delimiter=",", header=",".join(["time", *names]), comments="")
    estimate = pid.identify(arm.robot, pid.load_recordings(path), [*EFFECTS, "rotor_inertia"], method="physical")
    at_hand = fitted_recordings(replace(estimate, fitted=()))
    assert [recording.sha256 for recording in at_hand] == [source.sha256 for source in estimate.sources]
    held = urdf_of(estimate.model).held.model
    for recordings, where in ((at_hand, "training recordings"), ([], "random motion")):
        loss = loss_of_torque(replace(estimate, sigma=np.full(6, 3.0)), held, recordings)
        assert loss is not None
        assert where in loss
        assert re.findall(r"joint (\d)", loss) == ["4"]
    for recordings in (at_hand, []):
        assert loss_of_torque(replace(estimate, model=dry), urdf_of(dry).held.model, recordings) is None
    estimate.save(tmp_path / "model.json")
    capsys.readouterr()
    assert run(["export", "--model", str(tmp_path / "model.json"), "--urdf", str(tmp_path / "a.urdf")]) == 0
    assert "on the training recordings than the model's own: joint 4" in capsys.readouterr().err
    path.write_text(path.read_text().replace("e-01", "e-02"))  # another recording under the same name
    assert fitted_recordings(replace(estimate, fitted=())) == ()
