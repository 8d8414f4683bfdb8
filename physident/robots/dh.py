"""A robot from a Denavit-Hartenberg table (standard convention, with calibration offsets), written as URDF.

Everything downstream reads URDF, so a table has one meaning only: the URDF made here. A link's DH frame i sits at its
far end; a URDF link frame sits on its own joint's axis. The two differ by the constant Tz(d) Tx(a) Rx(alpha).
"""

from __future__ import annotations

import math
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np


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
        lines += _joint(joint, number, parent, link, placement @ _rotation_z(math.radians(offset)))
        placement = _translation(a, 0.0, d) @ _rotation_x(math.radians(alpha))
        lines += _link(link, joint, joint, placement)
        parent = link
    lines += ['  <link name="tool0"/>', *_fixed("flange", parent, "tool0", placement), "</robot>", ""]
    return "\n".join(lines)


def _joint(joint: dict, number: int, parent: str, child: str, placement: np.ndarray) -> list[str]:
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


def _fixed(name: str, parent: str, child: str, placement: np.ndarray) -> list[str]:
    head = f'  <joint name="{name}" type="fixed">'
    return [
        head,
        f'    <parent link="{parent}"/>',
        f'    <child link="{child}"/>',
        f"    {_origin(placement)}",
        "  </joint>",
    ]


def _link(name: str, inertial: dict | None, shapes: dict, placement: np.ndarray) -> list[str]:
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


def _capsule(kind: str, start: np.ndarray, end: np.ndarray, radius: float) -> list[str]:
    """A capsule in plain URDF, which knows none: a cylinder and a sphere at each end."""
    at, length = _along(start, end)
    cylinder = f'<cylinder radius="{radius!r}" length="{length!r}"/>'
    shapes = [(at, cylinder)]
    shapes += [(_translation(*point), f'<sphere radius="{radius!r}"/>') for point in (start, end)]
    return [f"    <{kind}>{_origin(place)}<geometry>{shape}</geometry></{kind}>" for place, shape in shapes]


def _along(start: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, float]:
    """Placement halfway between two points with z along them, and their distance."""
    length = float(np.linalg.norm(end - start))
    z = (end - start) / length
    helper = np.eye(3)[np.argmin(np.abs(z))]
    x = np.cross(helper, z) / np.linalg.norm(np.cross(helper, z))
    placement = np.eye(4)
    placement[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    placement[:3, 3] = (start + end) / 2
    return placement, length


def _origin(placement: np.ndarray) -> str:
    R, p = placement[:3, :3], placement[:3, 3]
    pitch = math.atan2(-R[2, 0], math.hypot(R[0, 0], R[1, 0]))
    if math.hypot(R[0, 0], R[1, 0]) > 1e-9:
        roll, yaw = math.atan2(R[2, 1], R[2, 2]), math.atan2(R[1, 0], R[0, 0])
    else:  # gimbal lock: only the sum of roll and yaw matters
        roll, yaw = math.atan2(-R[1, 2], R[1, 1]), 0.0
    numbers = [" ".join(repr(float(x) + 0.0) for x in triple) for triple in (p, (roll, pitch, yaw))]
    return f'<origin xyz="{numbers[0]}" rpy="{numbers[1]}"/>'


def _translation(x: float, y: float, z: float) -> np.ndarray:
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T


def _rotation_x(angle: float) -> np.ndarray:
    T = np.eye(4)
    T[1:3, 1:3] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    return T


def _rotation_z(angle: float) -> np.ndarray:
    T = np.eye(4)
    T[:2, :2] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    return T
