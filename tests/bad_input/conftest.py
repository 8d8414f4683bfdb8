"""Good files in a fresh folder."""

from __future__ import annotations

from pathlib import Path

import pytest

from physident.cli import run
from tests.bad_input.good import TABLE, URDF, as_csv, table


@pytest.fixture(scope="session")
def bench(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Good files, so that each case breaks one thing: two recordings, a URDF, a DH table, a model."""
    folder = tmp_path_factory.mktemp("bench")
    values = table()
    (folder / "good.csv").write_text(as_csv(values))
    values[:, 7:] *= 1.01
    (folder / "other.csv").write_text(as_csv(values))
    (folder / "arm.urdf").write_text(URDF)
    (folder / "arm.toml").write_text(TABLE)
    fit = ["identify", str(folder / "good.csv"), "--robot", "ur5", "--method", "ols"]
    assert run([*fit, "--out", str(folder / "model.json")]) == 0
    fit = ["identify", str(folder / "good.csv"), "--robot", str(folder / "arm.toml"), "--method", "ols"]
    assert run([*fit, "--columns", "time=0,q=1:3,dq=7:9,tau=13:15", "--out", str(folder / "small.json")]) == 0
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture
def folder(bench: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A fresh working folder that holds the good files."""
    for name, content in bench.items():
        (tmp_path / name).write_bytes(content)
    monkeypatch.chdir(tmp_path)
    return tmp_path
