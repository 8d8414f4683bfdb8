"""The thesis' two half robots - base, shoulder, elbow (BSE) and wrist (W) - and link parameters in its DH frames."""

from __future__ import annotations

from functools import cache
from importlib import resources

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.robots.dh import urdf_from_table
from physident.robots.dh_table import parse_table

Array = NDArray[np.float64]
HALVES = {"bse": slice(0, 3), "w": slice(3, 6)}
PER_LINK = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")


def ur5_table() -> dict:
    """The built-in UR5's DH table."""
    text = resources.files("physident").joinpath("robots", "ur5.toml").read_text(encoding="utf-8")
    return parse_table(text, "ur5.toml")


@cache
def half(name: str) -> pid.Robot:
    """A 3-joint robot of the first ("bse") or last ("w") three DH rows, its base at rest.

    Gravity is (0, 0, -9.81) in its base frame, as the thesis has it: for W that is along the axis of joint 4, whatever
    the arm in front of it does.
    """
    table = ur5_table()
    joints = table["joints"][HALVES[name]]
    limit = tuple(joint["acceleration_limit"] for joint in joints)
    return pid.Robot(name=name, urdf=urdf_from_table(table | {"joints": joints}), acceleration_limit=limit)


def pseudo_inertia(link: Array) -> Array:
    """Pseudo-inertia (4, 4) of link parameters (10,) in Pinocchio's order."""
    m, x, y, z, xx, xy, yy, xz, yz, zz = link
    total = (xx + yy + zz) / 2
    return np.array([[total - xx, -xy, -xz, x], [-xy, total - yy, -yz, y], [-xz, -yz, total - zz, z], [x, y, z, m]])


def from_dh_frames(name: str) -> Array:
    """T (30, 30): link parameters in joint frames of those in DH frames, theta = T theta_dh.

    A link's DH frame sits at its far end, Tz(d) Tx(a) Rx(alpha) from its joint; moments are about the frame's origin.
    """
    T = np.zeros((30, 30))
    for i, joint in enumerate(ur5_table()["joints"][HALVES[name]]):
        c, s = np.cos(np.radians(joint["alpha_deg"])), np.sin(np.radians(joint["alpha_deg"]))
        H = np.array([[1, 0, 0, joint["a"]], [0, c, -s, 0], [0, s, c, joint["d"]], [0, 0, 0, 1]])
        for k, unit in enumerate(np.eye(10)):
            P = H @ pseudo_inertia(unit) @ H.T
            inertia = np.trace(P[:3, :3]) * np.eye(3) - P[:3, :3]
            T[10 * i : 10 * i + 10, 10 * i + k] = [P[3, 3], *P[:3, 3], *inertia[np.tril_indices(3)]]
    return T


def dh_columns(name: str) -> list[pid.Column]:
    """Names of the standard parameters of a half, its links counted as the whole arm's."""
    first = HALVES[name].start + 1
    return [pid.Column(f"{p}_{i}", "", i, "rigid_body") for i in range(first, first + 3) for p in PER_LINK]
