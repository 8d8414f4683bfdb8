"""Effects that users bring: from a file, from a package, and through every command; the tutorial on it is played as it stands."""

from __future__ import annotations

import json
import re
import sys
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.cli import run
from physident.diagnosis.result.advice import design_command
from physident.diagnosis.result.findings import Rival
from physident.effects.catalogue import effects_from
from physident.effects.user.registration import add_entry_points
from physident.identifiability.base_parameters import random_motion
from physident.testing import check_effect
from tests.conftest import ROOT
from tests.loads import arm, record
from tests.test_tutorial import close, compared, script

PAGE = ROOT / "docs" / "tutorials" / "your-own-effect.md"
CLASS = PAGE.read_text(encoding="utf-8").split("```python\n")[1].split("```")[0]
NAME = "lubricant_friction"
BAD = {
    "syntax": ("import x y", r"effects.py: line 1: SyntaxError"),
    "failure": ("a = 1\nb = 1 / 0", r"effects.py: line 2: ZeroDivisionError: division by zero"),
    "no effect": ("a = 1", r"effects.py: defines no effect"),
    "exit": ("raise SystemExit(0)", r"effects.py: line 1: SystemExit"),
    "name of another": (CLASS.replace(NAME, "payload"), r"the name 'payload', as the effect of the catalogue"),
    "no name": (CLASS.replace(f'"{NAME}"', "3"), r"has the name 3; expected a word"),
    "no unit": (CLASS.replace('    unit = "N m"\n', ""), r"states no unit"),
    "no family": (CLASS.replace("pid.Family.FRICTION", "'friction'"), r"states no family"),
    "no expression": (
        CLASS.replace('("v / 0.3', '("v / / 0.3'),
        r"effects.py: line 1?\d: Lubricant\w+: the formula .* is no expression of Python",
    ),
    "one text": (
        CLASS.replace('formulas = ("', 'formulas = "').replace('",)', '"'),
        r"effects.py: line 1?\d: Lubricant\w+: formulas = .* is one text; expected several",
    ),
    "no formulas": (CLASS.split("    formulas")[0] + "    formulas = ()\n", r"states no formulas"),
    "two of a name": (CLASS + "\n\n" + CLASS.replace("class Lubricant", "class Other"), r"as another effect there"),
    "not frozen": (CLASS.replace("@dataclass(frozen=True)", "") + "    c: float = 1.0\n", r"frozen"),
}


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder with the tutorial's effect in my_effects.py; the catalogue is as before afterwards."""
    monkeypatch.chdir(tmp_path)
    Path("my_effects.py").write_text(CLASS, encoding="utf-8")
    for name, effect in list(pid.CATALOGUE.items()):
        monkeypatch.setitem(pid.CATALOGUE, name, effect)
    yield tmp_path
    pid.CATALOGUE.pop(NAME, None)


@pytest.mark.slow
def test_the_tutorial_prints_what_it_says(tmp_path: Path) -> None:
    text = PAGE.read_text(encoding="utf-8")
    try:
        played = script().played(text, tmp_path)
    finally:
        pid.CATALOGUE.pop(NAME, None)
    (words, numbers), (now, real) = compared(text), compared(played)
    assert now == words, "run docs/tutorials/run.py"
    assert all(close(a, b) for a, b in zip(numbers, real, strict=True)), "run docs/tutorials/run.py"
    found = json.loads((tmp_path / "diagnosis.json").read_text())
    causes = [(f["effect"], f["joints"]) for f in found["findings"] if f["grade"] == "cause"]
    assert causes == [(NAME, [3])]
    value = next(p["value"] for p in found["extended_model"]["parameters"] if p["name"] == f"{NAME}_3")
    assert value == pytest.approx(12.0, rel=0.2)


def test_its_exported_function_is_the_stated_law(own: Path, ur5: pid.Robot) -> None:
    (law,) = pid.load_effects("my_effects.py")
    base = pid.Model.nominal(ur5, ["rigid_body"])
    pid.export_python(pid.Model(ur5, (*base.effects, law(joints=(3,))), np.append(base.theta, 2.5)), "arm.py")
    space: dict = {}
    exec(Path("arm.py").read_text(encoding="utf-8"), space)
    motion = random_motion(ur5, seed=3)
    v = motion.v[:, 2]
    film = space["torque"](motion.q, motion.v, motion.a)[:, 2] - base.torque(motion)[:, 2]
    np.testing.assert_allclose(film, 2.5 * (v / 0.3) / (1 + (v / 0.3) ** 2), rtol=1e-6, atol=1e-8)


def test_a_saved_model_asks_for_its_file_again(own: Path, ur5: pid.Robot, capfd: pytest.CaptureFixture[str]) -> None:
    for seed in (1, 2):
        record(arm(ur5), seed).to_pandas().to_csv(f"{seed}.csv", index=False)
    effects = f"rigid_body,rotor_inertia,viscous_friction,coulomb_friction,torque_offset,{NAME}"
    bring = ["--effects-from", "my_effects.py"]
    typed = ["identify", "1.csv", "--robot", "ur5", "--effects", effects, "--out", "model.json", *bring]
    assert run(typed) == 0
    assert NAME not in pid.CATALOGUE  # brought for one command alone
    capfd.readouterr()
    validate = ["validate", "--model", "model.json", "2.csv"]
    assert run(validate) == 2
    error = capfd.readouterr().err
    assert error.count("\n") == 1
    assert "--effects-from my_effects.py" in error
    assert run([*validate, *bring]) == 0
    assert run(["export", "--model", "model.json", "--python", "arm.py", *bring]) == 0
    assert run(["view", "2.csv", "--model", "model.json", "--out", "own.rrd", *bring]) == 0


@pytest.mark.parametrize("case", BAD)
def test_a_file_that_brings_no_effect_is_refused_in_one_line(
    case: str, own: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    text, expected = BAD[case]
    Path("effects.py").write_text(text, encoding="utf-8")
    assert run(["base-parameters", "--robot", "ur5", "--effects-from", "effects.py"]) == 2
    error = capfd.readouterr().err
    assert error.count("\n") == 1
    with pytest.raises(pid.InputError, match=expected):
        pid.load_effects("effects.py")


@pytest.mark.parametrize(
    ("formula", "says"),
    [("0 * v", "values are zero"), ("np.sum(v)", "depend on others"), ("q", "it drives a joint"), ("v", "")],
)
def test_a_command_warns_of_an_effect_that_breaks_the_contract(
    formula: str, says: str, own: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """It would be identified without a word, and no number of it would be right."""
    text = re.sub(r"formulas = .*", f'formulas = ("{formula}",)', CLASS)
    Path("effects.py").write_text(text.replace("    unit =", "    passive = True\n    unit ="), encoding="utf-8")
    assert run(["base-parameters", "--robot", "ur5", "--effects-from", "effects.py"]) == 0
    warned = capfd.readouterr().err
    assert bool(warned) is bool(says)
    assert says in warned


def test_a_formula_uses_functions_of_numpy_alone(own: Path) -> None:
    """Others would work until the model is exported."""
    pid.load_effects("my_effects.py")
    Path("my_effects.py").write_text(CLASS.replace('("v / 0.3', '("abs(v) / 0.3'), encoding="utf-8")
    pid.load_effects("my_effects.py")
    with pytest.raises(AssertionError, match=r"'abs' is not defined.*expected NumPy of q, v"):
        check_effect(pid.CATALOGUE[NAME]())


def test_a_command_brings_the_effects_that_it_names(own: Path) -> None:
    assert effects_from(["payload", NAME]) == []
    pid.load_effects("my_effects.py")
    assert effects_from(["payload", NAME, NAME]) == ["--effects-from", "my_effects.py"]
    model = pid.Model(pid.load_robot("ur5"), (pid.CATALOGUE["torque_offset"](),), np.zeros(6))
    rival = Rival(NAME, (3,), False)
    command = design_command(model, "model.json", "viscous_friction", (3,), rival)
    assert command.endswith("--effects-from my_effects.py --out motion.json")


@pytest.mark.parametrize("path", ["nowhere.py", ".", "notes.txt"])
def test_what_is_no_python_file_is_refused(path: str, own: Path) -> None:
    Path("notes.txt").write_text("a = 1", encoding="utf-8")
    with pytest.raises(pid.InputError, match="expected"):
        pid.load_effects(path)


def test_a_file_may_be_loaded_again_after_an_edit(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Within the same second and of the same size, too, where Python keeps bytecode."""
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    pid.load_effects("my_effects.py")
    Path("my_effects.py").write_text(CLASS.replace("0.3", "0.4"), encoding="utf-8")
    (now,) = pid.load_effects("my_effects.py")
    assert pid.CATALOGUE[NAME] is now
    assert "0.4" in now.formulas[0]


def test_an_installed_package_brings_its_effects(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(own))
    catalogue: dict = {}
    for value in ("my_effects", "my_effects:LubricantFriction"):
        catalogue.clear()
        add_entry_points(catalogue, [EntryPoint("film", value, "physident.effects")])
        assert list(catalogue) == [NAME]
    with pytest.raises(pid.InputError, match=r"nothing_there.*cannot be loaded"):
        add_entry_points({}, [EntryPoint("film", "nothing_there", "physident.effects")])
    sys.modules.pop("my_effects", None)


@dataclass(frozen=True)
class Drives(pid.VelocityFriction):
    """It says that it takes energy, and gives some."""

    name = "drives"
    unit = "N m"
    signature = "none"
    mistaken_for = "none"

    def law(self, robot: pid.Robot, v: np.ndarray, sign: np.ndarray) -> np.ndarray:
        return np.cos(v)


@dataclass(frozen=True)
class Averages(pid.Effect):
    """It looks at other instants, and does not say so; its columns have no unit."""

    name = "averages"
    unit = ""
    family = pid.Family.FRICTION

    def values(self, robot: pid.Robot, signals: pid.Signals) -> np.ndarray:
        return (signals.v - signals.v.mean(axis=0)).T[self.active(robot)]


@dataclass(frozen=True)
class OtherFormula(Drives):
    """What it exports is not what it computes."""

    passive = False
    formulas = ("np.sin(v)",)


@pytest.mark.parametrize(
    ("effect", "clause"),
    [
        (Drives, "drives a joint"),
        (Averages, "depend on others"),
        (Averages, "a unit"),
        (OtherFormula, "are not values"),
    ],
)
def test_the_contract_names_what_is_broken(effect: type[pid.Effect], clause: str) -> None:
    with pytest.raises(AssertionError, match=clause):
        check_effect(effect)


VALUES = """
    def values(self, robot, signals):
        {body}
"""
FAULTY = {
    "writes": (
        "signals.v[:] *= 2; return signals.v.T",
        r"line \d+: lubricant_friction.values fails: ValueError: .*read-only",
    ),
    "shape": ("return signals.v", r"gives an array of shape \(\d+, 6\); expected \(6, \d+\)"),
    "nothing": ("return None", r"gives a NoneType; expected a NumPy array"),
    "complex": ("return signals.v.T * 1j", r"gives an array of complex128; expected"),
    "not finite": ("return signals.v.T / 0.0", r"not finite .* where q = \["),
    "huge": ("return 1e200 * signals.v.T", r"larger than 1e\+50"),
    "a bug": ("return signals.velocity.T", r"AttributeError: 'Signals' object has no attribute 'velocity'"),
}


@pytest.mark.parametrize("fault", FAULTY)
def test_a_faulty_law_is_one_line_and_changes_nothing_else(own: Path, fault: str, ur5: pid.Robot) -> None:
    body, says = FAULTY[fault]
    Path("faulty.py").write_text(CLASS + VALUES.format(body=body), encoding="utf-8")
    (effect,) = pid.load_effects("faulty.py")
    motion = random_motion(ur5, 1)
    before = {name: np.array(getattr(motion, name)) for name in "qva"}
    with pytest.raises(pid.InputError, match=says) as told:
        pid.Model.nominal(ur5, ["rigid_body", NAME]).torque(motion)
    assert "\n" not in str(told.value)
    assert str(told.value).startswith("faulty.py: ")
    for name, values in before.items():
        np.testing.assert_array_equal(getattr(motion, name), values)
    with pytest.raises(AssertionError):
        check_effect(effect)


def test_formulas_cannot_write_either(own: Path, ur5: pid.Robot) -> None:
    law = CLASS.split("    formulas")[0] + '    formulas = ("np.multiply(v, 2, out=v)",)\n'
    Path("writes.py").write_text(law, encoding="utf-8")
    pid.load_effects("writes.py")
    with pytest.raises(pid.InputError, match="read-only"):
        pid.Model.nominal(ur5, ["rigid_body", NAME]).torque(random_motion(ur5, 1))


def test_a_law_that_was_edited_since_is_told(own: Path, ur5: pid.Robot) -> None:
    runs = [record(arm(ur5), k) for k in (1, 2)]
    pid.load_effects("my_effects.py")
    pid.identify(ur5, runs, effects=["rigid_body", "coulomb_friction", NAME]).save("model.json")
    for change, told in (("", 0), ("# a note\n", 1)):
        Path("my_effects.py").write_text(CLASS + change, encoding="utf-8")
        pid.load_effects("my_effects.py")
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            pid.load_estimate("model.json")
        assert len([one for one in said if "is not the file of lubricant_friction" in str(one.message)]) == told


def test_the_contract_refuses_a_class_that_no_catalogue_takes() -> None:
    class Open(pid.FormulaEffect):  # a dataclass of its own was forgotten
        name, unit, family, formulas = "open", "N m", pid.Family.FRICTION, ("v",)

    with pytest.raises(AssertionError, match="no frozen dataclass"):
        check_effect(Open)


@pytest.mark.parametrize("name", sorted(pid.CATALOGUE))
def test_every_effect_of_the_catalogue_keeps_the_contract(name: str) -> None:
    check_effect(pid.CATALOGUE[name])


def test_a_formula_may_depend_on_load_and_time(ur5: pid.Robot) -> None:
    @dataclass(frozen=True)
    class Drift(pid.FormulaEffect):
        """Two parameters a joint: by the load, and by the time."""

        name = "drift"
        unit = "1, N m/s"
        family = pid.Family.TRANSMISSION
        formulas = ("load", "t")
        signature = "none"
        mistaken_for = "none"

    check_effect(Drift)
    motion = pid.Model.nominal(ur5).refer(random_motion(ur5, 1))
    Phi = Drift(joints=(2,)).regressor(ur5, motion)
    assert motion.load is not None
    np.testing.assert_allclose(Phi[:, 1, 0], motion.load[:, 1])
    np.testing.assert_allclose(Phi[:, 1, 1], motion.time - motion.origin)
    assert Drift.needs_model
