"""Good files with random damage load, or say why not in one line."""

from __future__ import annotations

import contextlib
import gzip
import itertools
import json
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from tests.bad_input.good import GOOD, npz
from tests.bad_input.nested import leaves, replaced


def damaged(content: bytes, rng: np.random.Generator) -> bytes:
    """The content with a stretch of it overwritten, cut out, doubled or cut off."""
    a, b = np.sort(rng.integers(0, len(content), 2))
    b = min(b, a + int(rng.integers(1, 40)))
    kind = rng.integers(4)
    middle = (rng.bytes(b - a), b"", 2 * content[a:b], b"")[kind]
    return content[:a] + middle + (b"" if kind == 3 else content[b:])


@pytest.mark.filterwarnings("ignore::physident.PhysidentWarning", "error::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("name", ["good.csv", "good.csv.gz", "good.npz", "arm.urdf", "arm.toml", "small.json"])
def test_damaged_files_load_or_say_why(name: str, folder: Path) -> None:
    (folder / "good.csv.gz").write_bytes(gzip.compress(GOOD.encode()))
    npz()(folder / "good.npz")
    rng = np.random.default_rng(0)
    content = (folder / name).read_bytes()
    load = {".urdf": pid.load_robot, ".toml": pid.load_robot, ".json": pid.load_estimate}.get(
        Path(name).suffix, pid.load_recording
    )
    refused = []
    for _ in range(60):
        (folder / name).write_bytes(damaged(content, rng))
        try:
            load(folder / name)
        except pid.InputError as error:
            refused.append(str(error))
    assert refused
    assert all(len(line.splitlines()) == 1 for line in refused)


@pytest.mark.parametrize("method", ["ols", "physical"])
def test_a_model_with_any_entry_replaced_loads_or_says_why(method: str, folder: Path) -> None:
    if method == "physical":
        fit = ["identify", "good.csv", "--robot", "arm.toml", "--method", "physical", "--effects", "rigid_body"]
        assert run([*fit, "--columns", "time=0,q=1:3,dq=7:9,tau=13:15", "--out", "small.json"]) == 0
    model = json.loads((folder / "small.json").read_text())
    values = itertools.cycle((None, [], {}, "x", -1, 1e308, [[1]]))  # seven: prime to most steps of the walk
    for path, value in itertools.chain(
        zip(leaves(model), values, strict=False), zip(leaves(model), values, strict=False)
    ):
        (folder / "bad.json").write_text(json.dumps(replaced(model, path, value)))
        with contextlib.suppress(pid.InputError):
            repr(pid.load_estimate(folder / "bad.json"))
