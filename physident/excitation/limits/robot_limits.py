"""Tighter limits than a robot's own, for a cell, a payload or a careful first session."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np

from physident.errors import InputError, did_you_mean
from physident.robots.robot import Robot

FIELDS = {"lower": "lower", "upper": "upper", "speed": "velocity", "torque": "effort"}  # in a URDF
NAMES = (*FIELDS, "acceleration")
EXPECTED = 'such as "speed=1.0 acceleration=2,2,2,4,4,4", one number for all joints or one for each'


def with_limits(robot: Robot, text: str) -> Robot:
    """The robot with tighter limits, given as ``speed=1.0 acceleration=2.0 torque=40 lower=-2 upper=2``, in rad|m, s and N m|N.

    A number counts for every joint, n numbers with commas for one joint each; a limit that the robot has and that is tighter is kept.
    Raises InputError for any other text.
    """
    limits = _parsed(robot, text)
    acceleration = robot.acceleration_limit
    if "acceleration" in limits:
        own = np.array(acceleration or (np.inf,) * robot.n)
        acceleration = tuple(np.minimum(own, limits.pop("acceleration")).tolist())
    tree = ET.fromstring(robot.urdf)
    for j, name in enumerate(robot.joint_names):
        joint = next(one for one in tree.iter("joint") if one.get("name") == name)
        limit = joint.find("limit")
        if limit is None:
            limit = ET.SubElement(joint, "limit", {"effort": "1e9", "velocity": "1e9"})
        own = {"lower": robot.lower, "upper": robot.upper, "speed": robot.velocity_limit, "torque": robot.torque_limit}
        for key, values in limits.items():
            tighter = max if key == "lower" else min
            limit.set(FIELDS[key], repr(float(tighter(own[key][j], values[j]))))
    return replace(robot, urdf=ET.tostring(tree, encoding="unicode"), acceleration_limit=acceleration)


def _parsed(robot: Robot, text: str) -> dict[str, np.ndarray]:
    """Limits (n,) by name."""
    limits = {}
    for part in text.split():
        name, _, given = part.partition("=")
        if name not in NAMES:
            raise InputError(
                f"robot limits name {name!r}, expected {', '.join(NAMES)}{did_you_mean(name, NAMES)}; {EXPECTED}"
            )
        try:
            values = np.array([float(number) for number in re.split(",", given)])
        except ValueError:
            values = np.array([np.nan])
        if len(values) not in (1, robot.n) or not np.isfinite(values).all():
            raise InputError(f"robot limits have {part!r}, expected 1 or {robot.n} finite numbers, {EXPECTED}")
        if name in ("speed", "acceleration", "torque") and not (values > 0).all():
            raise InputError(f"robot limits have {part!r}, expected positive numbers, {EXPECTED}")
        limits[name] = np.broadcast_to(values, (robot.n,))
    if not limits:
        raise InputError(f"robot limits are {text!r}, expected {EXPECTED}")
    lower, upper = limits.get("lower", robot.lower), limits.get("upper", robot.upper)
    if not (np.maximum(lower, robot.lower) < np.minimum(upper, robot.upper)).all():
        raise InputError(
            f"robot limits {text!r} leave a joint no range between its lower and its upper limit; expected some"
        )
    return limits
