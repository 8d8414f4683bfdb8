"""physident plan and resume: from no recording, over a session, to the next one; options and files that are refused."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from physident.effects.transmission import LoadDependentFriction
from physident.estimation.estimate import as_estimate
from tests.bad_input import one_line_error
from tests.bad_input.good import URDF

FAST = ["--minutes", "1", "--limits", "joint", "--pool", "6"]
SENSORS = {"schema": "physident.sensors/1", "torque_noise": 0.05, "velocity_noise": 1e-4}


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with an arm, its first session, recordings of it from an arm whose friction depends on load, and what they said."""
    folder = tmp_path_factory.mktemp("session")
    (folder / "arm.urdf").write_text(URDF)
    (folder / "sensors.json").write_text(json.dumps(SENSORS))
    robot = pid.load_robot(folder / "arm.urdf")
    plain = pid.Model.nominal(robot)
    friction = {"coulomb_friction": 0.6, "viscous_friction": 0.8}
    theta = [friction.get(c.effect, t) for c, t in zip(plain.columns, plain.theta, strict=True)]
    truth = pid.Model(robot, (*plain.effects, LoadDependentFriction((2,))), np.append(theta, 0.4))
    as_estimate(truth, pid.Filter()).save(folder / "truth.json")
    assert run(["plan", "--robot", str(folder / "arm.urdf"), "--out", str(folder / "first"), *FAST]) == 0
    for leg in json.loads((folder / "first" / "session.json").read_text())["legs"]:
        motion, to = folder / "first" / f"{leg['name']}.json", folder / f"{leg['name']}.csv"
        command = ["simulate", "--model", str(folder / "truth.json"), "--trajectory", str(motion), "--out", str(to)]
        assert run([*command, "--sensors", str(folder / "sensors.json")]) == 0
    return folder


def test_a_session_is_resumed_and_the_next_one_is_planned(session, tmp_path, monkeypatch, capsys) -> None:
    shutil.copytree(session, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    legs = [leg["name"] for leg in json.loads(Path("first/session.json").read_text())["legs"]]
    for name in legs:
        assert all(Path(f"first/{name}{end}").stat().st_size > 50 for end in (".json", ".csv", ".script", ".yaml"))
        assert pid.load_trajectory(f"first/{name}.json").violations(pid.load_robot("arm.urdf")) == []
    assert Path("first/preview.rrd").stat().st_size > 10_000
    capsys.readouterr()
    files = [f"{name}.csv" for name in legs]
    assert run(["resume", "first", "--recordings", *files, "--out", "model.json", "--json", "found.json"]) == 0
    text = capsys.readouterr().out
    settled = text.partition("\nsettled:")[2].partition("not settled:")[0]
    assert "load-dependent friction (2): it is load-dependent friction on joint 2" in settled
    assert "another session" in text or "nothing is open" in text
    assert run(["plan", "--diagnosis", "found.json", "--out", "second", *FAST, "--robot-limits", "speed=0.5"]) == 0
    second = json.loads(Path("second/session.json").read_text())
    assert second["diagnosis"] == "diagnosis.json"
    for leg in second["legs"]:
        states = pid.load_trajectory(f"second/{leg['name']}.json").states(np.linspace(0, 15, 500))
        assert np.abs(states.v).max() <= 0.5
    for leg in second["legs"]:
        command = ["simulate", "--model", "truth.json", "--trajectory", f"second/{leg['name']}.json"]
        assert run([*command, "--sensors", "sensors.json", "--seed", "3", "--out", f"second_{leg['name']}.csv"]) == 0
    capsys.readouterr()
    in_order = [f"second_{leg['name']}.csv" for leg in second["legs"]]
    assert run(["resume", "second", "--recordings", *in_order, "--json", "again.json"]) == 0
    assert f"{len(legs) - 1} earlier recordings counted as well" in capsys.readouterr().out
    used = [one["path"] for one in json.loads(Path("again.json").read_text())["recordings"]]
    assert set(files[:-1]) | set(in_order) == set(used)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["plan", "--out", "x"], "which arm"),
        (["plan", "--robot", "arm.urdf", "--diagnosis", "d.json", "--out", "x"], "which arm"),
        (["plan", "--robot", "arm.urdf", "--out", "x", "--minutes", "0.2"], "minutes is 0.2"),
        (["plan", "--robot", "arm.urdf", "--out", "x", "--minutes", "nan"], "minutes is nan"),
        (["plan", "--robot", "arm.urdf", "--out", "x", "--load", "-1"], "load is -1"),
        (["plan", "--robot", "arm.urdf", "--out", "x", "--limits", "some"], "limits is 'some'"),
        (["plan", "--robot", "arm.urdf", "--out", "x", "--rate", "0"], "--rate is 0"),
        (["plan", "--robot", "arm.urdf", "--out", "x", "--noise", "-2", "--limits", "joint"], "noise is -2"),
        (["plan", "--robot", "arm.urdf", "--out", "x", "--robot-limits", "speed=-1"], "expected positive numbers"),
        (["plan", "--robot", "arm.urdf", "--out", "arm.urdf", *FAST], "expected a folder"),
        (["plan", "--diagnosis", "arm.urdf", "--out", "x"], "not valid JSON"),
        (["plan", "--diagnosis", "first/session.json", "--out", "x"], "schema is"),
        (["resume", "nowhere", "--recordings", "01.csv"], "nowhere"),
        (["resume", "first", "--recordings", "arm.urdf"], "1 recordings, expected"),
        (["resume", "first", "--recordings", "truth.json", "arm.urdf", "sensors.json", "x.csv"], "not found"),
    ],
)  # fmt: skip
def test_what_cannot_be_planned_is_refused_in_one_line(session, tmp_path, monkeypatch, capfd, arguments, says) -> None:
    shutil.copytree(session, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    one_line_error.fails(capfd, tmp_path, arguments, says)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"legs": 3}, "legs"),
        ({"expectations": [{"kind": "odd"}]}, "expectations"),
        ({"settings": {}}, "settings"),
        ({"model": {}}, "model"),
        ({"diagnosis": "diagnosis.json"}, "diagnosis.json"),
    ],
)
def test_a_session_that_was_edited_is_refused_in_one_line(session, tmp_path, monkeypatch, capfd, change, says) -> None:
    shutil.copytree(session, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    file = Path("first/session.json")
    file.write_text(json.dumps(json.loads(file.read_text()) | change))
    one_line_error.fails(capfd, tmp_path, ["resume", "first", "--recordings", "01_x.csv", "arm.urdf"], says)
