"""Recordings from arrays and frames, and recordings or paths wherever recordings are taken."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import physident as pid
from physident.recordings.recording import Recording
from tests.bad_input.good import as_csv, table
from tests.conftest import ROOT
from tests.loads import SENSORS, arm, body, record

GAINS = (10.7, 10.7, 10.7, 10.2, 10.2, 10.2)


def arrays() -> dict[str, Any]:
    values = table()
    return {"time": values[:, 0], "q": values[:, 1:7], "effort": values[:, 13:], "dq": values[:, 7:13]}


def test_bad_rows_are_left_out_and_the_arrays_stay_as_they_were() -> None:
    given = arrays()
    given["q"][50, 2] = np.nan
    given["effort"][60] = np.inf
    given["time"][70] = given["time"][65]
    before = {name: array.copy() for name, array in given.items()}
    recording = Recording.from_arrays(**given)
    assert [bad.row for bad in recording.rejected] == [51, 61, 71]
    for name, array in given.items():
        assert array.flags.writeable
        np.testing.assert_array_equal(array, before[name])
    kept = recording.effort[0, 0]
    given["effort"][0, 0] += 1
    assert recording.effort[0, 0] == kept
    assert not recording.effort.flags.writeable


def test_the_constructor_takes_good_rows_and_leaves_the_arrays_writable() -> None:
    given = arrays()
    recording = Recording(**given, effort_kind="torque")
    assert all(array.flags.writeable for array in given.values())
    assert recording.n == 6
    given["q"][50, 2] = np.nan
    with pytest.raises(pid.InputError, match="expected good rows only"):
        Recording(**given, effort_kind="torque")


BAD = {
    "reversed time": (lambda a: a.update(time=a["time"][::-1]), "clock stands or runs backwards"),
    "degrees": (lambda a: a.update(q=np.degrees(a["q"])), "convert degrees"),
    "milliseconds": (lambda a: a.update(time=1000 * a["time"]), "milliseconds"),
    "all NaN": (lambda a: a.update(effort=a["effort"] * np.nan), "400 of 400 rows are bad"),
    "other rows": (lambda a: a.update(q=a["q"][:50]), "do not fit"),
    "across": (lambda a: a.update(q=a["q"].T), r"q \(6, 400\) do not fit"),
    "fewer efforts": (lambda a: a.update(effort=a["effort"][:, :5]), r"effort is \(400, 5\), expected the shape of q"),
    "one joint as a vector": (lambda a: a.update(q=a["q"][:, 0]), r"q \(400,\) do not fit"),
    "ragged": (lambda a: a.update(q=[[1.0], [1.0, 2.0]]), "no array of real numbers"),
    "words": (lambda a: a.update(time=["now"] * 400), "no array of real numbers"),
    "complex": (lambda a: a.update(q=1j * a["q"]), "no array of real numbers"),
    "dates": (lambda a: a.update(time=np.arange(400).astype("datetime64[ms]")), "no array of real numbers"),
    "time and rate": (lambda a: a.update(rate=125.0), "expected the time"),
    "neither": (lambda a: a.update(time=None), "expected the time"),
    "no rate": (lambda a: a.update(time=None, rate=0.0), "rate is 0.0"),
    "five gains": (lambda a: a.update(drive_gains=[1.0] * 5), "5 drive gains, expected 6"),
    "gains of torques": (lambda a: a.update(drive_gains=[1.0] * 6, effort_kind="torque"), "contains torques"),
    "another kind": (lambda a: a.update(effort_kind="force"), "effort_kind is 'force'"),
    "five names": (lambda a: a.update(joint_names=list("abcde")), "5 joint names, expected 6"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_arrays(case: str) -> None:
    change, says = BAD[case]
    given = arrays()
    change(given)
    with pytest.raises(pid.InputError, match=says) as error:
        Recording.from_arrays(**given)
    assert "\n" not in str(error.value)
    assert "--" not in str(error.value)  # Python's words, not the command line's


def test_frames_are_declared_by_names(tmp_path: Path) -> None:
    given = arrays()
    frame = pd.DataFrame({"t": given["time"], "note": "x"})
    for name, array in (("position", given["q"]), ("force", given["effort"])):
        for j, column in enumerate(array.T):
            frame[f"{name}_{j}"] = column
    recording = Recording.from_frame(frame, "time=t,q=position,tau=force")
    np.testing.assert_array_equal(recording.q, given["q"])
    assert recording.ignored == ("note",)
    third = Recording.from_frame(frame, "time=t,q=position[1:3],current=force[1:3]", drive_gains=[2.0, 3.0])
    np.testing.assert_array_equal(third.torque, given["effort"][:, 1:3] * [2.0, 3.0])
    for wrong in ([1, 2], "text", pd.DataFrame({"note": ["x"]}), pd.DataFrame()):
        with pytest.raises(pid.InputError, match="frame"):
            Recording.from_frame(wrong)


def test_one_recording_or_a_path_is_taken_wherever_a_list_is(ur5: pid.Robot, tmp_path: Path) -> None:
    runs = [record(arm(ur5), seed=seed) for seed in (1, 2)]
    paths = [tmp_path / f"{seed}.csv" for seed in (1, 2)]
    for run, path in zip(runs, paths, strict=True):
        run.to_pandas().to_csv(path, index=False)
    again = pid.load_recordings(str(tmp_path / "*.csv"))
    listed = pid.identify(ur5, [again[0]])
    for given in (again[0], str(paths[0]), paths[0], [paths[0]], (again[0],)):
        np.testing.assert_array_equal(pid.identify("ur5", given).theta, listed.theta)
    expected = pid.validate(listed, [again[1]]).rms
    for given in (again[1], str(paths[1]), [paths[1]]):
        np.testing.assert_array_equal(pid.validate(listed, given).rms, expected)
        np.testing.assert_array_equal(pid.compare(listed, listed, on=given).after.rms, expected)
    with pytest.raises(pid.InputError, match="expected each recording once"):
        pid.identify(ur5, [again[0], str(paths[0])])
    for wrong, says in ((5, "is 5"), ([5], "int"), ([again[0].q], "from_arrays"), (None, "is None")):
        with pytest.raises(pid.InputError, match=says):
            pid.identify(ur5, wrong)  # pyright: ignore[reportArgumentType]
    with pytest.raises(pid.InputError, match="not found"):
        pid.identify("ur5", "nothing.csv")


def test_paths_are_read_by_the_models_layout(ur5: pid.Robot, tmp_path: Path) -> None:
    runs = [record(arm(ur5), seed=seed) for seed in (1, 2)]
    for k, run in enumerate(runs):
        np.savetxt(tmp_path / f"{k}.txt", np.column_stack([run.q, run.effort]))
    estimate = pid.identify("ur5", tmp_path / "0.txt", columns="q=0:6,tau=6:12,rate=125")
    estimate.save(tmp_path / "model.json")
    score = pid.validate(pid.load_estimate(tmp_path / "model.json"), tmp_path / "1.txt")
    assert (score.relative < 15).all()


@pytest.mark.slow
def test_payload_diagnosis_and_session_take_one_recording(ur5: pid.Robot, tmp_path: Path) -> None:
    load = body(2.0, (0.0, 0.0, 0.05), (2e-3, 2e-3, 1e-3))
    estimate = pid.identify(ur5, [record(arm(ur5), seed=seed) for seed in (1, 2)])
    loaded = record(arm(ur5, load), seed=7, sensors=SENSORS)
    assert pid.identify_payload(estimate, loaded).mass == pytest.approx(2.0, rel=0.05)
    found = pid.diagnose(estimate, loaded)
    assert isinstance(found, pid.Diagnosis)
    assert found.findings[0].effect == "payload"
    pid.view(estimate, loaded, to=tmp_path / "session.rrd")
    (shown,) = pid.load_recordings(tmp_path / "session.rrd")
    assert shown.sha256 == loaded.sha256


@pytest.mark.parametrize("loggers", [2, 3])
def test_bursts_of_several_loggers_do_not_set_the_rate(ur5: pid.Robot, loggers: int) -> None:
    """Rows 10 microseconds apart, then a step of 8 ms: the samples are bounded by the rows, and the estimate holds."""
    time, q, v, a = pid.random_trajectory(ur5, seed=4, duration=20.0).sample(125.0 * loggers)
    model = arm(ur5)
    effort = model.torque(pid.Signals(time, q, v, a, rate=125.0 * loggers))
    clock = np.arange(0, time[-1], 0.008)[:, None] + 1e-5 * np.arange(loggers)
    instants = clock.ravel()
    at = {
        name: np.column_stack([np.interp(instants, time, column) for column in values.T])
        for name, values in (("q", q), ("dq", v), ("effort", effort))
    }
    bursty = pid.Recording.from_arrays(instants, at["q"], at["effort"], at["dq"])
    assert not bursty.rejected
    signals = pid.prepare(bursty, pid.Filter())
    assert len(signals.time) <= 1.1 * len(instants)
    assert (pid.identify(ur5, bursty, effects=[e.name for e in model.effects]).relative < 2).all()


def test_a_log_that_lost_rows_keeps_its_rate() -> None:
    rng = np.random.default_rng(0)
    values = table()
    kept = np.sort(rng.choice(len(values), len(values) // 2, replace=False))
    recording = pid.Recording.from_arrays(values[kept, 0], values[kept, 1:7], values[kept, 13:])
    assert pid.prepare(recording, pid.Filter()).rate in (50.0, 100.0)


NAMES = [b"r\xff.csv", "arm \u202e.csv".encode(), b"r\x1b[31mred.csv", "übung.csv".encode()]


@pytest.mark.parametrize("name", NAMES)
def test_names_of_files_are_printable(name: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Neither a byte that is not UTF-8 nor an escape sequence reaches a printed text or a saved model."""
    import os

    from physident.cli import run

    path = os.path.join(os.fsencode(tmp_path), name)
    with open(path, "w") as stream:
        stream.write(as_csv(table()))
    assert run(["inspect", os.fsdecode(path)]) == 0
    assert (
        run(["identify", os.fsdecode(path), "--robot", "ur5", "--method", "ols", "--out", str(tmp_path / "m.json")])
        == 0
    )
    shown = capsys.readouterr()
    assert all(sign.isprintable() or sign == "\n" for sign in shown.out + shown.err)
    source = pid.load_estimate(tmp_path / "m.json").sources[0].path
    assert source.isprintable()
    source.encode()  # is text


def test_the_page_on_recordings_runs() -> None:
    page = (ROOT / "docs" / "reference" / "recordings.md").read_text(encoding="utf-8")
    names: dict[str, Any] = {}
    for block in re.findall(r"```python\n(.*?)```", page, flags=re.S):
        exec(compile(block, "recordings.md", "exec"), names)
    assert names["named"].sha256 == names["again"].sha256 == names["recording"].sha256
