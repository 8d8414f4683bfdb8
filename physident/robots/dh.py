"""A robot from a Denavit-Hartenberg table (standard convention, with calibration offsets), written as URDF.

All other modules read URDF, so this is the only place that interprets a table. The DH frame of a link is at its far end;
its URDF frame is on the axis of its joint. The two differ by the constant Tz(d) Tx(a) Rx(alpha).
"""

from __future__ import annotations

import math
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
import pinocchio
import pinocchio.utils
from numpy.typing import NDArray

Array = NDArray[np.float64]


def urdf_from_table(table: dict[str, Any]) -> str:
    """URDF text of a parsed DH table: joint i turns about z of DH frame i-1 (thesis eq. 2.2, 2.3)."""
    name = str(table.get("name", "robot"))
    lines = ['<?xml version="1.0"?>', f"<robot name={quoteattr(name)}>"]
    lines += _link("base_link", None, table.get("base", {}), np.eye(4))
    placement = np.eye(4)  # from the previous URDF link frame to the previous DH frame
    parent = "base_link"
    for number, joint in enumerate(table["joints"], 1):
        calibration = joint.get("calibration", {})
        d, a, alpha, offset = (
            joint.get(key, 0.0) + calibration.get(key, 0.0) for key in ("d", "a", "alpha_deg", "offset_deg")
        )
        link = f"link_{number}"
        lines += _joint(joint, number, parent, link, placement @ _rotation("z", offset))
        placement = _translation(a, 0.0, d) @ _rotation("x", alpha)
        lines += _link(link, joint, joint, placement)
        parent = link
    lines += ['  <link name="tool0"/>', *_fixed("flange", parent, "tool0", placement), "</robot>", ""]
    return "\n".join(lines)


def _joint(joint: dict, number: int, parent: str, child: str, placement: Array) -> list[str]:
    lower, upper = joint.get("limits", [-2 * math.pi, 2 * math.pi])
    return [
        f"  <joint name={quoteattr(joint.get('name', f'joint_{number}'))} type={quoteattr(joint.get('kind', 'revolute'))}>",
        f'    <parent link="{parent}"/>',
        f'    <child link="{child}"/>',
        f"    {_origin(placement)}",
        '    <axis xyz="0 0 1"/>',
        f'    <limit lower="{lower!r}" upper="{upper!r}" velocity="{joint.get("velocity_limit", math.pi)!r}"'
        f' effort="{joint.get("torque_limit", 1000.0)!r}"/>',
        "  </joint>",
    ]


def _fixed(name: str, parent: str, child: str, placement: Array) -> list[str]:
    head = f'  <joint name="{name}" type="fixed">'
    return [
        head,
        f'    <parent link="{parent}"/>',
        f'    <child link="{child}"/>',
        f"    {_origin(placement)}",
        "  </joint>",
    ]


def _link(name: str, inertial: dict | None, shapes: dict, placement: Array) -> list[str]:
    lines = [f'  <link name="{name}">']
    if inertial is not None and "mass" in inertial:
        com = placement @ np.append(inertial.get("com", [0.0, 0.0, 0.0]), 1.0)
        at_com = placement.copy()
        at_com[:3, 3] = com[:3]
        ixx, ixy, iyy, ixz, iyz, izz = inertial.get("inertia", [0.0] * 6)
        lines += [
            "    <inertial>",
            f"      {_origin(at_com)}",
            f'      <mass value="{inertial["mass"]!r}"/>',
            f'      <inertia ixx="{ixx!r}" ixy="{ixy!r}" ixz="{ixz!r}" iyy="{iyy!r}" iyz="{iyz!r}" izz="{izz!r}"/>',
            "    </inertial>",
        ]
    for capsule in shapes.get("capsules", []):
        start, end = (placement @ np.append(capsule[key], 1.0) for key in ("start", "end"))
        for kind in ("visual", "collision"):
            lines += _capsule(kind, start[:3], end[:3], capsule["radius"])
    return [*lines, "  </link>"]


def _capsule(kind: str, start: Array, end: Array, radius: float) -> list[str]:
    """A capsule as a cylinder with a sphere at each end: URDF has no capsules."""
    at, length = _along(start, end)
    cylinder = f'<cylinder radius="{radius!r}" length="{length!r}"/>'
    shapes = [(at, cylinder)]
    shapes += [(_translation(*point), f'<sphere radius="{radius!r}"/>') for point in (start, end)]
    return [f"    <{kind}>{_origin(place)}<geometry>{shape}</geometry></{kind}>" for place, shape in shapes]


def _along(start: Array, end: Array) -> tuple[Array, float]:
    """Placement (4, 4) halfway between two points with z along them, and their distance [m]."""
    length = float(np.linalg.norm(end - start))
    z = (end - start) / length
    placement = _translation(*((start + end) / 2))
    placement[:3, :3] = pinocchio.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), z).matrix()
    return placement, length


def _origin(placement: Array) -> str:
    rpy = pinocchio.rpy.matrixToRpy(placement[:3, :3])
    numbers = [" ".join(repr(float(x) + 0.0) for x in triple) for triple in (placement[:3, 3], rpy)]
    return f'<origin xyz="{numbers[0]}" rpy="{numbers[1]}"/>'


def _translation(x: float, y: float, z: float) -> Array:
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T


def _rotation(axis: str, degrees: float) -> Array:
    T = np.eye(4)
    T[:3, :3] = pinocchio.utils.rotate(axis, math.radians(degrees))
    return T
