"""One recording in every format is one recording; rows are numbered as the file's lines."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.recordings.formats.csv import write_csv
from physident.recordings.formats.read import read_table
from physident.recordings.formats.table import Table

NAMES = ("time", *(f"{kind}_{j}" for kind in ("q", "dq", "tau") for j in (1, 2)))


@pytest.fixture
def values() -> np.ndarray:
    rng = np.random.default_rng(0)
    time = np.linspace(0, 3, 301)
    return np.column_stack([time, np.sin(time), np.cos(time), np.cos(time), -np.sin(time), rng.normal(size=(301, 2))])


def text(values: np.ndarray) -> str:
    """Every number with all its digits."""
    return "\n".join([",".join(NAMES), *(",".join(map(repr, row)) for row in values.tolist())]) + "\n"


def test_the_hash_is_of_the_data_not_of_the_file(tmp_path: Path, values: np.ndarray) -> None:
    content = text(values).encode()
    (tmp_path / "a.csv").write_bytes(content)
    (tmp_path / "b.csv").write_bytes(content.replace(b"\n", b"\r\n"))
    (tmp_path / "bom.csv").write_bytes(b"\xef\xbb\xbf" + content)
    (tmp_path / "c.csv.gz").write_bytes(gzip.compress(content))
    np.savez(tmp_path / "d.npz", time=values[:, 0], q=values[:, 1:3], dq=values[:, 3:5], tau=values[:, 5:])
    np.savez_compressed(tmp_path / "e.npz", tau=values[:, 5:], dq=values[:, 3:5], q=values[:, 1:3], time=values[:, 0])
    recordings = pid.load_recordings(str(tmp_path / "*"))
    assert len(recordings) == 6
    assert len({recording.sha256 for recording in recordings}) == 1
    values[7, 1] = np.nextafter(values[7, 1], 1)
    (tmp_path / "a.csv").write_text(text(values))
    assert pid.load_recording(tmp_path / "a.csv").sha256 != recordings[0].sha256


def test_npz_keeps_every_bit(tmp_path: Path, values: np.ndarray) -> None:
    np.savez(tmp_path / "r.npz", time=values[:, 0], q=values[:, 1:3], dq=values[:, 3:5], tau=values[:, 5:], note=[1])
    recording = pid.load_recording(tmp_path / "r.npz")
    assert recording.dq is not None
    for kept, given in ((recording.time, values[:, 0]), (recording.q, values[:, 1:3]), (recording.dq, values[:, 3:5])):
        np.testing.assert_array_equal(kept, given)
    assert recording.ignored == ("note",)


def test_written_csv_reads_back(tmp_path: Path, values: np.ndarray) -> None:
    write_csv(tmp_path / "r.csv", Table(values, np.arange(len(values)), NAMES))
    table = read_table(tmp_path / "r.csv")
    assert table.names == NAMES
    np.testing.assert_allclose(table.values, values, rtol=1e-9)


@pytest.mark.parametrize("header", [True, False])
def test_row_numbers_are_line_numbers(tmp_path: Path, values: np.ndarray, header: bool) -> None:
    """Each kind of damage leaves the numbers of all other rows as they are."""
    lines = text(values).split("\n")[0 if header else 1 :]
    damage = {20: "", 31: '"0.3,1', 42: "1,2,3", 53: lines[53] + ",9", 64: "x,y", 75: lines[75].replace(",", ",é", 1)}
    for number, line in damage.items():
        lines[number - 1] = line
    lines[85] = lines[85].replace(",", ",\0", 1)
    (tmp_path / "r.csv").write_text("\n".join(lines), encoding="latin-1")
    columns = None if header else "time=0,q=1:3,dq=3:5,tau=5:7"
    recording = pid.load_recording(tmp_path / "r.csv", columns)
    assert [bad.row for bad in recording.rejected] == [*damage, 86]
    assert len(recording.time) == 301 - 7


def test_rows_keep_their_numbers_across_blocks(tmp_path: Path, values: np.ndarray, monkeypatch) -> None:
    lines = text(values).split("\n")
    lines[200 - 1], lines[33 - 1] = "1,2", "a," * 6 + "b"
    (tmp_path / "r.csv").write_text("\n".join(lines))
    whole = pid.load_recording(tmp_path / "r.csv")
    for block in (200, 997, 5000):
        monkeypatch.setattr("physident.recordings.formats.csv.BLOCK", block)
        parts = pid.load_recording(tmp_path / "r.csv")
        assert parts.rejected == whole.rejected
        assert parts.sha256 == whole.sha256
    assert [bad.row for bad in whole.rejected] == [33, 200]
