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
from tests.followed import follow_exactly
from tests.test_how_to import played

pytestmark = pytest.mark.slow

FAST = ["--minutes", "1", "--limits", "joint", "--pool", "6"]
SENSORS = {"schema": "physident.sensors/1", "torque_noise": 0.05, "velocity_noise": 1e-4}


@pytest.fixture(scope="module")
def start(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what the page on sessions starts from: an arm's description, and the true arm, whose friction depends on load."""
    folder = tmp_path_factory.mktemp("session")
    (folder / "recordings").mkdir()
    (folder / "arm.urdf").write_text(URDF)
    (folder / "sensors.json").write_text(json.dumps(SENSORS))
    robot = pid.load_robot(folder / "arm.urdf")
    plain = pid.Model.nominal(robot)
    friction = {"coulomb_friction": 0.6, "viscous_friction": 0.8}
    theta = [friction.get(c.effect or "", float(t)) for c, t in zip(plain.columns, plain.theta, strict=True)]
    truth = pid.Model(robot, (*plain.effects, LoadDependentFriction((2,))), np.append(theta, 0.4))
    as_estimate(truth, pid.Filter()).save(folder / "truth.json")
    return folder


@pytest.fixture(scope="module")
def session(start: Path) -> Path:
    """The same folder with a first session that was planned."""
    assert run(["plan", "--robot", str(start / "arm.urdf"), "--out", str(start / "first"), *FAST]) == 0
    return start


def test_the_page_runs_and_the_next_session_counts_what_was_known(start, tmp_path, monkeypatch, capsys) -> None:
    shutil.copytree(start, tmp_path, dirs_exist_ok=True)
    played("plan-the-next-session.md", tmp_path, monkeypatch)
    monkeypatch.chdir(tmp_path)
    text = capsys.readouterr().out
    settled = text.partition("\nsettled:")[2].partition("not settled:")[0]
    assert "load-dependent friction (2): it is load-dependent friction on joint 2" in settled
    assert "another session" in text or "nothing is open" in text
    for folder in ("first", "second"):
        saved = json.loads(Path(folder, "session.json").read_text())
        assert (saved["diagnosis"] == "diagnosis.json") == (folder == "second")
        for leg in saved["legs"]:
            assert pid.load_trajectory(f"{folder}/{leg['name']}.json").violations(pid.load_robot("arm.urdf")) == []
            assert all(Path(folder, f"{leg['name']}{end}").stat().st_size > 50 for end in (".csv", ".script", ".yaml"))
        assert Path(folder, "preview.rrd").stat().st_size > 10_000
    follow_exactly(monkeypatch)  # that the arm can follow the planned motions was seen on the page
    in_order = [f"second_{leg['name']}.csv" for leg in saved["legs"]]
    for leg, to in zip(saved["legs"], in_order, strict=True):
        command = ["simulate", "--model", "truth.json", "--trajectory", f"second/{leg['name']}.json"]
        assert run([*command, "--sensors", "sensors.json", "--seed", "3", "--out", to]) == 0
    capsys.readouterr()
    assert run(["resume", "second", "--recordings", *in_order, "--json", "again.json"]) == 0
    assert "3 earlier recordings counted as well" in capsys.readouterr().out
    used = [Path(one["path"]).name for one in json.loads(Path("again.json").read_text())["recordings"]]
    assert set(in_order) < set(used)
    assert len(used) == len(in_order) + 3
    assert run(["plan", "--diagnosis", "again.json", "--out", "third", *FAST, "--robot-limits", "speed=0.5"]) == 0
    for leg in json.loads(Path("third/session.json").read_text())["legs"]:
        assert np.abs(pid.load_trajectory(f"third/{leg['name']}.json").states(np.linspace(0, 15, 500)).v).max() <= 0.5


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["plan", "--out", "x"], "which arm"),
        (["plan", "--robot", "arm.urdf", "--diagnosis", "d.json", "--out", "x"], "which arm"),
        (["plan", "--robot", "arm.urdf", "--out", "x", "--minutes", "0.2"], "minutes is 0.2"),
        (["plan", "--robot", "arm.urdf", "--out", "x", "--minutes", "nan"], "minutes is nan"),
        (["plan", "--robot", "arm.urdf", "--out", "x", "--load", "-1"], "load is -1"),
        (["plan", "--robot", "arm.urdf", "--out", "x", "--pool", "2"], "pool is 2"),
        (["plan", "--robot", "arm.urdf", "--out", "x", "--limits", "some"], "limits is 'some'"),
        (["plan", "--robot", "arm.urdf", "--out", "x", "--rate", "0"], "--rate is 0"),
        (["plan", "--robot", "arm.urdf", "--out", "x", "--noise", "-2", "--limits", "joint"], "noise is -2"),
        (["plan", "--robot", "arm.urdf", "--out", "x", "--robot-limits", "speed=-1"], "expected positive numbers"),
        (["plan", "--robot", "arm.urdf", "--out", "arm.urdf", *FAST], "expected a folder"),
        (["plan", "--robot", "arm.urdf", "--out", "x", *FAST, "--repeat", "none.csv"], "none.csv"),
        (["plan", "--diagnosis", "d.json", "--out", "x", "--repeat", "a.csv"], "expected --repeat with --robot only"),
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


def test_recordings_of_other_pieces_are_refused_and_of_none_are_named(session, tmp_path, monkeypatch, capfd) -> None:
    shutil.copytree(session, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    follow_exactly(monkeypatch)
    legs = [leg["name"] for leg in json.loads(Path("first/session.json").read_text())["legs"]]
    for k, name in enumerate(legs):
        made = ["simulate", "--model", "truth.json", "--trajectory", f"first/{name}.json", "--sensors", "sensors.json"]
        assert run([*made, "--seed", str(k), "--out", f"{k}.csv"]) == 0
    in_order = [f"{k}.csv" for k in range(len(legs))]
    one_line_error.fails(
        capfd, tmp_path, ["resume", "first", "--recordings", *reversed(in_order)], f"its motion is that of {legs[-1]}"
    )
    other = Path("other.csv")
    other.write_text(Path("0.csv").read_text())
    rows = np.genfromtxt(other, delimiter=",", names=True)
    columns = [rows[name] for name in rows.dtype.names or ()]
    for k, name in enumerate(rows.dtype.names or ()):
        if name.startswith("q_"):
            columns[k] = rows[name][::-1]
        if name.startswith("dq_"):
            columns[k] = -rows[name][::-1]
    np.savetxt(other, np.column_stack(columns), delimiter=",", header=",".join(rows.dtype.names or ()), comments="")
    capfd.readouterr()
    assert run(["resume", "first", "--recordings", "other.csv", *in_order[1:]]) == 0
    warned = [
        line for line in capfd.readouterr().err.splitlines() if "does not follow the planned motion of piece" in line
    ]
    assert len(warned) == 1
    assert all(word in warned[0] for word in ("other.csv", legs[0]))
    for k, name in enumerate(legs):
        Path(f"{k}.csv").rename(f"{name}.csv")
    assert run(["resume", "first", "--recordings", *(f"{name}.csv" for name in legs[1:])]) == 0
    assert f"{legs[0]}: not recorded" in capfd.readouterr().err
    held_out = [
        leg["name"] for leg in json.loads(Path("first/session.json").read_text())["legs"] if leg["role"] == "holdout"
    ]
    one_line_error.fails(
        capfd, tmp_path, ["resume", "first", "--recordings", f"{held_out[0]}.csv"], f"none of {legs[0]}"
    )


def test_earlier_motions_that_cannot_be_repeated_are_named(session, tmp_path, monkeypatch, capfd) -> None:
    shutil.copytree(session, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    follow_exactly(monkeypatch)
    leg = json.loads(Path("first/session.json").read_text())["legs"][0]["name"]
    made = ["simulate", "--model", "truth.json", "--trajectory", f"first/{leg}.json", "--sensors", "sensors.json"]
    assert run([*made, "--seed", "1", "--out", "whole.csv"]) == 0
    lines = Path("whole.csv").read_text().splitlines()
    middle = len(lines) // 2
    Path("gap.csv").write_text("\n".join([*lines[:middle], *lines[middle + 120 :]]) + "\n")
    capfd.readouterr()
    assert (
        run(["plan", "--robot", "arm.urdf", "--out", "x", *FAST, "--repeat", "gap.csv", "--repeat", "whole.csv"]) == 0
    )
    said = " ".join(capfd.readouterr().out.split())
    assert "the motion of gap.csv is not repeated: it has gaps" in said
    assert "1 piece repeats an earlier motion" in said
    twice = ["plan", "--robot", "arm.urdf", "--out", "y", *FAST, "--repeat", "whole.csv", "--repeat", "whole.csv"]
    one_line_error.fails(capfd, tmp_path, twice, "whole.csv")


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
