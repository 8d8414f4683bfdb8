"""A recording that is worked on in files, blocks and two processes gives the same model and score as one in memory."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import physident as pid
from physident import large_arrays
from physident.large_arrays import LARGE
from physident.processes import VARIABLE
from physident.recordings.inspection import inspect_recording
from physident.recordings.load import load_recording
from tests.plant import Arm, Sensors, multisine, record

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Two recordings of another program's arm, one as CSV and one as Parquet, with bad rows and a gap."""
    folder = tmp_path_factory.mktemp("long")
    found = []
    for seed in (1, 2):
        made = record(Arm(), multisine(seed=seed), Sensors(), seed=seed, step=2e-3)
        table = {name: np.array(values) for name, values in made.table().items()}
        table["q_2"][100:103] = np.nan
        table["time"][700] = table["time"][699]
        kept = np.r_[0:1200, 1290 : len(table["time"])]
        table = {name: values[kept] for name, values in table.items()}
        path = folder / f"{seed}.{'csv' if seed == 1 else 'parquet'}"
        if seed == 1:
            np.savetxt(path, np.column_stack(list(table.values())), "%.17g", ",", header=",".join(table), comments="")
        else:
            pq.write_table(pa.table(table), path, row_group_size=500)
        found.append(path)
    return found


@pytest.fixture
def pieces(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> Iterator[None]:
    """Everything in files, in blocks of some rows, smoothed in pieces, by some processes."""
    block, processes = request.param
    monkeypatch.setenv(VARIABLE, str(processes))
    monkeypatch.setattr(large_arrays, "BLOCK", block)
    monkeypatch.setattr("physident.recordings.motion_smoothing.PIECE", 3 * block)
    monkeypatch.setattr("physident.recordings.formats.parquet.BATCH", block)
    token = LARGE.set(1000)
    yield
    LARGE.reset(token)


def weighed(estimate: pid.Estimate, file: Path) -> list[float]:
    """What a load's recording says of mass and gains, without the program that finds the rigid body."""
    found = pid.identify_payload(estimate, file)
    change, day = found.gain_change, found.friction_of_the_day
    return [change.change, change.error, day.mass, *day.mass_interval, *day.sigma, *found.sigma_without_load]


@pytest.fixture(scope="module")
def in_memory(files: list[Path]) -> tuple[pid.Estimate, pid.Score, str]:
    """The model of the first recording, its score on the second, and what inspection says of the first."""
    estimate = pid.identify("ur5", files[0])
    return estimate, pid.validate(estimate, files[1]), repr(inspect_recording(load_recording(files[0])))


@pytest.fixture(scope="module")
def weighed_in_memory(files: list[Path], in_memory: tuple[pid.Estimate, pid.Score, str]) -> list[float]:
    return weighed(in_memory[0], files[1])


@pytest.mark.parametrize("pieces", [(311, 1)], indirect=True)
def test_pieces_weigh_the_same_load(
    pieces: None, files: list[Path], in_memory: tuple[pid.Estimate, pid.Score, str], weighed_in_memory: list[float],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    for module in ("friction_of_the_day", "gain_change"):
        monkeypatch.setattr(f"physident.estimation.payload.{module}.INSTANTS", 97)
    np.testing.assert_allclose(weighed(in_memory[0], files[1]), weighed_in_memory, rtol=1e-8)


@pytest.mark.parametrize("pieces", [(311, 1), (1000, 2), (4096, 1)], indirect=True)
def test_pieces_give_the_same_model_and_score(
    pieces: None, files: list[Path], in_memory: tuple[pid.Estimate, pid.Score, str]
) -> None:
    expected, score, inspected = in_memory
    estimate = pid.identify("ur5", files[0])
    size = np.abs(expected.theta).max()
    np.testing.assert_allclose(estimate.theta, expected.theta, atol=1e-9 * size)
    np.testing.assert_allclose(estimate.covariance, expected.covariance, atol=1e-9 * np.abs(expected.covariance).max())
    assert [s.sha256 for s in estimate.sources] == [s.sha256 for s in expected.sources]
    found = pid.validate(expected, files[1])
    for name in ("rms", "relative", "relative_all", "rest_outside", "moving_share"):
        np.testing.assert_allclose(getattr(found, name), getattr(score, name), rtol=1e-9, atol=1e-9)
    assert repr(inspect_recording(load_recording(files[0]))) == inspected
