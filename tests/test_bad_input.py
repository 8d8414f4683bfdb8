"""Rubbish fed to the command line: exit code 2, one line that says what came, nothing left behind, memory bounded."""

from __future__ import annotations

import contextlib
import gzip
import io
import itertools
import json
import os
import re
import subprocess
import sys
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import physident as pid
from physident.cli import run

N, STEP = 400, 0.01  # rows, s
MEMORY = 3 << 30  # bytes of address space: libraries alone map about half of it
Folder = Path
HEADER = ",".join(["time", *(f"{kind}_{j}" for kind in ("q", "dq", "tau") for j in range(1, 7))])


def table() -> np.ndarray:
    """A recording of six joints (N, 19): time, q, dq, tau."""
    time = STEP * np.arange(N)
    w = 2 * np.pi * (0.5 + 0.15 * np.arange(6))
    q, dq = np.sin(time[:, None] * w), w * np.cos(time[:, None] * w)
    return np.column_stack([time, q, dq, 5 * np.sign(dq) + 8 * np.cos(q) - 2 * w**2 * np.sin(time[:, None] * w)])


def as_csv(values: np.ndarray, header: str = HEADER, separator: str = ",") -> str:
    rows = [separator.join(f"{x:.9g}" for x in row) for row in values]
    return "\n".join([*([header] if header else []), *rows]) + "\n"


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Good files, so that each case breaks one thing: two recordings, a URDF, a DH table, a model."""
    folder = tmp_path_factory.mktemp("bench")
    values = table()
    (folder / "good.csv").write_text(as_csv(values))
    values[:, 7:] *= 1.01
    (folder / "other.csv").write_text(as_csv(values))
    (folder / "arm.urdf").write_text(URDF)
    (folder / "arm.toml").write_text(TABLE)
    fit = ["identify", str(folder / "good.csv"), "--robot", "ur5", "--method", "ols"]
    assert run([*fit, "--out", str(folder / "model.json")]) == 0
    fit = ["identify", str(folder / "good.csv"), "--robot", str(folder / "arm.toml"), "--method", "ols"]
    assert run([*fit, "--columns", "time=0,q=1:3,dq=7:9,tau=13:15", "--out", str(folder / "small.json")]) == 0
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture
def folder(bench: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Folder:
    """A fresh working folder that holds the good files."""
    for name, content in bench.items():
        (tmp_path / name).write_bytes(content)
    monkeypatch.chdir(tmp_path)
    return tmp_path


URDF = """<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 0.2"/><mass value="2"/>
    <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.002"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0 0 0.2"/><mass value="1"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.001"/></inertial></link>
  <joint name="one" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.1"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="3" effort="50"/></joint>
  <joint name="two" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0 0.4"/>
    <axis xyz="0 1 0"/><limit lower="-3" upper="3" velocity="3" effort="50"/></joint>
</robot>
"""
TABLE = """schema = "physident.dh/1"
name = "arm"
[[joints]]
d = 0.1
a = 0.0
alpha_deg = 90.0
mass = 2.0
com = [0.0, 0.0, 0.1]
inertia = [0.02, 0.0, 0.02, 0.0, 0.0, 0.002]
limits = [-3.0, 3.0]
drive = { gear_ratio = 101.0, torque_constant = 0.1, motor_inertia = 1e-5, motor_friction = [0.1, -0.1] }
capsules = [{ start = [0.0, 0.0, 0.0], end = [0.0, 0.0, 0.1], radius = 0.05 }]
[[joints]]
d = 0.0
a = 0.4
alpha_deg = 0.0
mass = 1.0
com = [0.1, 0.0, 0.0]
inertia = [0.001, 0.0, 0.01, 0.0, 0.0, 0.01]
drive = { gear_ratio = 101.0, torque_constant = 0.1, motor_inertia = 1e-5, motor_friction = [0.1, -0.1] }
"""


# ---------------------------------------------------------------------------------------------------- recordings
Recording = bytes | str | Callable[[Path], Any]


def broken(change: Callable[[np.ndarray], Any], header: str = HEADER) -> str:
    """The good table after a change in place, or the one that the change returns."""
    values = table()
    changed = change(values)
    return as_csv(values if changed is None else changed, header)


def npz(**arrays: Any) -> Callable[[Path], None]:
    values = table()
    good = {"time": values[:, 0], "q": values[:, 1:7], "dq": values[:, 7:13], "tau": values[:, 13:]}
    kept = {name: value for name, value in (good | arrays).items() if value is not None}
    return lambda path: np.savez(path, **kept)  # pyright: ignore[reportArgumentType]


def put(rows: slice | list[int], columns: Any, value: float) -> Callable[[np.ndarray], None]:
    def change(values: np.ndarray) -> None:
        values[rows, columns] = value

    return change


def scaled(columns: slice, factor: float) -> Callable[[np.ndarray], None]:
    def change(values: np.ndarray) -> None:
        values[:, columns] *= factor

    return change


def half_npz(path: Path) -> None:
    buffer = io.BytesIO()
    np.savez(buffer, time=np.arange(9.0))
    path.write_bytes(buffer.getvalue()[: len(buffer.getvalue()) // 2])


def lying_npz(path: Path) -> None:
    """An archive whose array states a shape far larger than the data that follow."""
    head = b"\x93NUMPY\x01\x00"
    text = b"{'descr': '<f8', 'fortran_order': False, 'shape': (90000000000,), }"
    text += b" " * (117 - len(text)) + b"\n"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("time.npy", head + len(text).to_bytes(2, "little") + text + b"\0" * 800)


CURRENT = HEADER.replace("tau", "current")
GOOD = as_csv(table())
RECORDINGS: dict[str, tuple[str, Recording, str]] = {
    # name of the case: file, content, what the line must say
    "empty": ("r.csv", "", "empty"),
    "header only": ("r.csv", HEADER + "\n", "no rows"),
    "one line without newline": ("r.csv", HEADER, "no rows"),
    "blank lines": ("r.csv", "\n" * 50, "comma"),
    "binary": ("r.csv", bytes(range(256)) * 40, "not a text file"),
    "latin-1 header": ("r.csv", ("zeit_µ," + GOOD).encode("latin-1"), "UTF-8"),
    "utf-16": ("r.csv", GOOD.encode("utf-16"), "UTF-16|not a text file"),
    "semicolons": ("r.csv", as_csv(table(), HEADER.replace(",", ";"), ";"), "semicolon"),
    "tabs": ("r.csv", as_csv(table(), HEADER.replace(",", "\t"), "\t"), "tab"),
    "decimal commas": ("r.csv", as_csv(table(), HEADER.replace(",", ";"), ";").replace(".", ","), "semicolon|bad"),
    "prose": ("r.csv", "Dear arm,\nplease move, then rest,\nyours\n", "time"),
    "html": ("r.csv", "<html><head>\n<title>404, not found</title>\n</html>\n", "comma"),
    "no time column": ("r.csv", GOOD.replace("time", "clock", 1), "no time column"),
    "no header": ("r.csv", as_csv(table(), ""), "no header.*--columns"),
    "no positions": ("r.csv", GOOD.replace(",q_", ",angle_"), "no joint positions"),
    "no effort": ("r.csv", GOOD.replace("tau_", "force_"), "neither tau nor current"),
    "both efforts": ("r.csv", GOOD.replace("dq_", "current_"), "both tau and current"),
    "joint numbers missing": (
        "r.csv",
        GOOD.replace("q_4", "q_7", 1).replace("dq_7", "dq_4"),
        "joints 1, 2, 3, 5, 6, 7",
    ),
    "joints from zero": ("r.csv", GOOD.replace("q_6", "q_0"), "joints 0, 1, 2"),
    "fewer efforts than positions": ("r.csv", GOOD.replace("tau_6", "extra"), "5 columns of tau and 6 of q"),
    "duplicate column": ("r.csv", GOOD.replace("q_2", "q_1", 1), "twice"),
    "duplicate time": ("r.csv", GOOD.replace("dq_6", "time"), "twice"),
    "wrong column count throughout": ("r.csv", HEADER + "\n" + "1,2,3\n" * 300, "300 of 300 rows.*3 fields"),
    "truncated lines": ("r.csv", re.sub(r"(?m)^([^\n]*?7[^\n]*),[^,\n]*$", r"\1", GOOD), "18 fields, expected 19"),
    "text cells": ("r.csv", HEADER + "\n" + ("x," * 18 + "x\n") * 300, "bad"),
    "all NaN": ("r.csv", broken(put(slice(None), slice(1, None), np.nan)), "bad"),
    "all infinite": ("r.csv", broken(put(slice(None), 3, np.inf)), "bad"),
    "clock NaN": ("r.csv", broken(put(slice(None), 0, np.nan)), "bad"),
    "over half the rows bad": ("r.csv", broken(put(slice(0, 205), 9, 1e290)), "205 of 400 rows"),
    "over half missing fields": ("r.csv", GOOD + "1,2\n" * 500, "500 of 900"),
    "under two seconds": ("r.csv", broken(lambda v: v[:150]), "1.49 s"),
    "one row": ("r.csv", broken(lambda v: v[:1]), "0 s of good rows"),
    "degrees": ("r.csv", broken(scaled(slice(1, 13), 57.3)), "4 pi.*degrees"),
    "milliseconds": ("r.csv", broken(scaled(slice(0, 1), 1000.0)), "milliseconds"),
    "microseconds": ("r.csv", broken(scaled(slice(0, 1), 1e6)), "seconds"),
    "nanosecond stamps": ("r.csv", broken(scaled(slice(0, 1), 1e9)), "seconds"),
    "clock stands": ("r.csv", broken(put(slice(None), 0, 1.0)), "clock"),
    "clock backwards": ("r.csv", broken(lambda v: v[::-1]), "clock"),
    "clock restarts": ("r.csv", broken(lambda v: np.concatenate([v[:100]] * 4)), "clock"),
    "clock in absurd steps": ("r.csv", broken(lambda v: v.__setitem__((slice(None), 0), 1e300 * v[:, 0])), "seconds"),
    "gz that is none": ("r.csv.gz", b"\x1f\x8b" + b"rubbish" * 50, "cannot be read|gzip"),
    "truncated gz": ("r.csv.gz", gzip.compress(GOOD.encode())[:-2000], "cannot be read|ended|truncated"),
    "gz with a broken body": ("r.csv.gz", lambda p: p.write_bytes(_flipped(gzip.compress(GOOD.encode()))), "gzip|read"),
    "empty gz": ("r.csv.gz", gzip.compress(b""), "empty"),
    "100,000 columns": (
        "r.csv",
        ",".join(f"c{i}" for i in range(100_000)) + "\n" + "1," * 99_999 + "1\n",
        "100000 columns",
    ),
    "a directory": ("r.csv", lambda p: p.mkdir(), "folder|not a file"),
    "a pipe": ("r.csv", os.mkfifo, "not a file|neither"),
    "unreadable": ("r.csv", lambda p: p.symlink_to("/proc/self/mem"), "cannot be read"),
    "dangling link": ("r.csv", lambda p: p.symlink_to("nowhere.csv"), "not found"),
    "unknown ending": ("r.xlsx", GOOD, "format"),
    "no ending": ("r", GOOD, "format"),
    "npz that is text": ("r.npz", GOOD, "npz"),
    "npz that is empty": ("r.npz", "", "npz"),
    "npz cut in half": ("r.npz", half_npz, "npz"),
    "npz with a lying header": ("r.npz", lying_npz, "unpacks to more"),
    "npz without time": ("r.npz", npz(time=None), "'time' is missing"),
    "npz without q": ("r.npz", npz(q=None), "no joint positions"),
    "npz pickled": ("r.npz", npz(q=np.array([{}, None] * (N // 2), dtype=object)[:, None]), "plain arrays"),
    "npz pickled time": ("r.npz", npz(time=np.array([object()] * N)), "plain arrays"),
    "npz complex": ("r.npz", npz(q=1j * table()[:, 1:7]), "complex"),
    "npz complex time": ("r.npz", npz(time=1j * table()[:, 0]), "complex"),
    "npz text": ("r.npz", npz(q=np.full((N, 6), "x")), "<U1"),
    "npz dates": ("r.npz", npz(time=np.arange(N).astype("datetime64[ms]")), "datetime64"),
    "npz one-dimensional q": ("r.npz", npz(q=table()[:, 1]), r"\(400,\)"),
    "npz q too short": ("r.npz", npz(q=table()[:50, 1:7]), r"\(50, 6\)"),
    "npz q transposed": ("r.npz", npz(q=table()[:, 1:7].T), r"\(6, 400\)"),
    "npz scalar time": ("r.npz", npz(time=np.array(1.0)), "time"),
    "npz two efforts": ("r.npz", npz(current=table()[:, 1:7]), "both tau and current"),
    "npz no joints": ("r.npz", npz(q=np.zeros((N, 0)), dq=None, tau=np.zeros((N, 0))), r"\(400, 0\)"),
    "npz no rows": ("r.npz", npz(time=np.zeros(0), q=np.zeros((0, 6)), dq=None, tau=np.zeros((0, 6))), "no rows|0 s"),
}


def _flipped(data: bytes) -> bytes:
    middle = len(data) // 2
    return data[:middle] + bytes(255 - b for b in data[middle : middle + 200]) + data[middle + 200 :]


def write(path: Path, content: Recording) -> None:
    if callable(content):
        content(path)
    else:
        path.write_bytes(content.encode() if isinstance(content, str) else content)


@pytest.mark.parametrize("case", RECORDINGS)
def test_recordings(case: str, folder: Folder, capfd: pytest.CaptureFixture) -> None:
    name, content, says = RECORDINGS[case]
    write(folder / name, content)
    fails(capfd, folder, ["inspect", name], says)
    fails(capfd, folder, ["identify", name, "--robot", "ur5", "--out", "out.json"], says)


# ---------------------------------------------------------------------------------------------------- robots
MASS = '<mass value="2"/>'
ROBOTS: dict[str, tuple[str, Recording, str]] = {
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
    "xacro": ("r.urdf", URDF.replace('value="2"', 'value="${m}"'), r"mass is \$\{m\}.*xacro"),
    "sdf": ("r.urdf", "<sdf><model name='a'/></sdf>", "root element is <sdf>"),
    "html": ("r.urdf", "<html><body>404</body></html>", "root element is <html>"),
    "floating base": ("r.urdf", URDF.replace("revolute", "floating", 1), "floating"),
    "planar": ("r.urdf", URDF.replace("revolute", "planar", 1), "planar"),
    "no type": ("r.urdf", URDF.replace('type="revolute"', "", 1), "joint 'one'"),
    "mimic": ("r.urdf", URDF.replace("</joint>", '<mimic joint="two"/></joint>', 1), "mimics"),
    "no joints": ("r.urdf", '<robot name="a"><link name="base"/></robot>', "no moving joint"),
    "only fixed joints": ("r.urdf", URDF.replace("revolute", "fixed"), "no moving joint"),
    "no links": ("r.urdf", re.sub(r"<link[^>]*/>|<link.*?[^/]>.*?</link>", "", URDF, flags=re.S), "which is no link"),
    "negative mass": ("r.urdf", URDF.replace(MASS, '<mass value="-2"/>'), "link 'upper': mass is -2"),
    "NaN mass": ("r.urdf", URDF.replace(MASS, '<mass value="nan"/>'), "mass is nan"),
    "infinite mass": ("r.urdf", URDF.replace(MASS, '<mass value="1e999"/>'), "mass is 1e999"),
    "missing mass": ("r.urdf", URDF.replace(MASS, ""), "mass is missing"),
    "empty mass": ("r.urdf", URDF.replace(MASS, "<mass/>"), "mass is missing"),
    "text inertia": ("r.urdf", URDF.replace('ixx="0.02"', 'ixx="big"'), "ixx is big"),
    "missing inertia": ("r.urdf", URDF.replace('izz="0.002"', ""), "izz is missing"),
    "wrong origin": ("r.urdf", URDF.replace('xyz="0 0 0.2"', 'xyz="0 0"'), "three finite numbers"),
    "NaN origin": ("r.urdf", URDF.replace('xyz="0 0 0.4"', 'xyz="0 nan 0"'), "three finite numbers"),
    "comma origin": ("r.urdf", URDF.replace('xyz="0 0 0.4"', 'xyz="0,0,0.4"'), "three finite numbers"),
    "zero axis": ("r.urdf", URDF.replace('axis xyz="0 1 0"', 'axis xyz="0 0 0"'), "axis is zero"),
    "text limit": ("r.urdf", URDF.replace('lower="-3"', 'lower="low"', 1), "lower"),
    "NaN limit": ("r.urdf", URDF.replace('upper="3"', 'upper="nan"', 1), "upper"),
    "crossed limits": ("r.urdf", URDF.replace('lower="-3" upper="3"', 'lower="3" upper="-3"', 1), "lower.*upper"),
    "negative velocity limit": ("r.urdf", URDF.replace('velocity="3"', 'velocity="-3"', 1), "velocity"),
    "joint without parent": ("r.urdf", URDF.replace('<parent link="upper"/>', ""), "joint 'two'.*parent"),
    "unknown parent": ("r.urdf", URDF.replace('parent link="upper"', 'parent link="nobody"'), "nobody"),
    "unknown child": ("r.urdf", URDF.replace('child link="lower"', 'child link="nobody"'), "nobody"),
    "duplicate joints": ("r.urdf", URDF.replace('name="two"', 'name="one"'), "joint 'one'.*twice"),
    "duplicate links": ("r.urdf", URDF.replace('link name="lower"', 'link name="upper"'), "link 'upper'.*twice"),
    "nameless joint": ("r.urdf", URDF.replace(' name="two"', ""), "name"),
    "nameless link": ("r.urdf", URDF.replace('<link name="base"/>', "<link/>"), "name"),
    "two roots": ("r.urdf", URDF.replace("</robot>", '<link name="island"/></robot>'), "root|base.*island"),
    "two parents": ("r.urdf", URDF.replace('child link="lower"', 'child link="upper"'), "upper"),
    "a loop": ("r.urdf", URDF.replace('parent link="base"', 'parent link="lower"'), "loop|root"),
    "a joint to itself": ("r.urdf", URDF.replace('parent link="upper"', 'parent link="lower"'), "lower"),
    "joint count": ("r.urdf", URDF, "6 joints, but robot arm has 2"),
    "not found": ("r.urdf", lambda p: None, "not found"),
    "a folder": ("r.urdf", lambda p: p.mkdir(), "not found|folder"),
    "unreadable": ("r.urdf", lambda p: p.symlink_to("/proc/self/mem"), "cannot be read"),
    "huge": ("r.urdf", lambda p: os.truncate(os.open(p, os.O_CREAT | os.O_WRONLY), 1 << 40), "bytes"),
    "unknown name": ("ur6", lambda p: None, "'ur6' not found"),
    "unknown ending": ("r.txt", TABLE, "malformed XML|.toml"),
    "toml empty": ("r.toml", "", "schema is None"),
    "toml malformed": ("r.toml", "joints = [", "not valid TOML"),
    "toml deep": ("r.toml", "a = " + "[" * 100_000, "not valid TOML"),
    "toml of another schema": ("r.toml", TABLE.replace("dh/1", "dh/9"), "physident.dh/9"),
    "toml without joints": ("r.toml", TABLE.split("[[joints]]")[0], r"no \[\[joints\]\]"),
    "toml joints a number": ("r.toml", TABLE.split("[[joints]]")[0] + "joints = 3", r"no \[\[joints\]\]"),
    "toml text length": ("r.toml", TABLE.replace("d = 0.1", 'd = "0.1"'), "joint 1: d is '0.1'"),
    "toml text com": ("r.toml", TABLE.replace("com = [0.1,", 'com = ["x",'), "joint 2: com"),
    "toml ragged com": ("r.toml", TABLE.replace("com = [0.1,", "com = [[0.1],"), "joint 2: com"),
    "toml missing length": ("r.toml", TABLE.replace("a = 0.4\n", ""), "joint 2: a is None|missing"),
    "toml boolean mass": ("r.toml", TABLE.replace("mass = 2.0", "mass = true"), "joint 1: mass"),
    "toml negative mass": ("r.toml", TABLE.replace("mass = 2.0", "mass = -2.0"), "mass is -2"),
    "toml NaN mass": ("r.toml", TABLE.replace("mass = 2.0", "mass = nan"), "joint 1: mass is nan"),
    "toml inertia without mass": ("r.toml", TABLE.replace("mass = 2.0\n", ""), "joint 1: .*mass"),
    "toml short inertia": (
        "r.toml",
        TABLE.replace("inertia = [0.001, 0.0, ", "inertia = [0.001, "),
        "joint 2: inertia",
    ),
    "toml unknown key": ("r.toml", TABLE.replace("alpha_deg = 90.0", "alpha = 1.57\nalpha_deg = 90.0"), "'alpha'"),
    "toml unknown top key": ("r.toml", TABLE.replace("name =", "nmae ="), "'nmae'"),
    "toml unknown kind": ("r.toml", TABLE.replace("a = 0.4", 'a = 0.4\nkind = "spherical"'), "spherical"),
    "toml kind a number": ("r.toml", TABLE.replace("a = 0.4", "a = 0.4\nkind = 3"), "kind is 3"),
    "toml name a number": ("r.toml", TABLE.replace("a = 0.4", "a = 0.4\nname = 3"), "name is 3"),
    "toml robot name a list": ("r.toml", TABLE.replace('name = "arm"', "name = [1]"), "name is"),
    "toml duplicate joint names": ("r.toml", TABLE.replace("d = 0", 'name = "same"\nd = 0'), "'same'.*twice"),
    "toml one limit": ("r.toml", TABLE.replace("limits = [-3.0, 3.0]", "limits = [3.0]"), "joint 1: limits"),
    "toml text limits": ("r.toml", TABLE.replace("limits = [-3.0, 3.0]", 'limits = ["a", "b"]'), "joint 1: limits"),
    "toml crossed limits": (
        "r.toml",
        TABLE.replace("limits = [-3.0, 3.0]", "limits = [3.0, -3.0]"),
        "lower.*upper|limits",
    ),
    "toml limits no list": ("r.toml", TABLE.replace("limits = [-3.0, 3.0]", "limits = 3.0"), "joint 1: limits"),
    "toml text velocity": ("r.toml", TABLE.replace("a = 0.4", 'a = 0.4\nvelocity_limit = "fast"'), "velocity_limit"),
    "toml negative acceleration": (
        "r.toml",
        TABLE.replace("a = 0.4", "a = 0.4\nacceleration_limit = -1.0"),
        "acceleration",
    ),
    "toml calibration a number": ("r.toml", TABLE.replace("a = 0.4", "a = 0.4\ncalibration = 1"), "calibration"),
    "toml calibration text": ("r.toml", TABLE.replace("a = 0.4", 'a = 0.4\ncalibration = {d = "x"}'), "calibration"),
    "toml calibration unknown": ("r.toml", TABLE.replace("a = 0.4", "a = 0.4\ncalibration = {delta = 1.0}"), "delta"),
    "toml drive lacks an entry": ("r.toml", TABLE.replace("gear_ratio = 101.0, ", "", 1), "gear_ratio"),
    "toml drive text": ("r.toml", TABLE.replace("gear_ratio = 101.0", 'gear_ratio = "101"', 1), "gear_ratio"),
    "toml drive zero gear": ("r.toml", TABLE.replace("gear_ratio = 101.0", "gear_ratio = 0.0", 1), "gear_ratio"),
    "toml drive a number": ("r.toml", re.sub(r"drive = \{.*?\}", "drive = 5", TABLE, count=1), "joint 1: drive"),
    "toml drive one friction": ("r.toml", TABLE.replace("[0.1, -0.1]", "[0.1]", 1), "motor_friction"),
    "toml drive unknown entry": ("r.toml", TABLE.replace("gear_ratio", "ratio = 1.0, gear_ratio", 1), "'ratio'"),
    "toml some drives": ("r.toml", re.sub(r"drive = \{.*?\}", "", TABLE, count=1), "joint 1.*drive"),
    "toml capsule of zero length": (
        "r.toml",
        TABLE.replace("end = [0.0, 0.0, 0.1]", "end = [0.0, 0.0, 0.0]"),
        "capsule",
    ),
    "toml capsule without radius": ("r.toml", TABLE.replace(", radius = 0.05", ""), "capsule.*radius"),
    "toml capsule negative radius": ("r.toml", TABLE.replace("radius = 0.05", "radius = -0.05"), "radius"),
    "toml capsule text": ("r.toml", TABLE.replace("radius = 0.05", 'radius = "fat"'), "radius"),
    "toml capsule short point": ("r.toml", TABLE.replace("end = [0.0, 0.0, 0.1]", "end = [0.0, 0.1]"), "end"),
    "toml capsules a number": ("r.toml", re.sub(r"capsules = .*", "capsules = 3", TABLE), "capsules"),
    "toml base a number": ("r.toml", TABLE.replace("[[joints]]", "base = 1\n[[joints]]", 1), "base"),
    "toml gravity short": ("r.toml", TABLE.replace("[[joints]]", "gravity = [0.0, -9.81]\n[[joints]]", 1), "gravity"),
    "toml gravity text": ("r.toml", TABLE.replace("[[joints]]", 'gravity = "down"\n[[joints]]', 1), "gravity"),
    "toml gravity NaN": ("r.toml", TABLE.replace("[[joints]]", "gravity = [0.0, 0.0, nan]\n[[joints]]", 1), "gravity"),
    "toml text tool speed": (
        "r.toml",
        TABLE.replace("[[joints]]", 'tool_speed_limit = "1"\n[[joints]]', 1),
        "tool_speed",
    ),
}


@pytest.mark.parametrize("case", ROBOTS)
def test_robots(case: str, folder: Folder, capfd: pytest.CaptureFixture) -> None:
    name, content, says = ROBOTS[case]
    write(folder / name, content)
    if case != "joint count":
        fails(capfd, folder, ["base-parameters", "--robot", name], says)
    fails(capfd, folder, ["identify", "good.csv", "--robot", name, "--out", "out.json"], says)


# ---------------------------------------------------------------------------------------------------- models
def with_value(*keys: str | int, value: Any) -> Callable[[dict], Any]:
    def change(model: dict) -> None:
        at: Any = model
        for key in keys[:-1]:
            at = at[key]
        at[keys[-1]] = value

    return change


def without(*keys: str | int) -> Callable[[dict], Any]:
    def change(model: dict) -> None:
        at: Any = model
        for key in keys[:-1]:
            at = at[key]
        del at[keys[-1]]

    return change


SHAPE = {"effect": "warm_up", "joint": 1, "field": "time_constant", "value": 9.0, "std": 1.0, "unit": "s"}
MODELS: dict[str, tuple[bytes | str | Callable[[dict], Any], str]] = {
    "empty": ("", "not valid JSON"),
    "not JSON": ("model: 1\n", "not valid JSON"),
    "binary": (bytes(range(256)), "not UTF-8 text"),
    "huge nesting": ("[" * 200_000, "not valid JSON"),
    "long integer": ('{"schema": ' + "9" * 10_000 + "}", "not valid JSON|schema"),
    "a list": ("[1, 2]", "schema is 'list'"),
    "a number": ("3", "schema is 'int'"),
    "another schema": (with_value("schema", value="physident.model/99"), "physident.model/99"),
    "no robot": (without("robot"), "robot"),
    "robot a list": (with_value("robot", value=[]), "not a complete model"),
    "robot unknown key": (with_value("robot", "legs", value=2), "legs"),
    "robot urdf a number": (with_value("robot", "urdf", value=3), "not a complete model"),
    "robot urdf malformed": (with_value("robot", "urdf", value="<robot"), "malformed XML"),
    "robot of fewer joints": (with_value("robot", "urdf", value=URDF), "expected|drives"),
    "robot gravity text": (with_value("robot", "gravity", value="abc"), "gravity"),
    "robot gravity short": (with_value("robot", "gravity", value=[0, 0]), "gravity"),
    "drives short": (with_value("robot", "drives", value=[]), "drives"),
    "drive text": (with_value("robot", "drives", 0, "gear_ratio", value="x"), "gear_ratio"),
    "acceleration limit short": (with_value("robot", "acceleration_limit", value=[1.0]), "acceleration_limit"),
    "effects none": (with_value("effects", value=[]), "effect"),
    "effects a number": (with_value("effects", value=3), "not a complete model"),
    "effect unknown": (with_value("effects", 1, value={"effect": "magic"}), "'magic' is unknown"),
    "effect not a table": (with_value("effects", 1, value="rotor_inertia"), "not a complete model"),
    "effect unhashable": (with_value("effects", 1, value={"effect": ["x"]}), "effect"),
    "effect twice": (lambda m: m["effects"].append(m["effects"][0]), "twice|expected"),
    "effect unknown setting": (with_value("effects", 1, "colour", value="red"), "colour"),
    "effect joint beyond": (with_value("effects", 1, "joints", value=[9]), "joint 9"),
    "effect joints text": (with_value("effects", 1, "joints", value="x"), "not a complete model"),
    "effect smoothing zero": (with_value("effects", 3, "smoothing", value=0), "smoothing"),
    "effect smoothing text": (with_value("effects", 3, "smoothing", value="x"), "smoothing|complete"),
    "parameters missing": (without("parameters"), "parameters"),
    "parameters short": (without("parameters", 3), "expected"),
    "parameter renamed": (with_value("parameters", 3, "name", value="banana"), "banana"),
    "parameter NaN": (with_value("parameters", 3, "value", value=float("nan")), "finite"),
    "parameter text": (with_value("parameters", 3, "value", value="x"), "x"),
    "parameter null": (with_value("parameters", 3, "value", value=None), "finite|float"),
    "covariance smaller": (with_value("covariance", value=[[1.0]]), "covariance"),
    "covariance ragged": (lambda m: m["covariance"][0].pop(), "not a complete model"),
    "covariance NaN": (with_value("covariance", 0, 0, value=float("nan")), "covariance"),
    "covariance negative": (with_value("covariance", 0, 0, value=-1.0), "covariance"),
    "sigma short": (without("sigma", 0), "sigma"),
    "sigma negative": (with_value("sigma", 0, value=-1.0), "sigma"),
    "sigma text": (with_value("sigma", 0, value="x"), "not a complete model"),
    "relative short": (without("relative_percent", 0), "relative"),
    "effective samples short": (without("effective_samples", 0), "effective"),
    "certificate empty": (with_value("certificate", value={}), "not a complete model"),
    "filter empty": (with_value("filter", value={"cut": 1}), "cut"),
    "filter negative": (with_value("filter", "cutoff", value=-5.0), "cutoff is -5"),
    "filter text": (with_value("filter", "cutoff", value="x"), "filter|cutoff|not a complete model"),
    "recordings a number": (with_value("recordings", value=3), "recordings is 3, expected a list"),
    "recording without hash": (without("recordings", 0, "sha256"), "sha256"),
    "columns a number": (with_value("columns", value=3), "columns"),
    "columns rubbish": (with_value("columns", value="banana"), "banana"),
    "gains short": (with_value("drive_gains", value=[1.0]), "drive.gains"),
    "gains text": (with_value("drive_gains", value="abcdef"), "drive.gains"),
    "base_shares text": (with_value("base_shares", value="x"), "base_shares is 'x', expected a list"),
    "base_shares short": (with_value("base_shares", value=[1.0]), "base_shares holds 1 numbers, expected 58"),
    "shares text": (with_value("shares", value=["x"]), r"shares\[0\] is 'x'"),
    "shares beyond": (with_value("shares", value=[1.5]), r"shares\[0\] is 1.5, expected 0 to 1"),
    "shares without a prior": (with_value("shares", value=[0.5]), "ols, which has no prior"),
    "prior weight of no prior": (with_value("prior_weight", value=1.0), "ols, which has no prior"),
    "prior weight text": (with_value("prior_weight", value="x"), "prior_weight is 'x'"),
    "prior weight a list": (with_value("prior_weight", value=[1]), r"prior_weight is \[1\]"),
    "held numbers": (with_value("held", value=[3]), r"held\[0\] is 3, expected a text"),
    "held text": (with_value("held", value="abc"), "held is 'abc', expected a list"),
    "blocks negative": (with_value("blocks", value=-1), "blocks is -1, expected a whole number"),
    "blocks a fraction": (with_value("blocks", value=2.5), "blocks is 2.5"),
    "certificate text": (with_value("certificate", "stationarity", value="x"), "certificate.stationarity is 'x'"),
    "certificate eigenvalue null": (
        with_value("certificate", "eigenvalues", value=[None]),
        r"eigenvalues\[0\] is None",
    ),
    "recording time text": (with_value("recordings", 0, "used", value="x"), r"recordings\[0\].used is 'x'"),
    "recording hash a number": (with_value("recordings", 0, "sha256", value=3), r"recordings\[0\].sha256 is 3"),
    "shape of no effect": (with_value("shapes", value=[SHAPE]), "no time_constant of warm_up on joint 1"),
    "shape text": (with_value("shapes", value=[SHAPE | {"std": "x"}]), r"shapes\[0\].std is 'x'"),
    "gains zero": (with_value("drive_gains", value=[0, 1, 1, 1, 1, 1]), "drive.gains"),
}


@pytest.mark.parametrize("case", MODELS)
def test_models(case: str, folder: Folder, capfd: pytest.CaptureFixture) -> None:
    content, says = MODELS[case]
    if callable(content):
        model = json.loads((folder / "model.json").read_text())
        content(model)
        content = json.dumps(model)
    write(folder / "bad.json", content)
    fails(capfd, folder, ["validate", "other.csv", "--model", "bad.json", "--json", "out.json"], says)


# ---------------------------------------------------------------------------------------------------- options
IDENTIFY = ["identify", "good.csv", "--robot", "ur5"]
TO = [*IDENTIFY, "--out", "out.json"]
VALIDATE = ["validate", "other.csv", "--model", "model.json"]
COMPARE = ["compare", "--model", "model.json", "--model", "model.json", "--on", "other.csv"]
OPTIONS: dict[str, tuple[list[str], str]] = {
    "unknown verb": (["improve"], "improve"),
    "unknown option": ([*TO, "--magic"], "--magic"),
    "option without value": ([*IDENTIFY, "--out"], "--out"),
    "no recordings": (["inspect"], "REC"),
    "recording not found": (["inspect", "nowhere.csv"], "not found"),
    "pattern without match": (["inspect", "nothing*.csv"], "not found"),
    "empty recording name": (["inspect", ""], "''"),
    "endless recording name": (["inspect", "x" * 5000 + ".csv"], "not found|too long"),
    "zero byte in a name": (["inspect", "a\0b.csv"], "not found|byte"),
    "no robot": (["identify", "good.csv", "--out", "out.json"], "no robot given"),
    "empty robot": (["identify", "good.csv", "--out", "out.json", "--robot", ""], "robot ''|no robot"),
    "robot with a zero byte": (["base-parameters", "--robot", "a\0b"], "not found"),
    "endless robot name": (["base-parameters", "--robot", "x" * 5000], "not found|too long"),
    "no out": (IDENTIFY, "--out"),
    "unknown effect": ([*TO, "--effects", "magic"], "'magic' is unknown"),
    "duplicated effects": ([*TO, "--effects", "rigid_body,rigid_body"], "twice"),
    "no effects": ([*TO, "--effects", ","], "no effects"),
    "empty effects": ([*TO, "--effects", ""], "no effects"),
    "effects without robot": (["inspect", "good.csv", "--effects", "rigid_body"], "needs a robot"),
    "base-parameters unknown effect": (["base-parameters", "--robot", "ur5", "--effects", "x"], "'x' is unknown"),
    "unknown method": ([*TO, "--method", "magic"], "'magic' is unknown"),
    "negative cutoff": ([*TO, "--cutoff", "-1"], "cutoff is -1"),
    "zero cutoff": ([*TO, "--cutoff", "0"], "cutoff is 0"),
    "NaN cutoff": ([*TO, "--cutoff", "nan"], "cutoff is nan"),
    "infinite cutoff": ([*TO, "--cutoff", "inf"], "cutoff is inf"),
    "text cutoff": ([*TO, "--cutoff", "fast"], "--cutoff.*number"),
    "cutoff too high": ([*TO, "--cutoff", "45"], "too high for data at 100 Hz"),
    "cutoff too low": ([*TO, "--cutoff", "0.01"], "filter"),
    "cutoff of no size": ([*TO, "--cutoff", "1e-300"], "filter|cutoff"),
    "validate cutoff too high": ([*VALIDATE, "--cutoff", "45"], "too high"),
    "validate NaN cutoff": ([*VALIDATE, "--cutoff", "nan"], "cutoff is nan"),
    "compare negative cutoff": ([*COMPARE, "--cutoff", "-3"], "cutoff is -3"),
    "inspect negative cutoff": (
        ["inspect", "good.csv", "--robot", "ur5", "--effects", "rigid_body", "--cutoff=-3"],
        "-3",
    ),
    "inspect cutoff alone": (["inspect", "good.csv", "--cutoff", "-3"], "cutoff is -3"),
    "too few gains": ([*TO, "--drive-gains", "1 2"], "2 drive gains, expected 6"),
    "zero gain": ([*TO, "--drive-gains", "1 1 1 1 1 0"], "other than zero"),
    "text gains": ([*TO, "--drive-gains", "a b"], "'a b'"),
    "NaN gain": ([*TO, "--drive-gains", "1 1 1 1 1 nan"], "finite"),
    "empty gains": ([*TO, "--drive-gains", " "], "--drive-gains"),
    "no gains at all": ([*TO, "--drive-gains", ""], "--drive-gains"),
    "gains for torques": ([*TO, "--drive-gains", "1 1 1 1 1 1"], "torque"),
    "columns out of range": ([*TO, "--columns", "time=0,q=1:7,tau=30:36"], "19 columns"),
    "columns overlap": ([*TO, "--columns", "time=0,q=1:7,tau=6:12"], "column 6"),
    "columns reversed": ([*TO, "--columns", "time=0,q=7:1,tau=13:19"], "7:1"),
    "columns empty range": ([*TO, "--columns", "time=0,q=1:1,tau=13:19"], "1:1"),
    "columns rubbish": ([*TO, "--columns", "hello"], "'hello'"),
    "columns empty": ([*TO, "--columns", ""], "columns"),
    "columns unknown channel": ([*TO, "--columns", "time=0,q=1:7,torque=13:19"], "torque"),
    "columns negative": ([*TO, "--columns", "time=-1,q=1:7,tau=13:19"], "time=-1"),
    "columns twice": ([*TO, "--columns", "time=0,q=1:7,q=1:7,tau=13:19"], "twice"),
    "columns without time": ([*TO, "--columns", "q=1:7,tau=13:19"], "no time"),
    "columns of a million": ([*TO, "--columns", "time=0,q=1:900000,tau=1:900000"], "column|19"),
    "columns other digits": ([*TO, "--columns", "time=٠,q=1:7,tau=13:19"], "time=٠"),
    "out in a missing folder": ([*IDENTIFY, "--out", "nowhere/out.json"], "folder that does not exist"),
    "out is a folder": ([*IDENTIFY, "--out", "."], "is a folder"),
    "out is empty": ([*IDENTIFY, "--out", ""], "folder|--out"),
    "out in a place that takes none": ([*IDENTIFY, "--out", "/proc/out.json"], "cannot be written"),
    "out below a file": ([*IDENTIFY, "--out", "good.csv/out.json"], "folder"),
    "out with an endless name": ([*IDENTIFY, "--out", "x" * 5000], "cannot be written|too long"),
    "out over its recording": ([*IDENTIFY, "--out", "good.csv"], "good.csv.*another"),
    "out over its robot": (["identify", "good.csv", "--robot", "arm.urdf", "--out", "./arm.urdf"], "arm.urdf.*another"),
    "plot of unknown ending": ([*VALIDATE, "--plot", "figure.gif"], "ending"),
    "plot of unknown ending after JSON": ([*VALIDATE, "--plot", "figure.gif", "--json", "out.json"], "ending"),
    "plot without ending": (["inspect", "good.csv", "--plot", "figure"], "ending"),
    "plot in a missing folder": (["inspect", "good.csv", "--plot", "nowhere/f.png"], "folder"),
    "plot in a missing folder after JSON": ([*VALIDATE, "--plot", "no/f.png", "--json", "out.json"], "folder"),
    "json over the model": ([*VALIDATE, "--json", "model.json"], "model.json.*another"),
    "json over the recording": ([*VALIDATE, "--json", "other.csv"], "other.csv.*another"),
    "json in a missing folder": ([*VALIDATE, "--json", "no/out.json"], "folder"),
    "compare json over the model": ([*COMPARE, "--json", "model.json"], "model.json.*another"),
    "model not found": (["validate", "other.csv", "--model", "nowhere.json"], "nowhere.json"),
    "model is a folder": (["validate", "other.csv", "--model", "."], "directory"),
    "model is the recording": (["validate", "other.csv", "--model", "other.csv"], "JSON"),
    "fitted recording": (["validate", "good.csv", "--model", "model.json"], "fitted by this model"),
    "one model": (["compare", "--model", "model.json", "--on", "other.csv"], "1 models given, expected two"),
    "nothing to compare on": (["compare", "--model", "model.json", "--model", "model.json"], "--on"),
    "compare on a fitted one": ([*COMPARE[:-1], "good.csv"], "fitted"),
    "diagnose no effects": (["diagnose", "good.csv", "--robot", "ur5", "--effects", ","], "--effects is ','"),
    "demo in a file": (["demo", "--folder", "good.csv"], "good.csv"),
    "demo below a file": (["demo", "--folder", "good.csv/demo"], "good.csv"),
    "demo in a place that takes none": (["demo", "--folder", "/proc/demo"], "/proc/demo"),
    "negative seed": (["demo", "--seed", "-1"], "seed"),
    "text seed": (["demo", "--seed", "x"], "seed"),
}


@pytest.mark.parametrize("case", OPTIONS)
def test_options(case: str, folder: Folder, capfd: pytest.CaptureFixture) -> None:
    arguments, says = OPTIONS[case]
    fails(capfd, folder, arguments, says)


def test_currents_need_gains(folder: Folder, capfd: pytest.CaptureFixture) -> None:
    (folder / "currents.csv").write_text(as_csv(table(), CURRENT))
    fails(capfd, folder, ["identify", "currents.csv", "--robot", "ur5", "--out", "out.json"], "no drive gains")
    assert run(["inspect", "currents.csv"]) == 0


def test_joint_counts_must_agree(folder: Folder, capfd: pytest.CaptureFixture) -> None:
    three = as_csv(table()[:, [0, 1, 2, 3, 13, 14, 15]], "time,q_1,q_2,q_3,tau_1,tau_2,tau_3")
    (folder / "three.csv").write_text(three)
    says = "3 joints, but robot ur5 has 6"
    fails(capfd, folder, ["identify", "three.csv", "--robot", "ur5", "--out", "out.json"], says)
    fails(capfd, folder, ["validate", "three.csv", "--model", "model.json"], says)


def test_static_poses_load_but_cannot_be_identified(folder: Folder, capfd: pytest.CaptureFixture) -> None:
    (folder / "still.csv").write_text(broken(lambda v: v.__setitem__((slice(None), slice(1, 13)), 0.0)))
    assert run(["inspect", "still.csv"]) == 0
    assert "no joint moves" in capfd.readouterr().out
    fails(capfd, folder, ["identify", "still.csv", "--robot", "ur5", "--out", "out.json"], "no joint moves")


def fails(capfd: pytest.CaptureFixture, folder: Path, arguments: list[str], says: str) -> None:
    """The command fails with one line on standard error that matches, and leaves the folder as it was."""
    before = contents(folder)
    capfd.readouterr()
    code = run(arguments)
    out, err = capfd.readouterr()  # of the file descriptors: what C++ libraries print is seen too
    assert_one_line(code, out, err, says)
    assert contents(folder) == before


def assert_one_line(code: int, out: str, err: str, says: str) -> None:
    assert code == 2, err
    assert err.startswith("physident: error: "), err
    assert err.count("\n") == 1, err
    assert out == ""
    assert re.search(says, err), err
    assert len(err) < 1000, "the line does not fit a screen"


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() and path.stat().st_size < 1e8 else b""
        for path in folder.rglob("*")
        if not path.is_symlink()
    }


# ---------------------------------------------------------------------------------------------------- bombs
def gz_bomb(path: Path) -> None:
    """A hundred million empty cells in a hundred kilobytes."""
    many = (b"," * 999 + b"\n") * 10_000
    head = ",".join(f"c{i}" for i in range(1000)).encode() + b"\n"
    path.write_bytes(gzip.compress(head) + 11 * gzip.compress(many))


def gz_broken_rows(path: Path) -> None:
    """Fifty million rows, each of which would be named."""
    path.write_bytes(gzip.compress(GOOD.encode()) + 100 * gzip.compress(b"1,2\n" * 500_000))


def gz_line(path: Path) -> None:
    """A first line of one gigabyte, without an end."""
    path.write_bytes(64 * gzip.compress(b"1," * (8 << 20), 1))


def second_line(path: Path) -> None:
    """A good first line, and then one of a gigabyte."""
    path.write_bytes(gzip.compress(HEADER.encode() + b"\n") + 64 * gzip.compress(b"1," * (8 << 20), 1))


def zip_bomb(path: Path) -> None:
    """An array of 110,000,000 numbers in under a megabyte."""
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open("time.npy", "w", force_zip64=True) as stream,
    ):
        head = {"descr": "<f8", "fortran_order": False, "shape": (110_000_000,)}
        np.lib.format.write_array_header_1_0(stream, head)
        for _ in range(110):
            stream.write(bytes(8_000_000))


def sparse(path: Path) -> None:
    """Eight gigabytes of zeros that take no room on the disk."""
    with path.open("wb") as stream:
        stream.truncate(8 << 30)


BOMBS: dict[str, tuple[str, Callable[[Path], Any], str]] = {
    "gz bomb": ("r.csv.gz", gz_bomb, "more than 100000000 numbers|too large"),
    "gz bomb of broken rows": ("r.csv.gz", gz_broken_rows, "over 100000 rows"),
    "one line of a gigabyte": ("r.csv.gz", gz_line, "first line is longer"),
    "second line of a gigabyte": ("r.csv.gz", second_line, "a line is longer"),
    "zip bomb": ("r.npz", zip_bomb, "unpacks to more"),
    "huge file of zeros": ("r.csv", sparse, "not a text file"),
    "huge model": ("m.json", sparse, "bytes"),
    "huge table": ("r.toml", sparse, "bytes"),
}


@pytest.mark.parametrize("case", BOMBS)
def test_bombs_in_bounded_memory(case: str, folder: Folder) -> None:
    name, make, says = BOMBS[case]
    make(folder / name)
    arguments = {
        ".json": ["validate", "other.csv", "--model", name],
        ".toml": ["base-parameters", "--robot", name],
    }.get(Path(name).suffix, ["inspect", name])
    done = command(arguments, folder)
    assert_one_line(done.returncode, done.stdout, done.stderr, says)


def test_no_traceback_from_the_installed_command(folder: Folder) -> None:
    done = command(["identify", "nowhere.csv", "--robot", "ur5", "--out", "out.json"], folder)
    assert_one_line(done.returncode, done.stdout, done.stderr, "not found")


def command(arguments: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """The command line in a process of its own, with bounded address space and one thread."""
    code = (
        f"import resource; resource.setrlimit(resource.RLIMIT_AS, ({MEMORY}, {MEMORY}));"
        " from physident.cli import main; main()"
    )
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=folder, env=os.environ | threads, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip


def damaged(content: bytes, rng: np.random.Generator) -> bytes:
    """The content with a stretch of it overwritten, cut out, doubled or cut off."""
    a, b = np.sort(rng.integers(0, len(content), 2))
    b = min(b, a + int(rng.integers(1, 40)))
    kind = rng.integers(4)
    middle = (rng.bytes(b - a), b"", 2 * content[a:b], b"")[kind]
    return content[:a] + middle + (b"" if kind == 3 else content[b:])


@pytest.mark.filterwarnings("ignore::physident.PhysidentWarning", "error::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("name", ["good.csv", "good.csv.gz", "good.npz", "arm.urdf", "arm.toml", "small.json"])
def test_damaged_files_load_or_say_why(name: str, folder: Folder) -> None:
    (folder / "good.csv.gz").write_bytes(gzip.compress(GOOD.encode()))
    npz()(folder / "good.npz")
    rng = np.random.default_rng(0)
    content = (folder / name).read_bytes()
    load = {".urdf": pid.load_robot, ".toml": pid.load_robot, ".json": pid.load_estimate}.get(
        Path(name).suffix, pid.load_recording
    )
    refused = []
    for _ in range(60):
        (folder / name).write_bytes(damaged(content, rng))
        try:
            load(folder / name)
        except pid.InputError as error:
            refused.append(str(error))
    assert refused
    assert all(len(line.splitlines()) == 1 for line in refused)


def leaves(value: Any, path: tuple = ()) -> Iterator[tuple]:
    """Paths of every entry of nested JSON, of lists only the first."""
    if path:
        yield path
    entries = (
        value.items() if isinstance(value, dict) else list(enumerate(value))[:1] if isinstance(value, list) else ()
    )
    for key, one in entries:
        yield from leaves(one, (*path, key))


@pytest.mark.parametrize("method", ["ols", "physical"])
def test_a_model_with_any_entry_replaced_loads_or_says_why(method: str, folder: Folder) -> None:
    if method == "physical":
        fit = ["identify", "good.csv", "--robot", "arm.toml", "--method", "physical", "--effects", "rigid_body"]
        assert run([*fit, "--columns", "time=0,q=1:3,dq=7:9,tau=13:15", "--out", "small.json"]) == 0
    model = json.loads((folder / "small.json").read_text())
    values = itertools.cycle((None, [], {}, "x", -1, 1e308, [[1]]))  # seven: prime to most steps of the walk
    for path, value in itertools.chain(
        zip(leaves(model), values, strict=False), zip(leaves(model), values, strict=False)
    ):
        text = json.loads(json.dumps(model))
        with_value(*path, value=value)(text)
        (folder / "bad.json").write_text(json.dumps(text))
        with contextlib.suppress(pid.InputError):
            repr(pid.load_estimate(folder / "bad.json"))


def test_the_unbroken_files_pass(folder: Folder, capfd: pytest.CaptureFixture) -> None:
    """What every case breaks is good before: each failure above is of its own making."""
    assert run(["inspect", "good.csv", "other.csv", "--robot", "ur5", "--effects", "rigid_body"]) == 0
    assert run([*VALIDATE, "--json", "score.json", "--plot", "figure.png"]) == 0
    assert run(COMPARE) == 0
    for robot in ("arm.urdf", "arm.toml"):
        assert run(["base-parameters", "--robot", robot]) == 0
    said = [line for line in capfd.readouterr().err.splitlines() if line and "near a singularity" not in line]
    assert said == []  # this motion does pass near one
