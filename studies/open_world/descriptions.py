"""What the user has of each arm: a description as URDF text, and the limits of its motions."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
UR5 = Path(__file__).resolve().parents[2] / "physident" / "robots" / "ur5.urdf"
TOOL = "tool0"


@dataclass(frozen=True)
class Body:
    """One joint and the link that it moves.

    ``joint`` is "revolute" or "prismatic" about ``axis``; ``place`` [m] and ``turn`` [rad] (roll, pitch, yaw) put the
    joint's frame into the link before it; ``mass`` [kg], ``com`` [m] and the sides of a homogeneous ``box`` [m] describe
    the link; ``limits`` (lower, upper, velocity, effort) are in rad, rad/s and N m, or in m, m/s and N.
    """

    joint: str
    place: tuple[float, float, float]
    turn: tuple[float, float, float]
    mass: float
    com: tuple[float, float, float]
    box: tuple[float, float, float]
    limits: tuple[float, float, float, float]
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Description:
    """An arm as its maker describes it: ``urdf`` text, and bounds (n,) of its motions in rad or m and seconds."""

    name: str
    urdf: str
    lower: Array
    upper: Array
    top_speed: Array
    top_acceleration: Array


def ur5() -> Description:
    """The UR5 as delivered, without its shapes; its elbow stays away from the floor."""
    text = re.sub(r"\s*<(visual|collision)>.*?</\1>", "", UR5.read_text(encoding="utf-8"), flags=re.S)
    return Description(
        "ur5",
        text,
        np.array([-2.4, -2.5, -2.1, -2.6, -2.4, -2.7]),
        np.array([2.4, -0.6, 2.1, 2.6, 2.4, 2.7]),
        np.array([1.4, 1.4, 1.6, 2.0, 2.0, 2.2]),
        np.array([4.5, 4.5, 5.5, 8.0, 8.0, 9.0]),
    )


def seven() -> Description:
    """An upright arm of seven joints whose axes are vertical and horizontal in turn, with a spherical wrist."""
    down, up = (-np.pi / 2, 0.0, 0.0), (np.pi / 2, 0.0, 0.0)
    bodies = [
        Body("revolute", (0, 0, 0.16), (0, 0, 0), 4.2, (0, -0.03, 0.12), (0.14, 0.14, 0.28), (-2.9, 2.9, 1.7, 320)),
        Body("revolute", (0, 0, 0.19), down, 4.4, (0, -0.07, 0.03), (0.13, 0.26, 0.14), (-2.0, 2.0, 1.7, 320)),
        Body("revolute", (0, -0.21, 0), up, 3.1, (0, 0.03, 0.13), (0.12, 0.12, 0.26), (-2.9, 2.9, 1.8, 180)),
        Body("revolute", (0, 0, 0.2), up, 2.8, (0, 0.06, 0.03), (0.11, 0.24, 0.12), (-2.0, 2.0, 2.2, 180)),
        Body("revolute", (0, 0.2, 0), down, 1.8, (0, -0.02, 0.1), (0.1, 0.1, 0.22), (-2.9, 2.9, 2.3, 110)),
        Body("revolute", (0, 0, 0.2), down, 1.6, (0, -0.01, 0.05), (0.1, 0.12, 0.1), (-2.0, 2.0, 3.1, 40)),
        Body("revolute", (0, -0.08, 0), up, 0.5, (0.006, 0, 0.03), (0.07, 0.08, 0.05), (-3.0, 3.0, 3.1, 40)),
    ]
    return Description(
        "seven",
        urdf("seven", bodies, (0.0, 0.0, 0.06)),
        np.array([-2.3, -1.6, -2.3, -1.7, -2.4, -1.7, -2.6]),
        np.array([2.3, 1.6, 2.3, 1.7, 2.4, 1.7, 2.6]),
        np.array([1.2, 1.1, 1.3, 1.5, 1.7, 2.0, 2.2]),
        np.array([4.0, 3.5, 4.5, 5.0, 7.0, 8.0, 9.0]),
    )


def scara() -> Description:
    """Two links that swing about vertical axes, a quill that moves along one, and the tool that turns about it."""
    bodies = [
        Body("revolute", (0, 0, 0.22), (0, 0, 0), 6.5, (0.16, 0.01, 0.05), (0.36, 0.13, 0.1), (-2.6, 2.6, 6.0, 200)),
        Body("revolute", (0.33, 0, 0.08), (0, 0, 0), 4.8, (0.14, -0.008, 0.07), (0.34, 0.12, 0.16), (-2.5, 2.5, 7.0, 90)),
        Body("prismatic", (0.28, 0, 0.1), (np.pi, 0, 0), 1.3, (0.004, 0, 0.06), (0.05, 0.05, 0.34), (0.0, 0.26, 1.1, 260)),
        Body("revolute", (0, 0, 0.17), (0, 0, 0), 0.9, (0.02, 0.012, 0.03), (0.09, 0.06, 0.05), (-6.2, 6.2, 20.0, 15)),
    ]  # fmt: skip
    return Description(
        "scara",
        urdf("scara", bodies, (0.0, 0.0, 0.06)),
        np.array([-2.1, -2.1, 0.01, -3.0]),
        np.array([2.1, 2.1, 0.25, 3.0]),
        np.array([2.4, 2.8, 0.4, 5.0]),
        np.array([9.0, 11.0, 2.6, 30.0]),
    )


def planar() -> Description:
    """Two links that swing in one vertical plane."""
    bodies = [
        Body("revolute", (0, 0, 0.1), (np.pi / 2, 0, 0), 5.2, (0.21, 0.012, 0.02), (0.46, 0.1, 0.1), (-3.1, 3.1, 3.0, 120)),
        Body("revolute", (0.42, 0, 0.05), (0, 0, 0), 3.0, (0.17, -0.01, 0.01), (0.38, 0.08, 0.08), (-3.1, 3.1, 4.0, 60)),
    ]  # fmt: skip
    return Description(
        "planar", urdf("planar", bodies, (0.36, 0.0, 0.0)), np.array([-1.9, -2.2]), np.array([1.9, 2.2]),
        np.array([1.8, 2.3]), np.array([6.0, 8.0]),
    )  # fmt: skip


def pan_and_lift() -> Description:
    """A turret: one joint turns about the vertical, the other lifts a boom."""
    bodies = [
        Body("revolute", (0, 0, 0.12), (0, 0, 0), 6.0, (0.02, 0.03, 0.1), (0.2, 0.18, 0.24), (-3.1, 3.1, 3.0, 90)),
        Body("revolute", (0.04, 0, 0.24), (np.pi / 2, 0, 0), 4.4, (0.24, 0.02, 0.015), (0.55, 0.1, 0.09), (-1.5, 1.9, 3.0, 90)),
    ]  # fmt: skip
    return Description(
        "pan_and_lift", urdf("pan_and_lift", bodies, (0.52, 0.0, 0.0)), np.array([-2.4, -0.9]), np.array([2.4, 1.6]),
        np.array([2.0, 1.8]), np.array([7.0, 6.0]),
    )  # fmt: skip


ARMS: tuple[tuple[Callable[[], Description], ...], ...] = ((ur5,), (seven,), (scara,), (planar, pan_and_lift))


def urdf(name: str, bodies: list[Body], tool: tuple[float, float, float]) -> str:
    """The text of a serial arm, with a fixed ``tool`` frame [m] on its last link."""
    lines = ['<?xml version="1.0"?>', f'<robot name="{name}">', '  <link name="base_link"/>']
    for number, body in enumerate(bodies, 1):
        parent = "base_link" if number == 1 else f"link_{number - 1}"
        lines += _joint(f"joint_{number}", body, parent, f"link_{number}")
        lines += _link(f"link_{number}", body)
    lines += [
        f'  <link name="{TOOL}"/>',
        '  <joint name="flange" type="fixed">',
        f'    <parent link="link_{len(bodies)}"/>',
        f'    <child link="{TOOL}"/>',
        f'    <origin xyz="{_row(tool)}" rpy="0 0 0"/>',
        "  </joint>",
        "</robot>",
    ]
    return "\n".join(lines) + "\n"


def _joint(name: str, body: Body, parent: str, child: str) -> list[str]:
    lower, upper, speed, effort = body.limits
    return [
        f'  <joint name="{name}" type="{body.joint}">',
        f'    <parent link="{parent}"/>',
        f'    <child link="{child}"/>',
        f'    <origin xyz="{_row(body.place)}" rpy="{_row(body.turn)}"/>',
        f'    <axis xyz="{_row(body.axis)}"/>',
        f'    <limit lower="{lower}" upper="{upper}" velocity="{speed}" effort="{effort}"/>',
        "  </joint>",
    ]


def _link(name: str, body: Body) -> list[str]:
    x, y, z = (side * side for side in body.box)
    m = body.mass / 12
    return [
        f'  <link name="{name}">',
        "    <inertial>",
        f'      <origin xyz="{_row(body.com)}" rpy="0 0 0"/>',
        f'      <mass value="{body.mass}"/>',
        f'      <inertia ixx="{m * (y + z):.9g}" ixy="0" ixz="0" iyy="{m * (x + z):.9g}" iyz="0" izz="{m * (x + y):.9g}"/>',
        "    </inertial>",
        "  </link>",
    ]


def _row(values: tuple[float, ...]) -> str:
    return " ".join(f"{value:.12g}" for value in values)
