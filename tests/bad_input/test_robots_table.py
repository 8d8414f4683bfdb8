"""DH tables that do not describe an arm."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.bad_input.good import TABLE, Content, write
from tests.bad_input.one_line_error import refused_robot

EDITS: dict[str, tuple[str, str, str]] = {
    # name of the case: what is replaced where it first stands, by what, what the line must say
    "of another schema": ("dh/1", "dh/9", "physident.dh/9"),
    "text length": ("d = 0.1", 'd = "0.1"', "joint 1: d is '0.1'"),
    "text com": ("com = [0.1,", 'com = ["x",', "joint 2: com"),
    "ragged com": ("com = [0.1,", "com = [[0.1],", "joint 2: com"),
    "missing length": ("a = 0.4\n", "", "joint 2: a is None|missing"),
    "boolean mass": ("mass = 2.0", "mass = true", "joint 1: mass"),
    "negative mass": ("mass = 2.0", "mass = -2.0", "mass is -2"),
    "NaN mass": ("mass = 2.0", "mass = nan", "joint 1: mass is nan"),
    "inertia without mass": ("mass = 2.0\n", "", "joint 1: .*mass"),
    "short inertia": ("inertia = [0.001, 0.0, ", "inertia = [0.001, ", "joint 2: inertia"),
    "unknown key": ("alpha_deg = 90.0", "alpha = 1.57\nalpha_deg = 90.0", "'alpha'"),
    "unknown top key": ("name =", "nmae =", "'nmae'"),
    "unknown kind": ("a = 0.4", 'a = 0.4\nkind = "spherical"', "spherical"),
    "kind a number": ("a = 0.4", "a = 0.4\nkind = 3", "kind is 3"),
    "name a number": ("a = 0.4", "a = 0.4\nname = 3", "name is 3"),
    "robot name a list": ('name = "arm"', "name = [1]", "name is"),
    "one limit": ("limits = [-3.0, 3.0]", "limits = [3.0]", "joint 1: limits"),
    "text limits": ("limits = [-3.0, 3.0]", 'limits = ["a", "b"]', "joint 1: limits"),
    "crossed limits": ("limits = [-3.0, 3.0]", "limits = [3.0, -3.0]", "lower.*upper|limits"),
    "limits no list": ("limits = [-3.0, 3.0]", "limits = 3.0", "joint 1: limits"),
    "text velocity": ("a = 0.4", 'a = 0.4\nvelocity_limit = "fast"', "velocity_limit"),
    "negative acceleration": ("a = 0.4", "a = 0.4\nacceleration_limit = -1.0", "acceleration"),
    "calibration a number": ("a = 0.4", "a = 0.4\ncalibration = 1", "calibration"),
    "calibration text": ("a = 0.4", 'a = 0.4\ncalibration = {d = "x"}', "calibration"),
    "calibration unknown": ("a = 0.4", "a = 0.4\ncalibration = {delta = 1.0}", "delta"),
    "drive lacks an entry": ("gear_ratio = 101.0, ", "", "gear_ratio"),
    "drive text": ("gear_ratio = 101.0", 'gear_ratio = "101"', "gear_ratio"),
    "drive zero gear": ("gear_ratio = 101.0", "gear_ratio = 0.0", "gear_ratio"),
    "drive one friction": ("[0.1, -0.1]", "[0.1]", "motor_friction"),
    "drive unknown entry": ("gear_ratio", "ratio = 1.0, gear_ratio", "'ratio'"),
    "capsule of zero length": ("end = [0.0, 0.0, 0.1]", "end = [0.0, 0.0, 0.0]", "capsule"),
    "capsule without radius": (", radius = 0.05", "", "capsule.*radius"),
    "capsule negative radius": ("radius = 0.05", "radius = -0.05", "radius"),
    "capsule text": ("radius = 0.05", 'radius = "fat"', "radius"),
    "capsule short point": ("end = [0.0, 0.0, 0.1]", "end = [0.0, 0.1]", "end"),
    "base a number": ("[[joints]]", "base = 1\n[[joints]]", "base"),
    "gravity short": ("[[joints]]", "gravity = [0.0, -9.81]\n[[joints]]", "gravity"),
    "gravity text": ("[[joints]]", 'gravity = "down"\n[[joints]]', "gravity"),
    "gravity NaN": ("[[joints]]", "gravity = [0.0, 0.0, nan]\n[[joints]]", "gravity"),
    "text tool speed": ("[[joints]]", 'tool_speed_limit = "1"\n[[joints]]', "tool_speed"),
}


@pytest.mark.parametrize("case", EDITS)
def test_edited(case: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    old, new, says = EDITS[case]
    assert old in TABLE
    (folder / "r.toml").write_text(TABLE.replace(old, new, 1))
    refused_robot(capfd, folder, "r.toml", says)


FILES: dict[str, tuple[str, Content, str]] = {
    # name of the case: file, content, what the line must say
    "empty": ("r.toml", "", "schema is None"),
    "malformed": ("r.toml", "joints = [", "not valid TOML"),
    "deep": ("r.toml", "a = " + "[" * 100_000, "not valid TOML"),
    "without joints": ("r.toml", TABLE.split("[[joints]]")[0], r"no \[\[joints\]\]"),
    "joints a number": ("r.toml", TABLE.split("[[joints]]")[0] + "joints = 3", r"no \[\[joints\]\]"),
    "duplicate joint names": ("r.toml", TABLE.replace("d = 0", 'name = "same"\nd = 0'), "'same'.*twice"),
    "drive a number": ("r.toml", re.sub(r"drive = \{.*?\}", "drive = 5", TABLE, count=1), "joint 1: drive"),
    "some drives": ("r.toml", re.sub(r"drive = \{.*?\}", "", TABLE, count=1), "joint 1.*drive"),
    "capsules a number": ("r.toml", re.sub(r"capsules = .*", "capsules = 3", TABLE), "capsules"),
}


@pytest.mark.parametrize("case", FILES)
def test_files(case: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    name, content, says = FILES[case]
    write(folder / name, content)
    refused_robot(capfd, folder, name, says)
