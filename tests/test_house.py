"""Rules for the code base: imports point downward, files stay small, public names are documented, README's code runs."""

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

# The floors of docs/explanation/architecture.md, lowest first. A module is on the floor with the longest prefix of its
# name, and may import from its floor and the floors below.
FLOORS = (
    "errors",
    "arguments",
    "threads",
    "large_arrays",
    "processes",
    "outputs",
    "files",
    "json_records",
    "notebook",
    "robots",
    "recordings",
    "dynamics.vectorised",
    "dynamics.rigid_body_regressor",
    "dynamics.inverse_dynamics",
    "dynamics.dry_sign",
    "effects",
    "dynamics",
    "identifiability",
    "testing",
    "setup_checks",
    "estimation",
    "validation",
    "excitation",
    "simulation",
    "diagnosis",
    "graphics",
    "report",
    "export",
    "replay",
    "fleet",
    "demo",
    "cli",
)
PACKAGE = ROOT / "physident"
MOST_MODULES = 13  # of a folder: about a dozen
MOST_LINES = 300  # of a file
# Where effects may be named in the code outside effects/: all other modules read what they need from the effect's class.
NAMED_EFFECTS = {
    "physident.graphics.style": "any",  # one colour for each
    "physident.report.sections.practice": "any",  # one sentence for each
    "physident.demo.arms": "any",  # the effects that the demo hides
    "physident.fleet.candidates": "any",  # what wears, loosens or is forgotten
    "physident.excitation.limits.torque_limit": ("torque_offset",),  # it is measured, and loads no drive
    "physident.report.sections.advice": ("joint_zero_offset",),  # no motion shows it about a vertical axis
    "physident.export.urdf": ("rigid_body",),  # what URDF has elements for
}
NAMED_ANYWHERE = ("rigid_body", "contact", "payload", "torque_constant")


def _name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {_name(path): path for path in sorted(PACKAGE.rglob("*.py"))}


def _imports(name: str) -> set[str]:
    """The modules of the package that a module imports: at its top, in functions, for type checking only, and through the
    ``__init__`` of every package on the path that it is not part of."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(MODULES[name].read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name}: relative import"
            base = node.module or ""
            found |= {f"{base}.{a.name}" if f"{base}.{a.name}" in MODULES else base for a in node.names}
        elif isinstance(node, ast.Import):
            found |= {a.name for a in node.names}
    parts = [path.split(".") for path in found]
    with_parents = {".".join(path[:k]) for path in parts for k in range(2, len(path) + 1)}
    return {module for module in with_parents if module in MODULES and not f"{name}.".startswith(f"{module}.")}


def _floor(name: str) -> int:
    short = name.removeprefix("physident.")
    fits = [prefix for prefix in FLOORS if f"{short}.".startswith(f"{prefix}.")]
    assert fits, f"{name} has no floor: add it to FLOORS and to docs/explanation/architecture.md"
    return FLOORS.index(max(fits, key=len))


@pytest.mark.parametrize("name", [name for name in MODULES if name != "physident"])
def test_imports_point_downward(name: str) -> None:
    imported = {module for module in _imports(name) if MODULES[module].name != "__init__.py"}
    too_high = {module for module in imported if _floor(module) > _floor(name)}
    assert not too_high, f"{name} imports from floors above its own: {too_high}"


def test_no_module_imports_itself_through_others() -> None:
    """No circle of any kind: modules are removed while they import no module that remains, or no module imports them."""
    remaining = {name: _imports(name) for name in MODULES}
    size = -1
    while size != len(remaining):
        size = len(remaining)
        imported = set().union(*remaining.values()) if remaining else set()
        remaining = {name: imports & set(remaining) for name, imports in remaining.items() if name in imported}
        remaining = {name: imports for name, imports in remaining.items() if imports}
    assert not remaining, f"circles among {sorted(remaining)}"


def test_effects_are_named_only_where_their_physics_matters() -> None:
    """No module lists effects by name: a new effect then needs no line there."""
    for name, path in MODULES.items():
        if name.startswith("physident.effects"):
            continue
        allowed = NAMED_EFFECTS.get(name, ())
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value in pid.CATALOGUE:
                assert allowed == "any" or node.value in (*allowed, *NAMED_ANYWHERE), f"{name} names {node.value!r}"


def test_files_and_folders_stay_small() -> None:
    for name, path in MODULES.items():
        lines = path.read_text(encoding="utf-8").count("\n")
        assert lines <= MOST_LINES, f"{name} has {lines} lines"
    for folder in {path.parent for path in MODULES.values()}:
        count = len([path for path in folder.glob("*.py") if path.name != "__init__.py"])
        assert count <= MOST_MODULES, f"{folder} has {count} modules"


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
    assert "InputError" in doc, f"{name}: its docstring does not state its errors"


def test_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Lines of shell blocks on demo recordings run as typed, and Python blocks one after another where `physident demo` was run."""
    import shlex

    from physident.cli import run

    monkeypatch.chdir(tmp_path)
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```(?:sh|bash)\n(.*?)```", text, flags=re.S)
    lines = [line for block in blocks for line in block.replace("\\\n", " ").splitlines()]
    typed = [shlex.split(line, comments=True) for line in lines if line.startswith("physident ")]
    # each once; others are shown with the reader's own files
    commands = list(dict.fromkeys(tuple(c[1:]) for c in typed if not any(w.startswith("runs/") for w in c)))
    assert len(commands) >= 3
    assert commands[0] == ("demo",)
    for command in commands:
        assert run(list(command)) == 0, command
    examples = re.findall(r"```python\n(.*?)```", text, flags=re.S)
    assert examples
    exec(compile("\n".join(examples), "README.md", "exec"), {"__name__": "readme"})


def test_tables_of_measured_figures_are_in_step() -> None:
    """The numbers in README and docs/measured.md are those of the studies' kept results."""
    module = script("readme_tables")
    for page in module.PAGES:
        assert module.filled(page) == page.read_text(encoding="utf-8"), "run docs/readme_tables.py"


def test_effects_page_is_in_step() -> None:
    module = script("effects_page")
    assert module.PAGE.read_text(encoding="utf-8") == module.page(), "run docs/effects_page.py"


def script(name: str) -> Any:
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
            or inside[0] in ("demo", ".git")
            or any(part.startswith(".") or part == "__pycache__" for part in inside[:-1])
        ):
            continue
        if (
            path.suffix in (".py", ".md", ".toml", ".json", ".ipynb", ".cff", ".urdf", ".pyi", "")
            and path.stat().st_size < 5e6
        ):
            text = path.read_text(encoding="utf-8", errors="ignore")
            found = [needle for needle in needles if needle in text]
            assert not found, f"{path}: {found}"
