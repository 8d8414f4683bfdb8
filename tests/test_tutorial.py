"""The tutorials are played as they stand: every printed output in them is what the commands print."""

from __future__ import annotations

import importlib.util
import json
import re
from pathlib import Path
from typing import Any

import pytest

import physident as pid
from tests.conftest import ROOT

pytestmark = pytest.mark.slow

PAGE = ROOT / "docs" / "tutorials" / "first-diagnosis.md"
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
# lines whose numbers and order rounding decides, and one that a busy machine prints
BY_ROUNDING = ("largest remaining gradient", "vague (", "physident: searching, ")
OPTIMA = (
    "designing-a-motion",
)  # pages whose searches end in another optimum of the same kind on another kind of processor
TRUE = 0.08  # what the page hides on joint 2


def script() -> Any:
    """The script that plays tutorials, as a module."""
    spec = importlib.util.spec_from_file_location("tutorials", ROOT / "docs" / "tutorials" / "run.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder in which the tutorial was played, with the page as it then is."""
    folder = tmp_path_factory.mktemp("tutorial")
    page = script().played(PAGE.read_text(encoding="utf-8"), folder)
    (folder / "page.md").write_text(page, encoding="utf-8")
    return folder


def compared(page: str) -> tuple[list[str], list[str]]:
    """The page without its numbers, line by line, and the numbers."""
    lines = [line for line in page.splitlines() if not line.startswith(BY_ROUNDING)]
    text = "\n".join(lines)
    return [" ".join(NUMBER.sub("#", line).split()) for line in lines], NUMBER.findall(text)


def form(page: str) -> list[str]:
    """What stays of a page where the optimum of a search is another one: the first word of each line, without its number."""
    return [NUMBER.sub("#", line).split()[0] for line in page.splitlines() if line.strip()]


def close(a: str, b: str) -> bool:
    """Whether two printed numbers agree to 1 % or to one in their last place."""
    places = min(len(x.partition(".")[2]) for x in (a, b))
    return abs(float(a) - float(b)) <= max(0.01 * abs(float(a)), 1.01 * 10.0**-places)


def test_every_printed_output_is_real(folder: Path) -> None:
    (words, numbers), (now, real) = (compared(page.read_text(encoding="utf-8")) for page in (PAGE, folder / "page.md"))
    assert now == words, "run docs/tutorials/run.py"
    apart = [(a, b) for a, b in zip(numbers, real, strict=True) if not close(a, b)]
    assert not apart, f"{apart}: run docs/tutorials/run.py"


def test_the_cause_that_the_page_hides_is_found_with_its_value(folder: Path) -> None:
    found = json.loads((folder / "diagnosis.json").read_text())
    (finding,) = found["findings"]
    assert (finding["effect"], finding["joints"]) == ("load_dependent_friction", [2])
    low, high = finding["parameters"][0]["interval95"]
    assert low < TRUE < high
    before, after = (pid.load_estimate(folder / f"{name}.json") for name in ("model", "extended"))
    gain = pid.compare(before, after, on=pid.load_recordings(folder / "tuesday.csv"))
    assert gain.reduction[1] > 50


def test_every_file_that_the_page_names_is_there(folder: Path) -> None:
    page = PAGE.read_text(encoding="utf-8")
    names = set(re.findall(r"(?<![\w.])[\w-]+\.(?:csv|json|png|rrd|html)\b", page))
    assert {"session.rrd", "report.html", "residual.png", "extended.json"} <= names
    missing = [name for name in names if not (folder / name).stat().st_size]
    assert not missing
    links = re.findall(r"\]\(([^)#]+)", page)
    assert links
    assert all((PAGE.parent / link).resolve().exists() for link in links)
