"""The example in CONTRIBUTING.md is complete: one class and one line, and every part of the package uses the effect."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.result.wording import cause
from physident.graphics.style import effect_colour
from physident.identifiability.base_parameters import random_motion
from tests.conftest import ROOT
from tests.test_house import PACKAGE, script

pytestmark = pytest.mark.slow

TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
NAME = "lubricant_friction"


def test_a_new_effect_is_one_class_and_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    law, example = re.findall(r"```python\n(.*?)```", TEXT, flags=re.S)
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {"__name__": "contributing"}
    try:
        exec(compile(law, "CONTRIBUTING.md", "exec", dont_inherit=True), names)
        exec(compile(example, "CONTRIBUTING.md", "exec", dont_inherit=True), names)
        _check(names, capsys.readouterr().out)
    finally:
        pid.CATALOGUE.pop(NAME, None)


def _check(names: dict[str, Any], printed: str) -> None:
    robot, estimate, diagnosis = names["robot"], names["estimate"], names["diagnosis"]
    assert estimate.model.parameters(NAME)[0] == pytest.approx(12.0, rel=0.1)
    assert [(finding.effect, finding.joints) for finding in diagnosis.causes][:1] == [(NAME, (3,))]
    assert NAME in printed
    assert cause(NAME, (3,)) == "lubricant friction on joint 3"
    assert effect_colour(NAME).startswith("#")
    space: dict[str, Any] = {}
    exec(Path("arm.py").read_text(encoding="utf-8"), space)
    motion = random_motion(robot, seed=3)
    np.testing.assert_allclose(
        space["torque"](motion.q, motion.v, motion.a), estimate.model.torque(motion), rtol=1e-9, atol=1e-9
    )
    filter = pid.Filter()
    table = pid.measure_identifiability(robot, [pid.prepare(run, filter) for run in names["runs"]], filter)
    assert table.share(NAME, (3,), "new") == 1
    assert f"## `{NAME}`" in script("effects_page").page()


def test_the_tree_lists_every_folder() -> None:
    (tree,) = re.findall(r"```text\nphysident/\n(.*?)```", TEXT, flags=re.S)
    listed, parent = set(), ""
    for line in tree.splitlines():
        folders = [word for word in line.split() if word.endswith("/")]
        indented = line.startswith("    ")
        listed |= {f"{parent if indented else ''}{folder}" for folder in folders}
        parent = parent if indented or not folders else folders[0]
    folders = {path.parent.relative_to(PACKAGE).as_posix() + "/" for path in PACKAGE.rglob("__init__.py")}
    assert listed == folders - {"./"}
