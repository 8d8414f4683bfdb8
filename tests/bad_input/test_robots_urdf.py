"""Descriptions of robots that are no URDF of an arm, or one that could not be."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from tests.bad_input.good import TABLE, URDF, Content, write
from tests.bad_input.one_line_error import fails, refused_robot

MASS = '<mass value="2"/>'
EDITS: dict[str, tuple[str, str, str]] = {
    # name of the case: what is replaced where it first stands, by what, what the line must say
    "xacro": ('value="2"', 'value="${m}"', r"mass is \$\{m\}.*xacro"),
    "ball joint": ("revolute", "ball", "'ball', expected revolute"),
    "no type": ('type="revolute"', "", "joint 'one'"),
    "mimic with other digits": (
        "</joint>",
        '<mimic joint="two" multiplier="٢"/></joint>',
        "mimics another.*plain digits",
    ),
    "only coupled joints": ("</joint>", '<mimic joint="two"/></joint>', "every joint is locked or mimics another"),
    "negative mass": (MASS, '<mass value="-2"/>', "link 'upper': mass is -2"),
    "NaN mass": (MASS, '<mass value="nan"/>', "mass is nan"),
    "infinite mass": (MASS, '<mass value="1e999"/>', "mass is 1e999"),
    "missing mass": (MASS, "", "mass is missing"),
    "empty mass": (MASS, "<mass/>", "mass is missing"),
    "text inertia": ('ixx="0.02"', 'ixx="big"', "ixx is big"),
    "missing inertia": ('izz="0.002"', "", "izz is missing"),
    "NaN origin": ('xyz="0 0 0.4"', 'xyz="0 nan 0"', "three finite numbers"),
    "Arabic mass": (MASS, '<mass value="٢"/>', "mass is ٢, expected a finite number in plain digits"),
    "comma origin": ('xyz="0 0 0.4"', 'xyz="0,0,0.4"', "three finite numbers"),
    "zero axis": ('axis xyz="0 1 0"', 'axis xyz="0 0 0"', "axis is zero"),
    "text limit": ('lower="-3"', 'lower="low"', "lower"),
    "NaN limit": ('upper="3"', 'upper="nan"', "upper"),
    "crossed limits": ('lower="-3" upper="3"', 'lower="3" upper="-3"', "lower.*upper"),
    "negative velocity limit": ('velocity="3"', 'velocity="-3"', "velocity"),
    "joint without parent": ('<parent link="upper"/>', "", "joint 'two'.*parent"),
    "unknown parent": ('parent link="upper"', 'parent link="nobody"', "nobody"),
    "unknown child": ('child link="lower"', 'child link="nobody"', "nobody"),
    "duplicate joints": ('name="two"', 'name="one"', "joint 'one'.*twice"),
    "duplicate links": ('link name="lower"', 'link name="upper"', "link 'upper'.*twice"),
    "nameless joint": (' name="two"', "", "name"),
    "nameless link": ('<link name="base"/>', "<link/>", "name"),
    "two roots": ("</robot>", '<link name="island"/></robot>', "root|base.*island"),
    "two parents": ('child link="lower"', 'child link="upper"', "upper"),
    "a loop": ('parent link="base"', 'parent link="lower"', "loop|root"),
    "a joint to itself": ('parent link="upper"', 'parent link="lower"', "lower"),
}


@pytest.mark.parametrize("case", EDITS)
def test_edited(case: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    old, new, says = EDITS[case]
    assert old in URDF
    (folder / "r.urdf").write_text(URDF.replace(old, new, 1))
    refused_robot(capfd, folder, "r.urdf", says)


FILES: dict[str, tuple[str, Content, str]] = {
    # name of the case: file, content, what the line must say
    "empty": ("r.urdf", "", "malformed XML"),
    "malformed": ("r.urdf", URDF[:-20], "malformed XML"),
    "binary": ("r.urdf", bytes(range(256)), "text"),
    "utf-16": ("r.urdf", URDF.encode("utf-16"), "text"),
    "entity bomb": (
        "r.urdf",
        '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa">'
        + "".join(f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip("abcdefghij", "bcdefghijk", strict=True))
        + "]>"
        + URDF.replace("arm", "&k;"),
        "entities",
    ),
    "deep nesting": (
        "r.urdf",
        "<robot>" + "<link>" * 100_000 + "</link>" * 100_000 + "</robot>",
        "no moving joint|name",
    ),
    "sdf": ("r.urdf", "<sdf><model name='a'/></sdf>", "root element is <sdf>"),
    "html": ("r.urdf", "<html><body>404</body></html>", "root element is <html>"),
    "no joints": ("r.urdf", '<robot name="a"><link name="base"/></robot>', "no moving joint"),
    "only fixed joints": ("r.urdf", URDF.replace("revolute", "fixed"), "no moving joint"),
    "no links": (
        "r.urdf",
        re.sub(r"<link[^>]*/>|<link.*?[^/]>.*?</link>", "", URDF, flags=re.S),
        "which is not a link",
    ),
    "wrong origin": ("r.urdf", URDF.replace('xyz="0 0 0.2"', 'xyz="0 0"'), "three finite numbers"),
    "not found": ("r.urdf", lambda p: None, "not found"),
    "a folder": ("r.urdf", lambda p: p.mkdir(), "not found|folder"),
    "unreadable": ("r.urdf", lambda p: p.symlink_to("/proc/self/mem"), "cannot be read"),
    "huge": ("r.urdf", lambda p: os.truncate(os.open(p, os.O_CREAT | os.O_WRONLY), 1 << 40), "bytes"),
    "unknown name": ("ur6", lambda p: None, "'ur6' not found"),
    "unknown ending": ("r.txt", TABLE, "malformed XML|.toml"),
}


@pytest.mark.parametrize("case", FILES)
def test_files(case: str, folder: Path, capfd: pytest.CaptureFixture) -> None:
    name, content, says = FILES[case]
    write(folder / name, content)
    refused_robot(capfd, folder, name, says)


def test_a_robot_of_other_joints(folder: Path, capfd: pytest.CaptureFixture) -> None:
    says = "6 joints, but robot arm has 2"
    fails(capfd, folder, ["identify", "good.csv", "--robot", "arm.urdf", "--out", "out.json"], says)
