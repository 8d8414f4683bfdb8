"""Robots from a built-in name, a URDF file or a DH table."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from physident.errors import InputError, warn
from physident.files import read_text
from physident.robots.dh import urdf_from_table
from physident.robots.dh_table import parse_table
from physident.robots.inertia import violations
from physident.robots.robot import STANDARD_GRAVITY, Drive, Robot, checked_gravity
from physident.robots.urdf import MAX_BYTES, robot_name

BUILT_IN = ("ur5",)


def load_robot(source: str | Path, gravity: Sequence[float] | None = None) -> Robot:
    """A robot from a built-in name ("ur5"), a URDF file (.urdf, .xml) or a DH table (.toml).

    ``gravity`` (3,) [m/s^2] in the base frame replaces the standard one, for an arm that is not mounted upright.
    Meshes are not needed. Warns about links that are not rigid bodies; raises InputError for a file that is missing or
    malformed, a floating base, no joints, or a mass that is negative or not finite.
    """
    text, label = _read(source)
    is_table = label.endswith(".toml")
    if is_table:
        table = parse_table(text, label)
        robot = _from_table(table, label, gravity)
    else:
        robot = Robot(
            name=robot_name(text, label), urdf=text, gravity=checked_gravity(gravity or STANDARD_GRAVITY), source=label
        )
    for message in unphysical_links(robot):
        warn(f"{label}: {message}")
    return robot


def unphysical_links(robot: Robot) -> list[str]:
    """One sentence for each link whose nominal inertia is not that of a rigid body: the link and the violated condition."""
    return [
        f"link {i} ({joint.name}): {'; '.join(violated)}"
        for i, joint in enumerate(robot.joints, 1)
        if (violated := violations(robot.link(i))) and robot.link(i).any()
    ]


def _from_table(table: dict[str, Any], label: str, gravity: Sequence[float] | None) -> Robot:
    joints = table["joints"]
    drives = tuple(
        Drive(**joint["drive"] | {"motor_friction": tuple(joint["drive"]["motor_friction"])})
        for joint in joints
        if "drive" in joint
    )
    return Robot(
        name=table.get("name", "robot"),
        urdf=urdf_from_table(table),
        gravity=checked_gravity(gravity or table.get("gravity", STANDARD_GRAVITY)),
        drives=drives or None,
        acceleration_limit=tuple(joint.get("acceleration_limit", math.inf) for joint in joints),
        tool_speed_limit=table.get("tool_speed_limit"),
        source=label,
    )


def _read(source: str | Path) -> tuple[str, str]:
    if str(source) in BUILT_IN:
        name = f"{source}.toml"
        return resources.files("physident").joinpath("robots", name).read_text(encoding="utf-8"), name
    if not os.path.isfile(source):
        names = ", ".join(BUILT_IN)
        raise InputError(
            f"robot {str(source)!r} not found: expected a .urdf or .toml file, or a built-in name ({names})"
        )
    return read_text(source, MAX_BYTES, "a URDF or a DH table"), Path(source).name
