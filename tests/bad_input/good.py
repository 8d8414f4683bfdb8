"""Good input, so that each case of bad input breaks one thing: a recording of six joints, a URDF, a DH table."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

Content = bytes | str | Callable[[Path], Any]

N, STEP = 400, 0.01  # rows, s
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


def npz(**arrays: Any) -> Callable[[Path], None]:
    values = table()
    good = {"time": values[:, 0], "q": values[:, 1:7], "dq": values[:, 7:13], "tau": values[:, 13:]}
    kept = {name: value for name, value in (good | arrays).items() if value is not None}
    return lambda path: np.savez(path, **kept)  # pyright: ignore[reportArgumentType]


def write(path: Path, content: Content) -> None:
    if callable(content):
        content(path)
    else:
        path.write_bytes(content.encode() if isinstance(content, str) else content)


CURRENT = HEADER.replace("tau", "current")
GOOD = as_csv(table())
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
