"""Model files that are damaged, of another kind, or edited by hand."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.bad_input.good import URDF, write
from tests.bad_input.nested import replaced, without
from tests.bad_input.one_line_error import fails

SHAPE = {"effect": "warm_up", "joint": 1, "field": "time_constant", "value": 9.0, "std": 1.0, "unit": "s"}
ENTRIES: dict[str, tuple[str, Any, str]] = {
    # name of the case: where the entry is, its new value, what the line must say
    "another schema": ("schema", "physident.model/99", "physident.model/99"),
    "robot a list": ("robot", [], "not a complete model"),
    "robot unknown key": ("robot.legs", 2, "legs"),
    "robot urdf a number": ("robot.urdf", 3, "not a complete model"),
    "robot urdf malformed": ("robot.urdf", "<robot", "malformed XML"),
    "robot of fewer joints": ("robot.urdf", URDF, "expected|drives"),
    "robot gravity text": ("robot.gravity", "abc", "gravity"),
    "robot gravity short": ("robot.gravity", [0, 0], "gravity"),
    "drives short": ("robot.drives", [], "drives"),
    "drive text": ("robot.drives.0.gear_ratio", "x", "gear_ratio"),
    "acceleration limit short": ("robot.acceleration_limit", [1.0], "acceleration_limit"),
    "effects none": ("effects", [], "effect"),
    "effects a number": ("effects", 3, "not a complete model"),
    "effect unknown": ("effects.1", {"effect": "magic"}, "'magic' is unknown"),
    "effect not a table": ("effects.1", "rotor_inertia", "not a complete model"),
    "effect unhashable": ("effects.1", {"effect": ["x"]}, "effect"),
    "effect unknown setting": ("effects.1.colour", "red", "colour"),
    "effect joint beyond": ("effects.1.joints", [9], "joint 9"),
    "effect joints text": ("effects.1.joints", "x", "not a complete model"),
    "effect smoothing negative": ("effects.3.smoothing", -0.01, "smoothing"),
    "effect smoothing text": ("effects.3.smoothing", "x", "smoothing|complete"),
    "parameter renamed": ("parameters.3.name", "banana", "banana"),
    "parameter NaN": ("parameters.3.value", float("nan"), "finite"),
    "parameter text": ("parameters.3.value", "x", "x"),
    "parameter null": ("parameters.3.value", None, "finite|float"),
    "covariance smaller": ("covariance", [[1.0]], "covariance"),
    "covariance NaN": ("covariance.0.0", float("nan"), r"covariance\[0\]\[0\] is nan, expected a finite number"),
    "covariance negative": ("covariance.0.0", -1.0, "covariance"),
    "sigma negative": ("sigma.0", -1.0, "sigma"),
    "sigma text": ("sigma.0", "x", r"sigma\[0\] is 'x', expected a finite number; identify it again"),
    "certificate empty": ("certificate", {}, "certificate has no 'stationarity'; identify it again"),
    "filter empty": ("filter", {"cut": 1}, "cut"),
    "filter negative": ("filter.cutoff", -5.0, "cutoff is -5"),
    "filter text": ("filter.cutoff", "x", "filter|cutoff|not a complete model"),
    "recordings a number": ("recordings", 3, "recordings is 3, expected a list"),
    "columns a number": ("columns", 3, "columns"),
    "columns rubbish": ("columns", "banana", "banana"),
    "gains short": ("drive_gains", [1.0], "drive.gains"),
    "gains text": ("drive_gains", "abcdef", "drive.gains"),
    "base_shares text": ("base_shares", "x", "base_shares is 'x', expected a list"),
    "base_shares short": ("base_shares", [1.0], "base_shares has 1 numbers, expected 58"),
    "shares text": ("shares", ["x"], r"shares\[0\] is 'x'"),
    "shares beyond": ("shares", [1.5], r"shares\[0\] is 1.5, expected a number from 0 to 1"),
    "shares without a prior": ("shares", [0.5], "ols, which has no prior"),
    "prior weight of no prior": ("prior_weight", 1.0, "ols, which has no prior"),
    "prior weight text": ("prior_weight", "x", "prior_weight is 'x'"),
    "prior weight a list": ("prior_weight", [1], r"prior_weight is \[1\]"),
    "held numbers": ("held", [3], r"held\[0\] is 3, expected a text"),
    "held text": ("held", "abc", "held is 'abc', expected a list"),
    "blocks negative": ("blocks", -1, "blocks is -1, expected a number of 1 or more"),
    "blocks a fraction": ("blocks", 2.5, "blocks is 2.5"),
    "certificate text": ("certificate.stationarity", "x", "certificate.stationarity is 'x'"),
    "certificate eigenvalue null": ("certificate.eigenvalues", [None], r"eigenvalues\[0\] is None"),
    "recording time text": ("recordings.0.used", "x", r"recordings\[0\].used is 'x'"),
    "recording hash a number": ("recordings.0.sha256", 3, r"recordings\[0\].sha256 is 3"),
    "shape of no effect": ("shapes", [SHAPE], "no time_constant of warm_up on joint 1"),
    "shape text": ("shapes", [SHAPE | {"std": "x"}], r"shapes\[0\].std is 'x'"),
    "gains zero": ("drive_gains", [0, 1, 1, 1, 1, 1], "drive.gains"),
}
CONTENTS: dict[str, tuple[bytes | str | Callable[[dict], Any], str]] = {
    # name of the case: content, or a change of a good model in place, what the line must say
    "empty": ("", "not valid JSON"),
    "not JSON": ("model: 1\n", "not valid JSON"),
    "binary": (bytes(range(256)), "not UTF-8 text"),
    "huge nesting": ("[" * 200_000, "not valid JSON"),
    "long integer": ('{"schema": ' + "9" * 10_000 + "}", "not valid JSON|schema"),
    "a list": ("[1, 2]", "schema is 'list'"),
    "a number": ("3", "schema is 'int'"),
    "no robot": (without("robot"), "robot"),
    "effect twice": (lambda m: m["effects"].append(m["effects"][0]), "twice|expected"),
    "parameters missing": (without("parameters"), "parameters"),
    "parameters short": (without("parameters", 3), "expected"),
    "covariance ragged": (lambda m: m["covariance"][0].pop(), "not a complete model"),
    "sigma short": (without("sigma", 0), "sigma"),
    "relative short": (without("relative_percent", 0), "relative"),
    "effective samples short": (without("effective_samples", 0), "effective"),
    "recording without hash": (without("recordings", 0, "sha256"), "sha256"),
}


def good(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "model.json").read_text())


def refused(capfd: pytest.CaptureFixture, folder: Path, content: bytes | str, says: str) -> None:
    write(folder / "bad.json", content)
    fails(capfd, folder, ["validate", "other.csv", "--model", "bad.json", "--json", "out.json"], says)


@pytest.mark.parametrize("case", ENTRIES)
def test_entries(case: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    where, value, says = ENTRIES[case]
    path = tuple(int(key) if key.isdigit() else key for key in where.split("."))
    refused(capfd, folder, json.dumps(replaced(good(folder), path, value)), says)


@pytest.mark.parametrize("case", CONTENTS)
def test_contents(case: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    content, says = CONTENTS[case]
    if callable(content):
        model = good(folder)
        content(model)
        content = json.dumps(model)
    refused(capfd, folder, content, says)
