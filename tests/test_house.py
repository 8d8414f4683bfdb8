"""The rules of the house, checked: imports point downward, the public surface is documented, README's code runs."""

from __future__ import annotations

import ast
import inspect
import os
import re
from pathlib import Path
from typing import Any

import pytest

import physident as pid
from tests.conftest import ROOT

# Floors of docs/explanation/architecture.md, lowest first: a module imports its own floor and those below.
FLOORS: tuple[tuple[str, ...], ...] = (
    ("errors", "files"),
    (
        "inertia",
        "dh",
        "dh_table",
        "urdf",
        "columns",
        "recording",
        "recording_checks",
        "formats",
        "robot",
        "vectorised",
        "rigid_body_regressor",
        "inverse_dynamics",
        "signals",
        "effects",
        "model",
    ),
    ("regressor",),
    ("manipulability", "base_parameters", "projection", "visibility", "identifiability", "estimation"),
    ("validation", "inspection", "excitation", "simulation", "payload", "diagnosis"),
    ("view", "report", "export", "fleet", "demo"),
    ("cli",),
)
LEVEL = {name: level for level, names in enumerate(FLOORS) for name in names}
PACKAGE = ROOT / "physident"


def _imports(tree: ast.AST) -> list[str]:
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("physident"):
            parts = node.module.split(".")
            found += [parts[1]] if len(parts) > 1 else [alias.name for alias in node.names]
        elif isinstance(node, ast.Import):
            found += [alias.name.split(".")[1] for alias in node.names if alias.name.startswith("physident.")]
    return found


@pytest.mark.parametrize("path", sorted(PACKAGE.rglob("*.py")), ids=lambda p: str(p.relative_to(PACKAGE)))
def test_imports_point_downward(path: Path) -> None:
    room = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
    if room == "__init__":
        return  # the public surface shows every floor
    assert room in LEVEL, f"{room} is on no floor: add it to FLOORS and to the architecture page"
    too_high = {name for name in _imports(ast.parse(path.read_text())) if LEVEL.get(name, 0) > LEVEL[room]}
    assert not too_high, f"{path.name} imports from floors above its own: {too_high}"


@pytest.mark.parametrize("name", [n for n in pid.__all__ if n not in ("__version__", "CATALOGUE")])
def test_public_names_are_documented(name: str) -> None:
    thing = getattr(pid, name)
    doc = inspect.getdoc(thing) or ""
    assert doc, f"{name} has no docstring"
    assert doc.split("\n\n")[0].rstrip().endswith((".", ":")), f"{name}: its first paragraph is not a sentence"
    if inspect.isclass(thing):
        for key, member in vars(thing).items():
            if key.startswith("_") or not (inspect.isfunction(member) or isinstance(member, property)):
                continue
            inherited = any(inspect.getdoc(getattr(base, key, None)) for base in thing.__mro__)
            assert inherited, f"{name}.{key} has no docstring"


@pytest.mark.parametrize(
    "name", ["identify", "validate", "compare", "load_robot", "load_recordings", "prepare", "build_regressor"]
)
def test_verbs_say_shape_or_unit_and_errors(name: str) -> None:
    doc = inspect.getdoc(getattr(pid, name)) or ""
    assert "InputError" in doc, f"{name}: says no error"


def test_readme_code_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Python blocks run one after another in a folder that holds what `physident demo` writes."""
    from physident.cli import run

    monkeypatch.chdir(tmp_path)
    assert run(["demo"]) == 0
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, flags=re.S)
    assert blocks
    exec(compile("\n".join(blocks), "README.md", "exec"), {"__name__": "readme"})


def test_readme_commands_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Lines that start with `physident` in README's shell blocks on demo recordings, run as typed."""
    import shlex

    from physident.cli import run

    monkeypatch.chdir(tmp_path)
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```(?:sh|bash)\n(.*?)```", text, flags=re.S)
    lines = [line for block in blocks for line in block.replace("\\\n", " ").splitlines()]
    commands = [shlex.split(line, comments=True) for line in lines if line.startswith("physident ")]
    assert len(commands) >= 3
    for command in commands:
        if any(word.startswith("runs/") for word in command):
            continue  # shown with the reader's own files
        assert run(command[1:]) == 0, command


def test_readme_tables_are_in_step() -> None:
    """The numbers in README are those of the studies' kept results."""
    module = _script("readme_tables")
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert module.filled(text) == text, "run docs/readme_tables.py"


def test_effects_page_is_in_step() -> None:
    module = _script("effects_page")
    assert module.PAGE.read_text(encoding="utf-8") == module.page(), "run docs/effects_page.py"


def _script(name: str) -> Any:
    """A script of docs/ as a module."""
    import importlib.util

    spec = importlib.util.spec_from_file_location(name, ROOT / "docs" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_text_speaks_of_the_project_alone() -> None:
    """No machine path and no registry host in the project's text."""
    needles = [os.sep + "work" + os.sep, os.sep + "root" + os.sep, "pypi" + ".org", "pythonhosted" + ".org"]
    for path in ROOT.rglob("*"):
        inside = path.relative_to(ROOT).parts
        if (
            not path.is_file()
            or inside[0] == "demo"
            or any(part.startswith(".") or part == "__pycache__" for part in inside[:-1])
        ):
            continue
        if path.suffix in (".py", ".md", ".toml", ".json", ".cff", ".urdf", ".pyi", "") and path.stat().st_size < 5e6:
            text = path.read_text(encoding="utf-8", errors="ignore")
            found = [needle for needle in needles if needle in text]
            assert not found, f"{path}: {found}"
