"""Rubbish fed to the verbs that use a model: simulate, export, payload, drive-gains, and effects on odd arms."""

from __future__ import annotations

import json
import re
import shutil
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from physident.excitation.motion.trajectory import random_trajectory
from tests.bad_input import one_line_error
from tests.bad_input.good import URDF

Change = dict[str, Any]
LOAD = 1.5  # kg, on the last link of the two-joint arm
SENSORS = {"schema": "physident.sensors/1", "torque_noise": 0.02, "velocity_noise": 1e-3}
CURRENTS = {**SENSORS, "effort": "current", "drive_gains": [10.0, 8.0], "current_noise": 0.002}
POINTS = {"schema": "physident.trajectory/1", "kind": "point_to_point", "speed": 1.0, "acceleration": 2.0}
HEAVY = URDF.replace('<mass value="1"/>', f'<mass value="{1 + LOAD}"/>')
ONE = (
    URDF[: URDF.index('  <link name="lower"')]
    + URDF[URDF.index('  <joint name="one"') : URDF.index('  <joint name="two"')]
)


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A two-joint arm, its motion, recordings with and without load, and models of it and of friction alone."""
    folder = tmp_path_factory.mktemp("models")
    (folder / "arm.urdf").write_text(URDF)
    (folder / "heavy.urdf").write_text(HEAVY)
    (folder / "one.urdf").write_text(f"{ONE}</robot>\n")
    robot = pid.load_robot(folder / "arm.urdf")
    for seed, name in enumerate(("t", "u")):
        random_trajectory(robot, seed, base_frequency=0.25, duration=8.0).save(folder / f"{name}.json")
    random_trajectory(pid.load_robot(folder / "one.urdf"), 0, base_frequency=0.25, duration=8.0).save(folder / "w.json")
    (folder / "s.json").write_text(json.dumps(SENSORS))
    (folder / "c.json").write_text(json.dumps(CURRENTS))
    at = [str(folder / name) for name in ("t.json", "u.json", "w.json", "s.json", "c.json")]
    made = {"a": ("arm", 0, 3), "b": ("heavy", 1, 3), "i": ("arm", 0, 4), "j": ("heavy", 1, 4), "one": ("one", 2, 3)}
    for name, (arm, motion, sensors) in made.items():
        command = [
            "simulate",
            "--robot",
            str(folder / f"{arm}.urdf"),
            "--trajectory",
            at[motion],
            "--sensors",
            at[sensors],
        ]
        assert run([*command, "--out", str(folder / f"{name}.csv")]) == 0
    identify = ["identify", str(folder / "a.csv"), "--robot", str(folder / "arm.urdf"), "--effects"]
    physical = ["rigid_body,rotor_inertia,viscous_friction", "--method", "physical"]
    for name, arguments in (("m", physical), ("f", ["viscous_friction"])):
        assert run([*identify, *arguments, "--out", str(folder / f"{name}.json")]) == 0
    return folder


@pytest.fixture
def folder(bench: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    shutil.copytree(bench, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def fails(capfd: pytest.CaptureFixture, folder: Path, arguments: list[str], says: str) -> None:
    one_line_error.fails(capfd, folder, arguments, re.escape(says))  # here the words are no pattern


TO = ["--out", "out.csv"]
SIMULATE = ["simulate", "--robot", "arm.urdf", *TO, "--trajectory"]
OUTPUT = "is also read by this command"
GAINS = ["drive-gains", "--robot", "arm.urdf", "--unloaded", "i.csv", "--loaded", "j.csv", "--load-mass"]
OPTIONS: dict[str, tuple[list[str], str]] = {
    "simulate onto its motion": (["simulate", "--robot", "arm.urdf", "--trajectory", "a.csv", "--out", "a.csv"], OUTPUT),
    "simulate onto its model": (["simulate", "--model", "b.csv", "--trajectory", "t.json", "--out", "./b.csv"], OUTPUT),
    "simulate onto its sensors": ([*SIMULATE[:3], "--trajectory", "t.json", "--sensors", "a.csv", "--out", "a.csv"], OUTPUT),
    "simulate into no folder": ([*SIMULATE[:3], "--trajectory", "t.json", "--out", "no/o.csv"], "folder that does not"),
    "simulate into another format": ([*SIMULATE[:3], "--trajectory", "t.json", "--out", "o.npz"], "ends in .csv"),
    "two arms": ([*SIMULATE, "t.json", "--model", "m.json"], "which arm?"),
    "another robot's motion": (["simulate", "--robot", "ur5", "--trajectory", "t.json", *TO], "2 joints, but robot ur5 has 6"),
    "motion is a model": ([*SIMULATE, "m.json"], "physident.model/1"),
    "motion is missing": ([*SIMULATE, "no.json"], "no.json"),
    "sensors are a motion": ([*SIMULATE, "t.json", "--sensors", "u.json"], "physident.sensors/1"),
    "unknown controller": ([*SIMULATE, "t.json", "--controller", "pid"], "'pid'"),
    "export of nothing": (["export", "--model", "m.json"], "nothing to write"),
    "export onto its model": (["export", "--model", "m.json", "--json", "./m.json"], OUTPUT),
    "export of two into one": (["export", "--model", "m.json", "--json", "x", "--urdf", "./x"], "given twice"),
    "export into no folder": (["export", "--model", "m.json", "--json", "x", "--python", "no/x.py"], "folder"),
    "export of a recording": (["export", "--model", "a.csv", "--json", "x"], "not valid JSON"),
    "export of friction as links": (["export", "--model", "f.json", "--urdf", "x"], "no rigid_body"),
    "payload onto its recording": (["payload", "b.csv", "--model", "m.json", "--json", "b.csv"], OUTPUT),
    "payload onto its model": (["payload", "b.csv", "--model", "m.json", "--json", "m.json"], OUTPUT),
    "payload of a fitted recording": (["payload", "a.csv", "--model", "m.json"], "training recording"),
    "payload of another robot": (["payload", "one.csv", "--model", "m.json"], "1 joints, but robot arm has 2"),
    "payload on friction alone": (["payload", "b.csv", "--model", "f.json"], "no rigid_body"),
    "payload with empty columns": (["payload", "b.csv", "--model", "m.json", "--columns", ""], "columns"),
    "payload that the motion hides": (["payload", "b.csv", "--model", "m.json"], "no motion of this arm shows"),
    "payload of one recording twice": (["payload", "b.csv", "./b.csv", "--model", "m.json"], "each recording once"),
    "gains of one recording twice": ([*GAINS, "1.5", "--loaded", "./j.csv"], "each recording once"),
    "gains onto a recording": ([*GAINS, "1.5", "--json", "i.csv"], OUTPUT),
    "gains onto the robot": ([*GAINS, "1.5", "--json", "arm.urdf"], OUTPUT),
    "gains from grams": ([*GAINS, "1500"], "expected kilograms"),
    "gains from no mass": ([*GAINS, "0"], "weigh the load"),
    "gains from torques": ([*GAINS[:3], "--unloaded", "a.csv", "--loaded", "b.csv", "--load-mass", "1"], "contains torques"),
    "gains from one recording": ([*GAINS[:3], "--unloaded", "i.csv", "--loaded", "i.csv", "--load-mass", "1"], "both"),
    "gains beside a shape": ([*GAINS, "1.5", "--effects", "rigid_body,stribeck_friction"], "stribeck_friction (velocity)"),
    "gains beside a gain": ([*GAINS, "1.5", "--effects", "rigid_body,torque_constant"], "torque_constant"),
    "coupling of one joint": (["identify", "one.csv", "--robot", "one.urdf", "--effects", "rigid_body,coupled_friction", *TO], "one joint"),
    "link before the only one": (["identify", "one.csv", "--robot", "one.urdf", "--effects", "rigid_body,link_inertia", *TO], "one link"),
}  # fmt: skip


@pytest.mark.parametrize("case", OPTIONS)
def test_options(case: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    fails(capfd, folder, *OPTIONS[case])


MOTIONS: dict[str, tuple[Change, str]] = {
    "endless": ({"duration": 1e9}, "steps"),
    "beyond numbers": ({"duration": 1e300}, "1e+300"),
    "not a number": ({"duration": float("nan")}, "nan"),
    "an integer of 400 digits": ({"duration": 10**400}, "duration"),
    "an integer of 5000 digits": ({"duration": 0, "note": "digits"}, "not valid JSON"),
    "too short": ({"duration": 0.5}, "lasts 0.5 s"),
    "no frequency": ({"base_frequency": 1e-300}, "base_frequency"),
    "too high a frequency": ({"base_frequency": 1e300}, "base_frequency"),
    "too large": ({"a": [[1e308, 1e308]] * 2, "b": [[1e308, 1e308]] * 2}, "1e+308"),
    "too many harmonics": ({"a": [[0.0] * 20000] * 2, "b": [[0.0] * 20000] * 2}, "harmonics"),
    "ragged": ({"a": [[0.1, 0.2], [0.1]]}, "a has a value that is no number"),
    "beyond the limits": ({"q0": [9.0, 0.0]}, "joint 1 goes from"),
    "slow moves": (POINTS | {"points": [[0, 0], [1, 1]], "speed": 1e-9}, "steps"),
    "gentle moves": (POINTS | {"points": [[0, 0], [1, 1]], "acceleration": 1e-100}, "steps"),
    "moves to nowhere": (POINTS | {"points": [[0, 0], [0, 0]]}, "without a move"),
    "another kind": ({"kind": "spline"}, "'spline'"),
    "an unknown setting": ({"colour": 1}, "colour"),
}


@pytest.mark.parametrize("case", MOTIONS)
def test_motions(case: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    change, says = MOTIONS[case]
    motion = change if "points" in change else json.loads((folder / "t.json").read_text()) | change
    text = json.dumps(motion).replace('"note": "digits"', f'"note": {"9" * 5000}')
    (folder / "x.json").write_text(text)
    fails(capfd, folder, [*SIMULATE, "x.json"], says)


def test_huge_files_are_not_read(folder: Path, capfd: pytest.CaptureFixture) -> None:
    with (folder / "huge.json").open("wb") as stream:
        stream.truncate(8 << 30)
    fails(capfd, folder, [*SIMULATE, "huge.json"], "bytes")
    fails(capfd, folder, [*SIMULATE, "t.json", "--sensors", "huge.json"], "bytes")


SETTINGS: dict[str, tuple[Change, str]] = {
    "no rate": ({"rate": 0}, "rate is 0"),
    "a rate that shows no motion": ({"rate": 5}, "10 to 100000 Hz"),
    "a rate in words": ({"rate": "fast"}, "'fast'"),
    "noise beyond numbers": ({"torque_noise": 1e308}, "torque_noise"),
    "an integer of 400 digits": ({"jitter": 10**400}, "jitter"),
    "one gain for all": ({"effort": "current", "drive_gains": 5}, "one for each joint"),
    "too few gains": ({"effort": "current", "drive_gains": [5]}, "2 positive numbers"),
    "currents without gains": ({"effort": "current"}, "states none"),
    "noise of three joints": ({"torque_noise": [1, 2, 3]}, "3 values"),
    "no temperature": ({"temperature": {"start": None}}, "start [degC]"),
    "most rows dropped": ({"dropped": 0.6}, "below 0.5"),
    "an unknown setting": ({"colour": 1}, "'colour'"),
}


@pytest.mark.parametrize("case", SETTINGS)
def test_sensors(case: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    change, says = SETTINGS[case]
    (folder / "x.json").write_text(json.dumps(SENSORS | change))
    fails(capfd, folder, [*SIMULATE, "t.json", "--sensors", "x.json"], says)


def parameter(name: str, value: float) -> Callable[[dict], None]:
    def change(model: dict) -> None:
        next(p for p in model["parameters"] if p["name"] == name)["value"] = value

    return change


MODELS: dict[str, tuple[str, float, list[str], str]] = {
    "no mass as a link": ("m_2", 0.0, ["export", "--urdf", "x.urdf", "--json", "x"], "link 2 (lower, moved by two)"),
    "negative mass as a link": ("m_2", -1.0, ["export", "--json", "x", "--urdf", "x.urdf"], "not positive"),
    "a rotor that falls upwards": (
        "rotor_inertia_2",
        -9.0,
        ["simulate", "--trajectory", "t.json", *TO],
        "not positive",
    ),
    "friction that drives": ("viscous_friction_1", -90.0, ["simulate", "--trajectory", "t.json", *TO], "joint 1"),
    "a parameter beyond numbers": ("m_2", 1e140, ["payload", "b.csv"], "m_2 is 1e+140 kg"),
}


@pytest.mark.parametrize("case", MODELS)
def test_models(case: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    name, value, verb, says = MODELS[case]
    model = json.loads((folder / "m.json").read_text())
    parameter(name, value)(model)
    (folder / "x.json").write_text(json.dumps(model))
    fails(capfd, folder, [*verb, "--model", "x.json"], says)


def test_a_model_that_feels_temperature_asks_for_it(folder: Path, capfd: pytest.CaptureFixture) -> None:
    from physident.effects.thermal import WarmUp

    with warnings.catch_warnings(action="ignore", category=pid.PhysidentWarning):
        (folder / "x.json").write_text(json.dumps(SENSORS | {"temperature": {"time_constant": 3.0}}))
        assert run([*SIMULATE, "u.json", "--sensors", "x.json"]) == 0
        warm = pid.load_recording("out.csv")
        pid.identify(pid.load_robot("arm.urdf"), [warm], ["rigid_body", WarmUp(reference_temperature=25.0)]).save(
            "w.json"
        )
    (folder / "out.csv").unlink()
    fails(capfd, folder, ["validate", "b.csv", "--model", "w.json"], "no temperature channel")
    fails(capfd, folder, ["simulate", "--model", "w.json", "--trajectory", "t.json", *TO], "sensors with temperature")
    assert run(["simulate", "--model", "w.json", "--trajectory", "t.json", "--sensors", "x.json", *TO]) == 0


def test_one_joint_has_a_table_of_effects(folder: Path, capfd: pytest.CaptureFixture) -> None:
    assert run(["inspect", "one.csv", "--robot", "one.urdf", "--effects", "all"]) == 0
    shown = capfd.readouterr().out
    assert "joint_spring" in shown
    assert "coupled_friction" not in shown


def test_the_unbroken_files_pass(folder: Path) -> None:
    """What every case breaks is good before."""
    for sensors in ("s.json", "c.json"):
        assert run([*SIMULATE, "t.json", "--sensors", sensors, "--force"]) == 0
    assert run(["simulate", "--model", "m.json", "--trajectory", "u.json", *TO, "--force"]) == 0
    assert run(["validate", "b.csv", "--model", "m.json"]) == 0
    assert run(["export", "--model", "m.json", "--urdf", "x.urdf", "--json", "x.json", "--python", "x.py"]) == 0
    gains: dict[str, Any] = {}
    exec((folder / "x.py").read_text(), gains)
    model = pid.load_estimate("m.json").model
    q, v, a = np.random.default_rng(0).standard_normal((3, 20, 2))
    np.testing.assert_allclose(gains["torque"](q, v, a), model.torque(pid.Signals.of_states(q, v, a)), atol=1e-9)
