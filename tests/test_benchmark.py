"""The benchmark's score: a prediction that is the measurement has no error, none at all has 100 %, and its files are complete."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import physident as pid
from tests.conftest import ROOT

FOLDER = ROOT / "studies" / "benchmark"


@pytest.fixture(scope="module")
def study() -> Any:
    """The study's script as a module, which finds its tasks beside it."""
    sys.path.insert(0, str(FOLDER))
    try:
        spec = importlib.util.spec_from_file_location("benchmark_run", FOLDER / "run.py")
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module
    finally:
        sys.path.remove(str(FOLDER))
        sys.modules.pop("tasks", None)


@pytest.fixture(scope="module")
def task(study: Any, ur5: pid.Robot, healthy_runs: list[pid.Recording]) -> Any:
    return study.Task(name="made_one", robot=ur5, train=healthy_runs[:1], test=healthy_runs[2], cutoff=5.0)


def test_the_score_is_that_of_the_filtered_torque(study: Any, task: Any) -> None:
    run = task.test
    perfect = study.score(task, run.time, run.torque)
    assert max(perfect["relative_percent"]) < 0.5  # the clock is resampled
    nothing = study.score(task, run.time, np.zeros_like(run.torque))
    np.testing.assert_allclose(nothing["relative_percent"], 100.0, rtol=1e-9)
    tenth = study.score(task, run.time, 0.9 * run.torque)
    np.testing.assert_allclose(tenth["relative_percent"], 10.0, atol=0.5)


def test_an_entry_scores_as_the_model_that_wrote_it(study: Any, task: Any, tmp_path: Path) -> None:
    """Through the files of a task and back: what another program sees is enough to reach the same score."""
    study.write_task(task, tmp_path)
    assert not [name for name in (tmp_path / "test.csv").read_text().splitlines()[0].split(",") if "tau" in name]
    model = pid.identify(tmp_path / "robot.urdf", tmp_path / "train_1.csv").model
    run = pid.Recording.from_arrays(task.test.time, task.test.q, np.zeros_like(task.test.q), task.test.dq)
    signals = pid.prepare(run, pid.Filter(5.0))
    rows = np.column_stack([signals.time, model.torque(signals)])
    np.savetxt(tmp_path / "made_one.csv", rows, delimiter=",", header="time,tau", comments="")
    entry = study.score(task, *study.read_entry(tmp_path / "made_one.csv", task))
    own = study.score(task, *study.predicted(task, "wls"))
    np.testing.assert_allclose(entry["relative_percent"], own["relative_percent"], rtol=0.02)
    assert max(entry["relative_percent"]) < 40


def test_an_entry_that_does_not_fit_ends_with_one_line(study: Any, task: Any, tmp_path: Path) -> None:
    path = tmp_path / "bad.csv"
    for text, said in (("time,tau\n0,1\n", "2 columns"), ("", "bad.csv"), ("t\nx\n", "bad.csv")):
        path.write_text(text)
        with pytest.raises(SystemExit, match=said):
            study.read_entry(path, task)
    with pytest.raises(SystemExit, match="expected"):
        study.score(task, np.array([0.0, 1.0]), np.zeros((2, 6)))


def test_results_hold_every_task_of_every_entry() -> None:
    entries = json.loads((FOLDER / "results.json").read_text(encoding="utf-8"))["entries"]
    names = {frozenset(of) for of in entries.values()}
    assert len(names) == 1
    assert len(next(iter(names))) == 12
