"""A number that differs between a MuJoCo file and the recorded arm is found by a diagnosis against that file."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

import physident as pid
from physident.cli import run
from tests.mujoco_recording import record, written
from tests.vendor_robots import mjcf


def saved(folder: Path, text: str) -> Path:
    path = folder / "arm.xml"
    path.write_text(text)
    return path


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder = tmp_path_factory.mktemp("runs")
    return [written(folder, f"run_{seed}.csv", record(mjcf(), seed)) for seed in (1, 2)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changed", "effect", "value"),
    [
        ({"damping": 12.0}, "viscous_friction", 8.0),
        ({"friction": 6.0}, "coulomb_friction", 4.0),
        ({"armature": 0.5}, "rotor_inertia", 0.3),
        ({"mass": 5.0}, "link_inertia", None),
        ({"option": '<option gravity="0 0 -9.3"/>'}, "gravity_magnitude", 0.51),
    ],
    ids=["damping", "frictionloss", "armature", "mass", "gravity"],
)
def test_a_changed_number_is_named_first(
    changed: dict[str, Any], effect: str, value: float | None, runs: list[str], tmp_path: Path
) -> None:
    """The arm has the number of the recording, its file another; the finding's value is the recorded arm's."""
    path = saved(tmp_path, mjcf(**changed))
    assert run(["diagnose", "--robot", str(path), *runs, "--json", str(tmp_path / "found.json")]) == 0
    found = json.loads((tmp_path / "found.json").read_text(encoding="utf-8"))
    first = found["findings"][0]
    assert first["effect"] == effect
    parameters = {one["joint"]: one["value"] for one in first["parameters"]}
    if effect == "gravity_magnitude":
        assert first["joints"] == []
        assert re.fullmatch(
            r"Gravity is 5\.4\d % larger than described: 9\.8\d+ instead of 9\.3 m/s\^2\.", first["in_words"]
        )
        assert parameters[1] == pytest.approx(value, rel=0.02)
        return
    assert first["joints"] == [3]
    assert [one["effect"] for one in found["findings"] if one["grade"] == "cause"] == [effect]
    if value is not None:
        assert parameters[3] == pytest.approx(value, rel=0.02)


def test_gravity_of_another_size_is_no_suspect_of_a_real_arm(ur5: pid.Robot, tmp_path: Path) -> None:
    """A URDF states no gravity; a simulation does, and so does a description with another planet's."""
    suspect = pid.CATALOGUE["gravity_magnitude"].can_be_wrong
    assert not suspect(ur5)
    assert suspect(pid.load_robot("ur5", gravity=(0, 0, -1.62)))
    assert suspect(pid.load_robot(saved(tmp_path, mjcf())))
