"""What hides an effect shares nothing with what finds it: no module, and no number that decides physics.

Imports are followed through all modules of the project, so that none comes in by a detour. Numbers are those of constants
and of the fields of dataclasses: two are the same if their values and units are. A number without a unit is compared with
others without one only.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.conftest import ROOT

FINDER, FIRST, SECOND = "physident", "tests/plant", "tests/plant_mujoco"
HELPERS = ("samples.py", "expected.py")  # arms and expectations of the plant's own tests
WITHOUT_PHYSICS = ("cli", "graphics", "report", "export")  # how results are asked for, drawn and written
UNITS = ("kg m^2", "N m s/rad", "N m/rad", "N m", "rad/s^2", "rad/s", "m/s^2", "m/s", "degC", "rad", "kg", "Hz", "mm",
         "1/K", "K", "N", "m", "s", "W", "A", "V")  # fmt: skip
ROUND = (0.0, 1.0, 2.0, 0.5)  # besides powers of ten: anybody's first choice of a number without a unit
ROUNDING = 1e-6  # of any unit: so small a number says where arithmetic ends, not what an arm does
# facts that nobody is free to choose, and what the contract of both plants fixes
FACTS = {
    (9.81, "m/s^2"): "gravity",
    (25.0, "degC"): "tests/truth.py: temperatures count from here",
    (125.0, "Hz"): "the rate of the UR5's controller",
}
# equal by chance: the one has nothing to do with the other
CHANCE = {
    (
        "Sensors.velocity_noise",
        "ROUGH",
    ): "noise of an instrument; roughness at which the simulator's integrator cuts its step",
    ("SPRING_DAMPING_TIME", "STEP"): "damping of an elastic gear; step of the replay's integrator",
    ("STEP", "STEP"): "steps of two integrators: the plant's, and that of a replay, which judges no diagnosis",
    ("TURN", "FRICTION"): "accuracy of the plant's integrator; how much friction a channel behind the gear can show",
    ("Friction.warm_time", "LONGEST"): "how fast a joint warms up; the longest horizon of a replay",
    ("TURN", "VAGUE"): "accuracy of the plant's integrator; width of a printed interval",
    (
        "SHORTEST_MOVE",
        "PIECE",
    ): "a move from point to point in the closed world; how long a contact's force stays the same",
}


@dataclass(frozen=True)
class Number:
    """A constant's value: a number, or a row of them."""

    name: str
    place: str
    value: tuple[float, ...]
    unit: str


@cache
def numbers(folder: str) -> list[Number]:
    """The numbers of all modules of a folder."""
    found = []
    for path in sorted((ROOT / folder).rglob("*.py")):
        if path.name not in HELPERS and path.relative_to(ROOT).parts[1] not in WITHOUT_PHYSICS:
            found += _of_module(path)
    return found


def _of_module(path: Path) -> Iterator[Number]:
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    for name, value, line in _assigned(ast.parse(text)):
        comment = lines[line - 1].partition("#")[2].strip()
        for (one, each), unit in zip(_pairs(name, value), _units(comment), strict=False):
            row = _evaluated(each)
            if row:
                yield Number(one, f"{path.relative_to(ROOT)}:{line}", row, unit)


def _assigned(tree: ast.Module) -> Iterator[tuple[ast.expr, ast.expr, int]]:
    """Targets, values and lines of module constants and of class fields."""
    for node in tree.body:
        if isinstance(node, ast.Assign):
            yield node.targets[0], node.value, node.end_lineno or node.lineno
        elif isinstance(node, ast.ClassDef):
            for field in node.body:
                if isinstance(field, ast.AnnAssign) and field.value is not None and isinstance(field.target, ast.Name):
                    target = ast.Name(f"{node.name}.{field.target.id}")
                    yield target, field.value, field.end_lineno or field.lineno


def _pairs(target: ast.expr, value: ast.expr) -> list[tuple[str, ast.expr]]:
    if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
        return [
            (name.id, each) for name, each in zip(target.elts, value.elts, strict=True) if isinstance(name, ast.Name)
        ]
    known = isinstance(target, ast.Name) and (target.id.isupper() or "." in target.id)
    return [(target.id, value)] if known and isinstance(target, ast.Name) else []


def _units(comment: str) -> Iterator[str]:
    """The units that a comment begins with; the last, or none, is that of all further numbers."""
    unit = ""
    while match := re.match(rf"({'|'.join(map(re.escape, UNITS))})(?=$|[\s:,;|])", comment):
        unit = match[1]
        yield unit
        if not comment[len(unit) :].startswith(", "):
            break
        comment = comment[len(unit) + 2 :]
    while True:
        yield unit


def _evaluated(node: ast.expr) -> tuple[float, ...]:
    """The floats of an expression of numbers; whole numbers count things."""
    try:
        value: Any = eval(compile(ast.Expression(node), "", "eval"), {"np": np, "math": math})  # the project's own code
    except Exception:
        return ()
    if isinstance(value, float):
        return (value,)
    if isinstance(value, np.ndarray):
        value = tuple(value.ravel().tolist())
    rows = isinstance(value, tuple) and all(isinstance(x, int | float) for x in value)
    return tuple(map(float, value)) if rows and any(isinstance(x, float) for x in value) else ()


def trivial(number: Number) -> bool:
    """Whether a value says nothing about who chose it."""
    if len(number.value) != 1:
        return False
    value = float(*number.value)
    power = value > 0 and math.isclose(math.log10(value), round(math.log10(value)), abs_tol=1e-9)
    if number.unit:
        return value == 0 or (bool(power) and value <= ROUNDING)
    return value in ROUND or bool(power)


def shared(one: list[Number], other: list[Number]) -> list[str]:
    """Numbers that stand in both lists, in words."""
    found = []
    for a in one:
        for b in other:
            same = a.value == b.value and a.unit == b.unit and not trivial(a)
            fact = (a.value[0], a.unit) in FACTS
            if same and not fact and (a.name, b.name) not in CHANCE:
                found.append(f"{a.name} = {b.name} = {a.value} {a.unit}: {a.place}, {b.place}")
    return found


@pytest.mark.parametrize(("one", "other"), [(FIRST, FINDER), (SECOND, FINDER), (FIRST, SECOND)])
def test_no_number_that_decides_physics_stands_on_both_sides(one: str, other: str) -> None:
    assert shared(numbers(one), numbers(other)) == []


def test_the_search_for_numbers_finds_them() -> None:
    """It sees the widths of friction that this rule is most about, and would see them if they were equal."""
    of_plant = {n.name: n for n in numbers(FIRST)}
    of_finder = {n.name: n for n in numbers(FINDER)}
    width, smoothing = of_plant["WIDTH"], of_finder["SHARPEST"]
    assert width.unit == smoothing.unit == "rad/s"
    assert shared([Number("WIDTH", "", smoothing.value, "rad/s")], [smoothing])
    assert of_plant["Friction.slip"].unit == "rad"
    assert {n.name for n in numbers(SECOND)} >= {"GEAR_DAMPING", "BASE_MASS", "BASE_RADIUS", "RIGID", "STEP"}
    assert next(n.unit for n in numbers(SECOND) if n.name == "BASE_RADIUS") == "m"


def test_every_excuse_is_needed() -> None:
    """A coincidence that has gone must not excuse the next one."""
    finder = numbers(FINDER)
    names = {(a.name, b.name) for a in numbers(FIRST) + numbers(SECOND) for b in finder if a.value == b.value}
    assert set(CHANCE) <= names


def _modules(folder: str) -> list[str]:
    return [_module(path) for path in sorted((ROOT / folder).rglob("*.py"))]


def _module(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _file(module: str) -> Path | None:
    base = ROOT.joinpath(*module.split("."))
    return next((path for path in (base.with_suffix(".py"), base / "__init__.py") if path.exists()), None)


def _imported(path: Path) -> set[str]:
    """Modules that a module names in its imports, wherever they stand, with the packages that they are in."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            raise AssertionError(f"{path}: a relative import, which this test does not follow")
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith(("import_module", "__import__")):
            raise AssertionError(f"{path}: an import by name, which this test does not follow")
    return found | {name.rpartition(".")[0] for name in found if "." in name}


def reached(roots: list[str]) -> set[str]:
    """All modules that come in with some modules of the project."""
    seen: set[str] = set()
    waiting = list(roots)
    while waiting:
        module = waiting.pop()
        if module in seen:
            continue
        seen.add(module)
        path = _file(module)
        if path is not None and module.split(".")[0] != FINDER:
            waiting += _imported(path) - seen
    return seen


def _makers_of_disturbances() -> list[str]:
    """Modules of both open worlds that describe what disturbs an arm, and those that draw arms, motions and causes."""
    drawn = ("arms", "background", "causes", "motions", "outside", "descriptions")
    found = [f"studies.open_world.{name}" for name in drawn]
    for folder in ("studies/open_world", "studies/open_world_second"):
        for path in (ROOT / folder).glob("*.py"):
            tree = ast.parse(path.read_text(encoding="utf-8"))
            classes = [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
            if any("Disturbance" in ast.unparse(base) for node in classes for base in node.bases):
                found.append(_module(path))
    return found


def _from_finder(modules: set[str]) -> list[str]:
    return sorted(m for m in modules if m.split(".")[0] == FINDER)


def test_nothing_that_hides_imports_what_finds() -> None:
    makers = _makers_of_disturbances()
    assert {"studies.open_world.background", "studies.open_world.outside_laws"} <= set(makers)
    assert any(m.startswith("studies.open_world_second.") for m in makers)
    hiding = ["tests.truth", "tests.serial_arms", *_modules(FIRST), *_modules(SECOND), *makers]
    assert _from_finder(reached(hiding)) == []
    # the one place that gives an arm the estimator's friction is seen from afar
    assert "physident.recordings.velocity_sign" in reached(["studies.blind_trials.arms"])


def test_the_second_world_draws_without_what_finds() -> None:
    reach = reached(_modules("studies/open_world_second"))
    # instruments write files as the first world's do, and read nothing of the search
    assert _from_finder(reach) == []


def test_the_plants_import_nothing_of_each_other() -> None:
    plain, mujoco = reached(_modules(FIRST)), reached(_modules(SECOND))
    assert not [m for m in plain if m.startswith("tests.plant_mujoco")]
    assert not [m for m in mujoco if m == "tests.plant" or m.startswith("tests.plant.")]
    assert {m for m in plain & mujoco if m.startswith(("tests.", "studies."))} <= {"tests.truth"} | _names_in(
        "tests.truth"
    )


def _names_in(module: str) -> set[str]:
    """What can be imported from a module by name."""
    path = _file(module)
    assert path is not None
    tree = ast.parse(path.read_text(encoding="utf-8"))
    names = [n.name for n in tree.body if isinstance(n, ast.ClassDef)]
    names += [t.id for n in tree.body if isinstance(n, ast.Assign) for t in n.targets if isinstance(t, ast.Name)]
    return {f"{module}.{name}" for name in names}
