"""What users see of a wrong set-up: warnings, files, verdicts, and parameters that recordings cannot size."""

from __future__ import annotations

import json
import warnings
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from scipy.signal import savgol_filter

import physident as pid
from physident.cli import run
from physident.estimation.sizing import UNSIZED
from tests.exact_friction import exact_arm
from tests.plant import Sensors, multisine, record

SWAPPED = [0, 2, 1, 3, 4, 5]


def _csv(recording: pid.Recording, path: Path) -> Path:
    names = ["time", *(f"{k}_{j}" for k in ("q", "tau") for j in range(1, recording.n + 1))]
    rows = np.column_stack([recording.time, recording.q, recording.effort])
    np.savetxt(path, rows, delimiter=",", header=",".join(names), comments="")
    return path


@pytest.fixture(scope="module")
def files(healthy_runs: list[pid.Recording], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder, one = tmp_path_factory.mktemp("setup"), healthy_runs[0]
    return {
        "healthy": _csv(one, folder / "healthy.csv"),
        "flipped": _csv(replace(one, effort=-one.effort), folder / "flipped.csv"),
        "swapped": _csv(replace(one, effort=one.effort[:, SWAPPED]), folder / "swapped.csv"),
    }


def test_inspect_names_the_mistake(files: dict[str, Path], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["inspect", str(files["swapped"]), "--robot", "ur5"]) == 0
    assert "wrong: the efforts of joints 2 and 3 are swapped" in capsys.readouterr().out
    assert run(["inspect", str(files["healthy"]), "--robot", "ur5"]) == 0
    assert "set-up, against the description of ur5: nothing wrong was seen" in capsys.readouterr().out
    assert run(["inspect", str(files["swapped"])]) == 0
    assert "--robot holds them against a description: nothing wrong was seen" in capsys.readouterr().out


def test_inspect_says_what_identify_refuses(
    files: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One channel in another unit, which the scale of all joints does not show."""
    head, *rows = files["healthy"].read_text().splitlines()
    at = head.split(",").index("tau_6")
    table = [row.split(",") for row in rows]
    wrong = [[*row[:at], str(1000 * float(row[at])), *row[at + 1 :]] for row in table]
    path = tmp_path / "milli.csv"
    path.write_text("\n".join([head, *map(",".join, wrong)]) + "\n")
    assert run(["identify", str(path), "--robot", "ur5", "--out", str(tmp_path / "m.json")]) == 2
    refused = capsys.readouterr().err
    assert "the torque of joint 6 reaches" in refused
    assert run(["inspect", str(path), "--robot", "ur5"]) == 0
    said = capsys.readouterr().out
    assert "wrong: " in said
    assert refused.split("physident: error: ")[1].strip() in said
    few = tmp_path / "few.csv"  # of another arm
    few.write_text("\n".join(["time,q_1,tau_1", *(f"{k / 100},{k / 1000},{k % 5}" for k in range(300))]) + "\n")
    assert run(["inspect", str(few), "--robot", "ur5"]) == 2
    assert "1 joints, but robot ur5 has 6" in capsys.readouterr().err


def test_identify_warns_and_keeps_the_warning(
    files: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "model.json"
    assert run(["identify", str(files["flipped"]), "--robot", "ur5", "--out", str(out)]) == 0
    said = capsys.readouterr()
    (line,) = [line for line in said.err.splitlines() if "warning" in line]
    assert line.startswith("physident: warning: the effort of all joints has the wrong sign")
    (kept,) = json.loads(out.read_text())["warnings"]
    assert kept in line
    assert f"set-up: {kept}" in said.out
    assert "verdict: the set-up is doubtful (see above); the model leaves" in said.out
    assert pid.load_estimate(out).warnings == (kept,)


def test_a_healthy_verdict_begins_with_the_error(healthy_estimate: pid.Estimate) -> None:
    text = repr(healthy_estimate)
    low, high = healthy_estimate.relative.min(), healthy_estimate.relative.max()
    assert low < 1 < high
    assert f"verdict: the model leaves {low:.2g} to {high:.0f} % of the torque; " in text
    assert healthy_estimate.warnings == ()
    assert healthy_estimate.unsized == ()


def test_a_poor_model_is_never_called_physical(healthy_estimate: pid.Estimate) -> None:
    poor = repr(replace(healthy_estimate, relative=np.array([61.0, 101.0, 70.0, 80.0, 20.0, 90.0])))
    assert "verdict: poor: the model leaves 20 to 101 % of the torque; " in poor
    assert "; physical:" not in poor
    one = repr(replace(healthy_estimate, relative=np.array([3.0, 4.0, 5.0, 3.0, 3.0, 47.0])))
    assert "verdict: poor on joint 6 (47 % left); elsewhere the model leaves 3 to 5 % of the torque; " in one


@pytest.mark.slow
def test_diagnose_keeps_its_warnings(
    healthy_estimate: pid.Estimate,
    healthy_runs: list[pid.Recording],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(
        "physident.diagnosis.search.forward_search.HANDFUL", 1
    )  # what is found beside it does not matter
    wrong = [replace(run, effort=run.effort[:, SWAPPED]) for run in healthy_runs[2:3]]
    with pytest.warns(pid.PhysidentWarning, match="joints 2 and 3 are swapped"):
        found = pid.diagnose(healthy_estimate, wrong)
    assert isinstance(found, pid.Diagnosis)
    found.save(tmp_path / "diagnosis.json")
    (kept,) = json.loads((tmp_path / "diagnosis.json").read_text())["warnings"]
    assert "joints 2 and 3 are swapped" in kept


def test_a_score_of_swapped_joints_warns_once(
    healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording]
) -> None:
    swapped = replace(healthy_runs[3], effort=healthy_runs[3].effort[:, SWAPPED])
    with pytest.warns(pid.PhysidentWarning, match="joints 2 and 3 are swapped"):
        pid.validate(healthy_estimate, swapped)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        pid.compare(healthy_estimate, healthy_estimate, swapped)
    assert sum("joints 2 and 3 are swapped" in str(one.message) for one in said) == 1


def test_a_joint_that_stands_still_is_no_other_kind_of_effort(
    healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording]
) -> None:
    """Its torque holds no friction, because it does not move."""
    run, still = healthy_runs[3], np.array([0, 1])
    assert run.dq is not None
    q, dq, effort = run.q.copy(), run.dq.copy(), run.effort.copy()
    q[:, still], dq[:, still] = q[0, still], 0.0
    signals = pid.prepare(replace(run, q=q, dq=dq), healthy_estimate.filter)
    model = healthy_estimate.model
    names = [column.name for column in model.columns]
    theta = np.where([("friction" in name) and name[-1] in "12" for name in names], 0.0, model.theta)
    quiet = pid.Model(model.robot, model.effects, theta)
    torque = quiet.measured_torque(quiet.refer(signals))
    effort = np.column_stack([np.interp(run.time - run.time[0], signals.time - signals.origin, x) for x in torque.T])
    noise = 0.05 * np.random.default_rng(0).standard_normal(effort.shape)
    standing = replace(run, q=q, dq=dq, effort=effort + noise)
    assert not [one for one in pid.check_setup(model.robot, standing) if one.kind == "mixture"]


def test_parameters_that_recordings_cannot_size_are_printed_as_such(ur5: pid.Robot, tmp_path: Path) -> None:
    """Two columns that are almost one: their difference is of any size, and each alone means nothing."""
    record(exact_arm(), multisine(31), Sensors(), 31, step=4e-3).write_csv(tmp_path / "run.csv")
    one = pid.load_recording(tmp_path / "run.csv")
    estimate = pid.identify(ur5, [one])
    column = [c.name for c in estimate.model.columns].index("rotor_inertia_4")
    theta = np.array(estimate.theta)
    rows = pid.build_regressor(ur5, estimate.model.effects, [pid.prepare(one, estimate.filter)], estimate.filter)
    torque = float(np.linalg.norm(rows.torque[:, 3]))
    size = float(np.linalg.norm(rows.Y[:, 3, column]))
    from physident.estimation.sizing import unsized_parameters

    for factor, named in ((0.9, ()), (1.1, ("rotor_inertia_4",))):
        theta[column] = factor * UNSIZED * torque / size
        assert unsized_parameters(rows, estimate.base, theta) == named
    shown = repr(replace(estimate, unsized=("rotor_inertia_4",)))
    assert "not sized by these data" in shown
    (row,) = [line for line in shown.splitlines() if line.startswith("    4") and "not sized" in line]
    assert len(row) <= 100


def _loaded(robot: pid.Robot, run: pid.Recording, centre: list[float]) -> pid.Recording:
    """The recording with the torque of 3 kg on the last link added, by pinocchio along the smoothed motion."""
    step = float(np.median(np.diff(run.time)))
    motion = [np.asarray(savgol_filter(run.q, 41, 5, deriv=k, delta=step, axis=0)) for k in range(3)]
    model = robot.pinocchio.copy()
    model.inertias[6] = model.inertias[6] + pin.Inertia(3.0, np.array(centre), 0.01 * np.eye(3))
    with_load, bare = model.createData(), robot.pinocchio.createData()
    more = [
        pin.rnea(model, with_load, *row) - pin.rnea(robot.pinocchio, bare, *row) for row in zip(*motion, strict=True)
    ]
    return replace(run, effort=run.effort + np.array(more))


def test_a_load_that_contradicts_itself_is_doubtful(
    ur5: pid.Robot, healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording]
) -> None:
    """Two recordings with the load on opposite sides are no single load; with the load on one side they are."""
    one, other = ([0.1, 0.0, 0.05], [-0.1, 0.0, 0.05])
    same = pid.identify_payload(healthy_estimate, [_loaded(ur5, run, one) for run in healthy_runs[2:]])
    assert same.contradictions == ()
    assert same.as_dict()["warnings"] == []
    assert "[" in repr(same)
    pair = zip(healthy_runs[2:], (one, other), strict=True)
    averaged = pid.identify_payload(healthy_estimate, [_loaded(ur5, run, centre) for run, centre in pair])
    assert any("times that of the arm's model" in text for text in averaged.contradictions)
    assert averaged.as_dict()["mass_interval_kg"] is None
    shown = repr(averaged)
    assert "intervals withheld" in shown
    assert "verdict: doubtful: a load of" in shown
    assert "[" not in shown.replace("[N m]", "").replace("[kg]", "")


def test_joints_that_disagree_about_the_mass_are_reported(
    ur5: pid.Robot, healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording]
) -> None:
    """A drive gain of joint 2 that is 30 % too high shows in what joint 2 alone says of the load."""
    scale = np.array([1.0, 1.3, 1.0, 1.0, 1.0, 1.0])
    runs = [replace(run, effort=run.effort * scale) for run in healthy_runs]
    arm = pid.identify(ur5, runs[:2])
    loaded = [_loaded(ur5, run, [0.0, 0.0, 0.1]) for run in healthy_runs[2:]]
    found = pid.identify_payload(arm, [replace(run, effort=run.effort * scale) for run in loaded])
    assert any("joints disagree about the mass" in text for text in found.contradictions)


def test_every_function_of_recordings_says_that_velocities_contradict_positions(
    ur5: pid.Robot, healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording]
) -> None:
    def in_degrees(run: pid.Recording) -> pid.Recording:
        assert run.dq is not None
        return replace(run, dq=np.degrees(run.dq))

    fitted, unseen = in_degrees(healthy_runs[0]), in_degrees(healthy_runs[2])
    loaded = in_degrees(_loaded(ur5, healthy_runs[3], [0.0, 0.0, 0.1]))
    amperes = [replace(run, effort_kind="current") for run in (fitted, loaded)]
    for call in (
        lambda: pid.identify(ur5, fitted),
        lambda: pid.validate(healthy_estimate, unseen),
        lambda: healthy_estimate.predict(unseen),
        lambda: pid.compare(healthy_estimate, healthy_estimate, on=unseen),
        lambda: pid.identify_payload(healthy_estimate, loaded),
        lambda: pid.identify_drive_gains(ur5, amperes[0], amperes[1], 3.0),
    ):
        with (
            pytest.warns(pid.PhysidentWarning, match="velocity of all joints is in degrees per second"),
            suppress(pid.PhysidentError),  # gains of so short a recording may not be separable
        ):
            call()
