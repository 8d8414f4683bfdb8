"""The tutorials and how-to pages on real arms are played as they stand: every printed output is what the commands print."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import re
from pathlib import Path
from typing import Any

import pytest

import physident as pid
from tests.conftest import ROOT
from tests.test_tutorial import OPTIMA, close, compared, form, script

pytestmark = pytest.mark.slow

FOLDER = ROOT / "docs" / "tutorials"
OWN_TEST = ("first-diagnosis.md", "your-own-effect.md")  # pages that other tests play
PLAYED = {path: names for path, names in script().pages().items() if path.name not in OWN_TEST}


@pytest.fixture(scope="module")
def put() -> Any:
    """The function that writes a recording of a real arm into a folder."""
    spec = importlib.util.spec_from_file_location("tutorial_recordings", FOLDER / "recordings.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.put


@pytest.mark.parametrize("page", PLAYED, ids=lambda page: page.stem)
def test_every_printed_output_is_real(page: Path, put: Any, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    if PLAYED[page]:
        request.getfixturevalue("data")  # skips where there are no real recordings
    if page.stem.startswith("panda"):
        try:
            importlib.metadata.version("example-robot-data")
        except importlib.metadata.PackageNotFoundError:
            pytest.skip("the Panda's description is not installed (pip install example-robot-data)")
    for name in PLAYED[page]:
        put(name, tmp_path)
    text, played = page.read_text(encoding="utf-8"), script().played(page.read_text(encoding="utf-8"), tmp_path)
    if page.stem in OPTIMA:
        assert form(text) == form(played), f"run docs/tutorials/run.py {page.name}"
        check_claims(played)
        return
    (words, numbers), (now, real) = compared(text), compared(played)
    assert now == words, f"run docs/tutorials/run.py {page.name}"
    apart = [(a, b) for a, b in zip(numbers, real, strict=True) if not close(a, b)]
    assert not apart, f"{apart}: run docs/tutorials/run.py {page.name}"


def check_claims(played: str) -> None:
    """What the page on a designed motion says of any optimum: its limits hold, and it shows more than a random motion."""
    margins = [float(x) for x in re.findall(r"margin ([\d.e+-]+) [^\n]+$", played, flags=re.M)]
    assert len(margins) == 7
    assert min(margins) >= 0
    (factor,) = re.findall(r"smaller by a factor of ([\d.]+) \(", played)
    assert float(factor) > 1.5
    times = [float(x) for x in re.findall(r"^\w+ +(\d+) times less", played, flags=re.M)]
    assert len(times) == 2
    assert min(times) > 1


def test_logs_in_the_pages_are_what_a_controller_writes(put: Any, data: Path, tmp_path: Path) -> None:
    """The recording read by the controller's names is the one read by column numbers."""
    put("monday.csv", tmp_path)
    log = pid.load_recording(tmp_path / "monday.csv")
    source = pid.load_recording(data / "ur10e" / "ur-20_02_05-20sec_8harm.csv", "time=0,q=1:7,dq=7:13,current=13:19")
    assert log.effort_kind == "current"
    assert log.q.shape == source.q.shape
    assert abs(log.q - source.q).max() < 1e-6
    assert abs(log.effort - source.effort).max() < 1e-6
