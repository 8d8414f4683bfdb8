"""Recordings that a diagnosis or an identification cannot use are refused in one line, before the search begins."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from physident.recordings.checks import check_effort
from tests.bad_input.good import CURRENT, HEADER, as_csv, table
from tests.bad_input.one_line_error import fails

Change = Callable[[np.ndarray], None]
TAU, Q, DQ = slice(13, 19), slice(1, 7), slice(7, 13)
WARM = ",".join([HEADER, *(f"temperature_{j}" for j in range(1, 7))])


def constant(joint: int, value: float) -> Change:
    def change(values: np.ndarray) -> None:
        values[:, 12 + joint] = value

    return change


def milli(values: np.ndarray) -> None:
    values[:, TAU] *= 1000.0 / 5  # a fifth: above 1e5 rows are left out as absurd


def brief(values: np.ndarray) -> None:
    """The arm moves for 0.3 s and stands for the rest: shorter than the filter's second."""
    stop = 30
    values[stop:, Q] = values[stop, Q]
    values[stop:, DQ] = 0.0


def still(values: np.ndarray) -> None:
    values[:, Q], values[:, DQ] = 0.0, 0.0


def made(factor: float, *changes: Change) -> np.ndarray:
    """The table with its torques scaled, so that it is another recording, and changed."""
    values = table()
    values[:, TAU] *= factor
    for change in changes:
        change(values)
    return values


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Files by name: recordings that fit, one fault each, and a model."""
    folder = tmp_path_factory.mktemp("bench")
    warmth = np.column_stack([np.linspace(20, 30, len(table()))] * 6)
    files = {
        "good": as_csv(made(1.0)), "new": as_csv(made(1.01)), "again": as_csv(made(1.01)), "unseen": as_csv(made(1.02)),
        "brief": as_csv(made(1.03, brief)), "still": as_csv(made(1.03, still)), "milli": as_csv(made(1.03, milli)),
        "stuck": as_csv(made(1.03, constant(3, 4.5))), "dead": as_csv(made(1.03, constant(5, 0.0))),
        "still_milli": as_csv(made(1.03, still, milli)), "still_again": as_csv(made(1.03, still)),
        "warm": as_csv(np.column_stack([made(1.04), warmth]), WARM),
        "stuck_current": as_csv(made(0.1, constant(2, 0.75)), CURRENT), "milliamps": as_csv(made(100.0), CURRENT),
        "three": as_csv(made(1.03)[:, [0, 1, 2, 3, 13, 14, 15]], "time,q_1,q_2,q_3,tau_1,tau_2,tau_3"),
    }  # fmt: skip
    for name, text in files.items():
        (folder / f"{name}.csv").write_text(text)
    fit = ["identify", str(folder / "good.csv"), "--robot", "ur5", "--method", "ols"]
    assert run([*fit, "--out", str(folder / "model.json")]) == 0
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture
def folder(bench: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A fresh folder of these files, in which a search that begins is a failure."""

    def search(*_: object) -> None:
        raise AssertionError("the search began")

    for name, content in bench.items():
        (tmp_path / name).write_bytes(content)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("physident.diagnosis.searched.search_and_learn", search)
    return tmp_path


MODEL = ["diagnose", "--model", "model.json"]
ROBOT = ["diagnose", "--robot", "ur5"]
TO = ["--robot", "ur5", "--out", "out.json"]
GAINS = ["--drive-gains", "10 10 10 10 10 10"]
CASES: dict[str, tuple[list[str], str]] = {
    "one recording twice": ([*MODEL, "new.csv", "again.csv"], "again.csv: has the same samples as new.csv.*once"),
    "one recording twice, nominal": ([*ROBOT, "new.csv", "again.csv"], "same samples as new.csv"),
    "one holdout twice": ([*MODEL, "unseen.csv", "--holdout", "new.csv", "--holdout", "again.csv"], "same samples as new"),
    "one pose twice": ([*ROBOT, "still.csv", "still_again.csv"], "same samples as still.csv"),
    "holdout diagnosed": ([*MODEL, "new.csv", "--holdout", "again.csv"], "fitted or diagnosed already"),
    "holdout of other joints": ([*MODEL, "new.csv", "--holdout", "three.csv"], "3 joints, but robot ur5 has 6"),
    "holdout too short": ([*MODEL, "new.csv", "unseen.csv", "--holdout", "brief.csv"], "brief.csv: .*(shorter|no rows are left)"),
    "one holdout of two too short": (
        [*ROBOT, "new.csv", "--holdout", "unseen.csv", "--holdout", "brief.csv"], "brief.csv: .*shorter than the filter"
    ),
    "holdout at rest": ([*MODEL, "new.csv", "--holdout", "still.csv"], "still.csv: no joint moves"),
    "holdout of another unit": ([*MODEL, "new.csv", "--holdout", "milli.csv"], "milli.csv.*mN m"),
    "holdout with a dead channel": ([*ROBOT, "new.csv", "--holdout", "dead.csv"], "dead.csv.*joint 5"),
    "holdout of unreadable columns": ([*MODEL, "new.csv", "--holdout", "model.json"], "model.json"),
    "holdout without temperature": ([*MODEL, "warm.csv", "--holdout", "unseen.csv"], "without temperatures"),
    "constant torque, identify": (["identify", "stuck.csv", *TO], r"torque of joint 3 is 4.5 N m in every row.*leave the rec"),
    "constant torque, missing": ([*MODEL, "stuck.csv"], "torque of joint 3 is 4.5 N m in every row"),
    "constant torque, nominal": ([*ROBOT, "new.csv", "dead.csv"], "dead.csv: the torque of joint 5 is 0 N m"),
    "constant current": (["identify", "stuck_current.csv", *TO, *GAINS], "current of joint 2 is 0.75 A in every row"),
    "mN m, identify": (["identify", "milli.csv", *TO], r"times the robot's effort limit of (150|28) N m.*mN m\?"),
    "mN m, different": ([*MODEL, "milli.csv"], r"effort limit.*mN m\?"),
    "mN m, nominal": ([*ROBOT, "milli.csv"], r"effort limit.*mN m\?"),
    "mN m, payload": (["payload", "milli.csv", "--model", "model.json"], r"effort limit.*mN m\?"),
    "mN m at rest": ([*ROBOT, "still_milli.csv"], r"effort limit.*mN m\?"),
    "mA": (["identify", "milliamps.csv", *TO, *GAINS], r"effort limit.*mA\?"),
    "an effect twice": ([*ROBOT, "new.csv", "--effects", "viscous_friction,viscous_friction"], "viscous_friction twice"),
    "rigid_body twice": ([*ROBOT, "new.csv", "--effects", "rigid_body, rigid_body"], "rigid_body twice"),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_refused_before_the_search(case: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    fails(capfd, folder, *CASES[case])


def test_the_unbroken_files_reach_the_search(folder: Path) -> None:
    """What every case breaks is good before, and so are rigid_body named once and a recording with its own holdout."""
    for start in (MODEL, [*ROBOT, "--effects", "rigid_body,viscous_friction"]):
        with pytest.raises(AssertionError, match="the search began"):
            run([*start, "new.csv", "--holdout", "unseen.csv"])
    with pytest.raises(AssertionError, match="the search began"):
        run([*MODEL, "unseen.csv", "--holdout", "warm.csv"])


VERBS: dict[str, Callable[[pid.Estimate, pid.Recording], object]] = {
    "identify": lambda model, one: pid.identify(model.model.robot, [one]),
    "validate": lambda model, one: pid.validate(model, [one]),
    "compare": lambda model, one: pid.compare(model, model, on=[one]),
    "payload": lambda model, one: pid.identify_payload(model, [one]),
    "diagnose": lambda model, one: pid.diagnose(model, [one]),
    "holdout": lambda model, one: pid.diagnose(model, [pid.load_recording("new.csv")], [one]),
}


@pytest.mark.parametrize("name", ["stuck", "milli"])
@pytest.mark.parametrize("verb", VERBS)
def test_python_refuses_what_the_command_line_does(verb: str, name: str, folder: Path) -> None:
    model = pid.load_estimate("model.json")
    says = {"stuck": "torque of joint 3 is 4.5 N m in every row", "milli": "is the log in mN m"}[name]
    with pytest.raises(pid.InputError, match=rf"{name}\.csv: .*{says}"):
        VERBS[verb](model, pid.load_recording(f"{name}.csv"))


def test_a_dead_channel_can_be_looked_at(folder: Path, capfd: pytest.CaptureFixture) -> None:
    """What is seen of effects depends on the motion alone: inspecting is how a dead channel is found."""
    assert run(["inspect", "stuck.csv", "--robot", "ur5", "--effects", "viscous_friction"]) == 0
    assert "verdict" in capfd.readouterr().out


def recording(robot: pid.Robot, travel: float, torque: np.ndarray) -> pid.Recording:
    """Joint 1 moves over ``travel`` [rad] with the torque (N,), the others with torques that vary."""
    time = np.arange(len(torque)) / 100
    q = np.column_stack([travel / 2 * np.sin(2 * np.pi * time)] + [np.sin(time + j) for j in range(1, robot.n)])
    return pid.Recording(time, q, np.column_stack([torque, *q.T[1:]]), "torque", source="run")


def test_a_quiet_channel_is_no_constant_one(ur5: pid.Robot) -> None:
    """A joint that hardly moves may hold one coarse value; one last bit of difference is a measurement."""
    flat = np.full(400, 3.0)
    with pytest.raises(pid.InputError, match="joint 1"):
        check_effort([recording(ur5, 1.0, flat)], ur5)
    check_effort([recording(ur5, 0.04, flat)], ur5)
    lively = flat.copy()
    lively[200] = np.nextafter(3.0, 4.0)
    check_effort([recording(ur5, 1.0, lively)], ur5)


def test_torques_are_refused_from_ten_times_the_limit_on(ur5: pid.Robot) -> None:
    """Up to there they may be true, as a few spikes may; a robot that states no limit has nothing to go by."""
    limit = float(ur5.torque_limit[0])
    wave = np.where(np.arange(400) % 2, 1.0, -1.0) * limit
    for times, refused in ((9.9, False), (10.1, True), (1000.0, True)):
        one = recording(ur5, 1.0, times * wave)
        if refused:
            with pytest.raises(pid.InputError, match="joint 1 reaches"):
                check_effort([one], ur5)
        else:
            check_effort([one], ur5)
    spikes = wave.copy()
    spikes[[100, 300]] *= 1000
    check_effort([recording(ur5, 1.0, spikes)], ur5)
    free = replace(ur5, urdf=ur5.urdf.replace('effort="', 'effort="0" was="'))
    assert np.isinf(free.torque_limit).all()
    check_effort([recording(free, 1.0, 1000 * wave)], free)


@pytest.mark.parametrize("arm", ["ur5", "ur10e"])
def test_real_recordings_are_not_refused(arm: str, data: Path, ur5: pid.Robot) -> None:
    robot = ur5 if arm == "ur5" else pid.load_robot(data / "ur10e" / "ur10e.urdf")
    layout = None if arm == "ur5" else "time=0,q=1:7,dq=7:13,current=13:19"
    files = sorted(os.fspath(path) for path in (data / arm).glob("*.csv*"))
    check_effort(pid.load_recordings(files[:4], layout, (12.0,) * 6), robot)
