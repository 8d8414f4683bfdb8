"""The notebooks run as they stand, and keep what they print."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import ROOT
from tests.test_tutorial import OPTIMA, close, compared, form

pytestmark = pytest.mark.slow

FOLDER = ROOT / "docs" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
RUN = "run docs/notebooks/run.py"


def script() -> Any:
    """The script that executes notebooks, as a module."""
    spec = importlib.util.spec_from_file_location("notebooks", FOLDER / "run.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def shown(cell: Any) -> tuple[list[str], str]:
    """The kinds of a cell's outputs, and their text."""
    data = [output.get("data", {"text/plain": output.get("text", "")}) for output in cell.get("outputs", [])]
    return [kind for one in data for kind in sorted(one)], "\n".join(one.get("text/plain", "") for one in data)


def test_there_are_notebooks() -> None:
    assert len(NOTEBOOKS) == 3


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_and_prints_what_it_keeps(path: Path, tmp_path: Path) -> None:
    import nbformat

    kept = nbformat.read(path, as_version=4)
    now = script().executed(path, tmp_path)  # a cell that fails raises an error
    kinds = set()
    for old, new in zip(kept.cells, now.cells, strict=True):
        (was, before), (has, after) = shown(old), shown(new)
        assert was == has, RUN
        kinds.update(has)
        if path.stem in OPTIMA:
            assert form(before) == form(after), RUN
            continue
        (words, numbers), (words_now, numbers_now) = compared(before), compared(after)
        assert words == words_now, RUN
        apart = [(a, b) for a, b in zip(numbers, numbers_now, strict=True) if not close(a, b)]
        assert not apart, f"{apart}: {RUN}"
    assert {"text/html", "image/png"} <= kinds or path.stem.startswith("designing")


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_kept_executed_and_without_traces_of_a_machine(path: Path) -> None:
    import nbformat

    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1))
    assert all(output.get("name") != "stderr" for cell in code for output in cell.outputs)
    text = path.read_text(encoding="utf-8")
    assert "/tmp/" not in text
    assert "/home/" not in text
