"""The command line: the two-command job, and what it writes."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from tests.conftest import UR10E_COLUMNS
from tests.test_identify import _recording


def _csv(recording: pid.Recording, path: Path) -> Path:
    names = ["time", *(f"{k}_{j}" for k in ("q", "dq", "tau") for j in range(1, recording.n + 1))]
    assert recording.dq is not None
    rows = np.column_stack([recording.time, recording.q, recording.dq, recording.effort])
    np.savetxt(path, rows, delimiter=",", header=",".join(names), comments="")
    return path


def test_identify_then_validate(ur5: pid.Robot, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    train, test = (_csv(_recording(ur5, seed, 0.2), tmp_path / f"{seed}.csv") for seed in (1, 2))
    model, score = tmp_path / "model.json", tmp_path / "score.json"
    assert run(["identify", str(train), "--robot", "ur5", "--out", str(model)]) == 0
    assert (
        run(["validate", "--model", str(model), str(test), "--json", str(score), "--plot", str(tmp_path / "p.png")])
        == 0
    )
    written = json.loads(score.read_text())
    direct = pid.validate(pid.load_estimate(model), pid.load_recordings(test))
    np.testing.assert_allclose(written["relative_percent"], direct.relative)
    assert written["joints"] == list(ur5.joint_names)
    assert written["cutoff"] == 5.0
    assert written["recordings"] == [str(test)]
    assert (tmp_path / "p.png").read_bytes().startswith(b"\x89PNG")
    capsys.readouterr()
    assert run(["validate", "--model", str(model), str(train)]) == 2
    out = capsys.readouterr()
    assert out.err.count("\n") == 1
    assert "is a training recording" in out.err
    assert out.out == ""
    assert run(["compare", "--model", str(model), "--model", str(model), "--on", str(test)]) == 0


def test_the_model_remembers_columns_and_gains(data: Path, tmp_path: Path) -> None:
    runs = [str(data / "ur10e" / f"ur-20_02_{name}.csv") for name in ("05-20sec_8harm", "06-20sec_5harm")]
    model = str(tmp_path / "m.json")
    arguments = ["identify", runs[0], "--robot", str(data / "ur10e/ur10e.urdf"), "--out", model]
    arguments += ["--columns", UR10E_COLUMNS, "--drive-gains", "14.87,13.26 11.13 10.62 11.03 11.47", "--cutoff", "4"]
    assert run(arguments) == 0
    assert run(["validate", "--model", model, runs[1]]) == 0
    kept = pid.load_estimate(model)
    assert kept.layout == UR10E_COLUMNS
    assert kept.drive_gains == (14.87, 13.26, 11.13, 10.62, 11.03, 11.47)
    assert kept.filter.cutoff == 4.0


def test_help_and_base_parameters(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--help"]) == 0
    assert "identify" in capsys.readouterr().out
    assert run(["base-parameters", "--robot", "ur5"]) == 0
    assert capsys.readouterr().out.startswith("36 base parameters of 60")


@pytest.mark.slow
def test_the_demo_names_what_it_hid_and_reveals_it(tmp_path: Path) -> None:
    from physident.demo.run import run_demo

    demo = run_demo(tmp_path, seed=3)
    assert demo.named
    (finding,), (hidden,) = demo.diagnosis.findings, demo.truth.values
    low, high = finding.parameters[0].interval95
    assert low <= finding.parameters[0].value <= high
    assert finding.parameters[0].change == pytest.approx(hidden[1], rel=0.1)
    assert all(path.is_file() for path in demo.files)
    assert "the truth, named above: torque_offset on joint 1" in repr(demo)
    assert f"--model {tmp_path / 'model.json'}" in (tmp_path / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("code", ["import physident", "import physident.cli"])
def test_import_stays_light(code: str) -> None:
    """Importing loads none of the heavy packages; a fresh interpreter says so."""
    heavy = ["casadi", "cvxpy", "rerun", "scipy.signal", "matplotlib", "pinocchio", "pyarrow", "pymoo"]
    check = f"{code}; import sys; print([m for m in {heavy} if m in sys.modules])"
    result = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


def test_diagnose_reads_files_without_header_by_the_model_s_layout(
    ur5: pid.Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def reached(*_: object) -> None:
        raise pid.InputError("the search began")

    monkeypatch.setattr("physident.diagnosis.searched.search_and_learn", reached)
    for seed in (1, 2):
        _csv(_recording(ur5, seed, 0.2), tmp_path / "named.csv")
        rows = (tmp_path / "named.csv").read_text().splitlines()[1:]
        (tmp_path / f"{seed}.csv").write_text("\n".join(rows) + "\n")
    layout, model = "time=0,q=1:7,dq=7:13,tau=13:19", str(tmp_path / "model.json")
    first, second = (str(tmp_path / f"{seed}.csv") for seed in (1, 2))
    assert run(["identify", first, "--robot", "ur5", "--columns", layout, "--out", model]) == 0
    assert run(["diagnose", "--model", model, second]) == 2
    assert "the search began" in capsys.readouterr().err
