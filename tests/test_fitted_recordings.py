"""The recordings that a model was fitted to are at hand for what asks for them: in the same program, and from the model's file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.estimation.results.fitted import fitted_recordings
from physident.recordings.columns.reading import Reading
from tests.plant import Arm, Sensors, multisine, record

pytestmark = pytest.mark.slow

COLUMNS = "time=0,q=1:7,dq=7:13,tau=13:19"


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file without a header, which says nothing of its columns."""
    folder = tmp_path_factory.mktemp("bare")
    record(Arm(), multisine(1, duration=10.0), Sensors(), 1, step=2e-3).write_csv(folder / "named.csv")
    rows = (folder / "named.csv").read_text(encoding="utf-8").splitlines()
    path = folder / "bare.csv"
    path.write_text("\n".join(row for row in rows if row[0] in "-0123456789"), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def run(bare: Path) -> pid.Recording:
    return pid.load_recording(bare, COLUMNS)


def found(estimate: pid.Estimate) -> list[str]:
    return [recording.sha256 for recording in fitted_recordings(estimate)]


def saved(estimate: pid.Estimate, folder: Path) -> pid.Estimate:
    estimate.save(folder / "model.json")
    return pid.load_estimate(folder / "model.json")


def test_a_file_is_read_again_as_it_was_read(ur5: pid.Robot, run: pid.Recording, tmp_path: Path) -> None:
    """Whether the columns were declared to ``load_recording`` or to ``identify``."""
    fitted = saved(pid.identify(ur5, run), tmp_path)
    assert found(fitted) == [run.sha256]
    assert found(saved(pid.identify(ur5, run.source, columns=COLUMNS), tmp_path)) == [run.sha256]


def test_arrays_are_at_hand_in_the_program_that_fitted_them(ur5: pid.Robot, run: pid.Recording, tmp_path: Path) -> None:
    arrays = pid.Recording.from_arrays(run.time, run.q, run.effort, run.dq)
    estimate = pid.identify(ur5, arrays)
    assert found(estimate) == [run.sha256]
    assert found(estimate.with_cutoff(5.0)) == [run.sha256]
    assert found(saved(estimate, tmp_path)) == []


def test_a_change_is_held_against_arrays(ur5: pid.Robot, run: pid.Recording) -> None:
    def arrays(recording: pid.Recording, shift: float = 0.0) -> pid.Recording:
        return pid.Recording.from_arrays(recording.time, recording.q, recording.effort + shift, recording.dq)

    estimate = pid.identify(ur5, arrays(run))
    assert pid.diagnose_motion(estimate, arrays(run, 1e-3)).controlled is True
    with pytest.warns(
        pid.PhysidentWarning, match="arrays: the model was fitted to it, but no such recording is at hand"
    ):
        alone = pid.diagnose_motion(replace(estimate, fitted=()), arrays(run, 1e-3))
    assert alone.controlled is False
    assert any("arrays: the model was fitted to it" in text for text in alone.warnings)


def test_a_file_that_has_changed_is_not_at_hand(ur5: pid.Robot, bare: Path, tmp_path: Path) -> None:
    path = tmp_path / "copy.csv"
    path.write_text(bare.read_text(encoding="utf-8"), encoding="utf-8")
    estimate = saved(pid.identify(ur5, path, columns=COLUMNS), tmp_path)
    path.write_text("\n".join(bare.read_text(encoding="utf-8").splitlines()[:-5]), encoding="utf-8")
    assert found(estimate) == []


@pytest.mark.parametrize("moved", [False, True])
def test_files_are_found_from_another_folder(
    ur5: pid.Robot, bare: Path, run: pid.Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moved: bool
) -> None:
    """A model file and its recordings stay together, whatever the folder that a program starts in or that they are moved to."""
    here, there = tmp_path / "here", tmp_path / "there"
    (here / "data").mkdir(parents=True)
    there.mkdir()
    (here / "data" / "run.csv").write_bytes(bare.read_bytes())
    monkeypatch.chdir(here)
    pid.identify(ur5, "data/run.csv", columns=COLUMNS).save(here / "model.json")
    if moved:
        (here / "data" / "run.csv").rename(there / "run.csv")
        (here / "model.json").rename(there / "model.json")
    monkeypatch.chdir(tmp_path)
    (again,) = fitted_recordings(pid.load_estimate((there if moved else here) / "model.json"))
    assert (again.sha256, again.source) == (run.sha256, "data/run.csv")


@pytest.mark.parametrize(
    "text", [COLUMNS, "topic=/joint_states", "q=0:6,tau=6:12,rate=125", "topic=/a,rate=500,joints=a b c"]
)
def test_how_a_file_was_read_is_one_text(text: str) -> None:
    assert Reading.parse(text).text == text


def test_files_of_unlike_columns_share_no_layout(ur5: pid.Robot, run: pid.Recording) -> None:
    other = replace(run, time=run.time + 1.0, effort=run.effort * np.float64(1.001), layout=None)
    assert pid.identify(ur5, [run, other]).layout is None
    assert pid.identify(ur5, [run, other], columns=COLUMNS).layout == COLUMNS
