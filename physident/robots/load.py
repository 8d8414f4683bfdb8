"""Robots from a built-in name, a URDF, xacro or MuJoCo file, or a DH table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence, Set
from dataclasses import replace
from pathlib import Path
from typing import Any

from physident.errors import InputError, warn
from physident.robots.dh import urdf_from_table
from physident.robots.dh_table import parse_table
from physident.robots.drives import Drive
from physident.robots.inertia import violations
from physident.robots.joint_selection import JointSelection, select_joints
from physident.robots.mjcf import read_mjcf
from physident.robots.robot import STANDARD_GRAVITY, Origin, Robot, checked_gravity
from physident.robots.sources import RobotSource, find_description
from physident.robots.urdf import MOVING, parse_urdf
from physident.robots.urdf_numbers import parse_plain


def load_robot(
    source: str | Path,
    gravity: Sequence[float] | None = None,
    *,
    joints: str | Sequence[str] | Set[str] | None = None,
    lock: Mapping[str, float] | None = None,
    tool: str | None = None,
    gear_ratios: Sequence[float] | None = None,
) -> Robot:
    """A robot from a built-in name ("ur5", "ur10e"), a URDF or xacro file, a MuJoCo model, or a DH table (.toml).

    ``gravity`` (3,) [m/s^2] in the base frame replaces the description's, for an arm that is not mounted upright. ``joints``
    picks the joints that move, by name or pattern such as "panda_joint*" and in this order (a set has the description's); the others are fixed where
    ``lock`` puts them ([rad|m] by joint name), or else at zero. Without ``joints``, grippers whose fingers mimic each other
    and floating bases are fixed. ``tool`` names the link that is the tool frame. ``gear_ratios`` (n,) are the turns of each motor for one
    turn of its joint, whatever the direction, for a description that states no drives. Meshes are not needed for a URDF.

    Warns about links that are not rigid bodies or have no mass. Raises InputError for a file that is missing or malformed,
    joints that are unknown or not from base to tip, too many joints, a mass that is negative or not finite, and gear ratios that are
    below 1, not one a joint, or stated by the description already.
    """
    found = find_description(source)
    chosen = [name.strip() for name in joints.split(",") if name.strip()] if isinstance(joints, str) else joints
    chosen = found.joints if chosen is None and lock is None else chosen
    options: dict[str, Any] = {"joints": chosen, "lock": lock}
    make = {"urdf": _from_urdf, "dh": _from_table, "mjcf": _from_mjcf}[found.format]
    robot = make(found, gravity, tool, options)
    if gear_ratios is not None:
        robot = _geared(robot, gear_ratios)
    if robot.locked and joints is None and lock is None:
        warn(f"{found.label}: locked: {robot.locked_text()}")
    for message in unphysical_links(robot):
        warn(f"{found.label}: {message}")
    return robot


def _geared(robot: Robot, gear_ratios: Sequence[float]) -> Robot:
    if robot.drives is not None:
        stated = " ".join(f"{drive.gear_ratio:g}" for drive in robot.drives)
        raise InputError(f"gear ratios were given, but {robot.source} states them already ({stated}): leave them out")
    if len(gear_ratios) != robot.n:
        raise InputError(
            f'{robot.source}: {len(gear_ratios)} gear ratios came, expected {robot.n}, one a joint: --gear-ratios "101 101 ...", in quotes'
        )
    return replace(robot, gear_ratios=tuple(abs(float(ratio)) for ratio in gear_ratios))


def as_robot(given: Robot | str | Path) -> Robot:
    """A robot, or the robot of a name or a path; raises InputError as ``load_robot``."""
    return given if isinstance(given, Robot) else load_robot(given)


def unphysical_links(robot: Robot) -> list[str]:
    """One sentence for each link whose nominal inertia is not that of a rigid body: the link and the violated condition,
    or the links of the description that have no inertial element."""
    messages, massless = [], []
    for i, joint in enumerate(robot.joints, 1):
        if not robot.link(i).any():
            massless.append(f"{joint.name} ({', '.join(_moved_with(robot, joint.name))})")
        elif violated := violations(robot.link(i)):
            messages.append(f"link {i} ({joint.name}): {'; '.join(violated)}")
    # MuJoCo refuses a moving body without mass: links without one are between the joints of one body
    if massless and not (robot.origin is not None and robot.origin.format == "mjcf"):
        messages.append(
            f"no inertial element with a mass on the links moved by {', '.join(massless)}: they weigh nothing"
        )
    return messages


def _moved_with(robot: Robot, joint: str) -> list[str]:
    """The links that move with a joint and no later one."""
    below = robot.description.joints_below
    found = [one.child for one in robot.description.joints if one.name == joint]
    for link in found:
        found.extend(one.child for one in below[link] if one.kind not in MOVING)
    return found


def _from_urdf(found: RobotSource, gravity: Sequence[float] | None, tool: str | None, options: dict[str, Any]) -> Robot:
    name = parse_urdf(found.text, found.label).get("name") or "robot"
    selection = select_joints(found.text, found.label, **options)
    return _robot(name, found, selection, STANDARD_GRAVITY if gravity is None else gravity, tool)


def _from_mjcf(found: RobotSource, gravity: Sequence[float] | None, tool: str | None, options: dict[str, Any]) -> Robot:
    assert found.path is not None
    described = read_mjcf(found.path)
    selection = select_joints(described.urdf, found.label, **options, rest=described.rest)
    robot = _robot(
        Path(found.path).stem or "robot", found, selection, described.gravity if gravity is None else gravity, tool
    )
    if described.left_out:
        warn(f"{found.label}: not part of the model: {'; '.join(described.left_out)}")
    bodies = tuple(described.bodies[name] for name in robot.joint_names)
    return replace(
        robot,
        joint_dynamics=tuple(described.dynamics[name] for name in robot.joint_names),
        origin=Origin(format="mjcf", path=found.path, bodies=bodies),
    )


def _from_table(
    found: RobotSource, gravity: Sequence[float] | None, tool: str | None, options: dict[str, Any]
) -> Robot:
    table = parse_table(found.text, found.label)
    selection = select_joints(urdf_from_table(table), found.label, **options)
    mounted = table.get("gravity", STANDARD_GRAVITY) if gravity is None else gravity
    robot = _robot(table.get("name", "robot"), found, selection, mounted, tool)
    rows = {joint.get("name", f"joint_{number}"): joint for number, joint in enumerate(table["joints"], 1)}
    moving = [rows[name] for name in robot.joint_names]
    drives = tuple(
        Drive(**joint["drive"] | {"motor_friction": tuple(joint["drive"]["motor_friction"])})
        for joint in moving
        if "drive" in joint
    )
    return replace(
        robot,
        drives=drives or None,
        acceleration_limit=tuple(joint.get("acceleration_limit", math.inf) for joint in moving),
        tool_speed_limit=table.get("tool_speed_limit"),
    )


def _robot(
    name: str, found: RobotSource, selection: JointSelection, gravity: Sequence[float], tool: str | None
) -> Robot:
    return Robot(
        name=name,
        urdf=selection.urdf,
        gravity=checked_gravity(gravity),
        source=found.label,
        joint_order=selection.order,
        tool_frame=tool,
        locked=selection.locked,
        origin=Origin(format=found.format, path=found.path),
    )


def parse_locks(entries: Sequence[str]) -> dict[str, float]:
    """Positions [rad|m] by joint name of texts such as "finger_joint1=0.02"; raises InputError for any other text."""
    result: dict[str, float] = {}
    for entry in (part for text in entries for part in text.split(",") if part.strip()):
        name, equals, text = (part.strip() for part in entry.partition("="))
        value = parse_plain(text)
        if not name or not equals or not math.isfinite(value):
            raise InputError(
                f"lock: {entry.strip()!r}, expected a joint and its position [rad|m], as finger_joint1=0.02"
            )
        if name in result:
            raise InputError(f"lock: joint {name!r} is given twice, expected each joint once")
        result[name] = value
    if not result:
        raise InputError(
            f"lock: {', '.join(map(repr, entries))}, expected a joint and its position, as finger_joint1=0.02"
        )
    return result
