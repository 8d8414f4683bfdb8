"""The text of a Denavit-Hartenberg table, read and checked: every entry known, finite, and of its size."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable
from typing import Any

from physident.errors import InputError

SCHEMA = "physident.dh/1"
LARGEST = 1e9  # of any number in a table
TOP_KEYS = ("schema", "name", "base", "joints", "gravity", "tool_speed_limit")
NUMBERS = {"d": 0, "a": 0, "alpha_deg": 0, "offset_deg": 0, "mass": 0, "com": 3, "inertia": 6, "limits": 2}
NUMBERS |= dict.fromkeys(("velocity_limit", "acceleration_limit", "torque_limit"), 0)
JOINT_KEYS = (*NUMBERS, "name", "kind", "drive", "calibration", "capsules")
CALIBRATION = {"d": 0, "a": 0, "alpha_deg": 0, "offset_deg": 0}
DRIVE = {"gear_ratio": 0, "torque_constant": 0, "motor_inertia": 0, "motor_friction": 2}
CAPSULE = {"start": 3, "end": 3, "radius": 0}


def parse_table(text: str, source: str) -> dict[str, Any]:
    """The table of a TOML text, checked; raises InputError naming ``source`` and what is missing or wrong."""
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{source}: not valid TOML ({error}); expected a DH table, schema {SCHEMA}") from None
    if table.get("schema") != SCHEMA:
        raise InputError(f"{source}: schema is {table.get('schema')!r}, expected {SCHEMA!r} as the file's first line")
    joints = table.get("joints")
    if not isinstance(joints, list) or not joints or not all(isinstance(j, dict) for j in joints):
        raise InputError(f"{source}: no [[joints]] found, expected one for each joint with d, a, alpha_deg, mass, com")
    _check_keys(table, TOP_KEYS, source)
    _check_numbers(table, {"gravity": 3, "tool_speed_limit": 0}, source)
    _check_name(table, source)
    base = table.get("base", {})
    if not isinstance(base, dict):
        raise InputError(f"{source}: base is {base!r}, expected a table with capsules: [base]")
    _check_keys(base, ("capsules",), f"{source}: base")
    _check_capsules(base, f"{source}: base")
    for number, joint in enumerate(joints, 1):
        _check_joint(joint, f"{source}: joint {number}")
    names = [joint.get("name", f"joint_{number}") for number, joint in enumerate(joints, 1)]
    if twice := [name for name in names if names.count(name) > 1]:
        raise InputError(f"{source}: joint name {twice[0]!r} is given twice, expected each once")
    without_drive = [number for number, joint in enumerate(joints, 1) if "drive" not in joint]
    if 0 < len(without_drive) < len(joints):
        raise InputError(
            f"{source}: joint {without_drive[0]} has no drive but other joints have one; expected a drive for each joint or none"
        )
    return table


def _check_joint(joint: dict[str, Any], where: str) -> None:
    _check_keys(joint, JOINT_KEYS, where)
    _check_numbers({"d": None, "a": None, "alpha_deg": None} | joint, NUMBERS, where)
    _check_name(joint, where)
    kind, limits = joint.get("kind", "revolute"), joint.get("limits", [0, 0])
    if kind not in ("revolute", "continuous", "prismatic"):
        raise InputError(f"{where}: kind is {kind!r}, expected 'revolute', 'continuous' or 'prismatic'")
    if limits[0] > limits[1]:
        raise InputError(f"{where}: limits are {limits}, expected the lower one first")
    if {"com", "inertia"} & set(joint) and "mass" not in joint:
        raise InputError(f"{where}: com or inertia without a mass; expected mass [kg] too")
    for key in ("velocity_limit", "acceleration_limit", "torque_limit"):
        if joint.get(key, 1.0) <= 0:
            raise InputError(f"{where}: {key} is {joint[key]!r}, expected a positive number")
    for key, sizes in (("calibration", CALIBRATION), ("drive", DRIVE)):
        entries = joint.get(key, {})
        if not isinstance(entries, dict):
            raise InputError(f"{where}: {key} is {entries!r}, expected entries such as {{ {next(iter(sizes))} = 1.0 }}")
        _check_keys(entries, sizes, f"{where} {key}")
        wanted = dict.fromkeys(sizes) if key == "drive" and key in joint else {}
        _check_numbers(wanted | entries, sizes, f"{where} {key}")
    for key in ("gear_ratio", "torque_constant"):
        if joint.get("drive", {}).get(key, 1.0) == 0:
            raise InputError(f"{where}: drive {key} is 0, expected another number")
    _check_capsules(joint, where)


def _check_capsules(shapes: dict[str, Any], where: str) -> None:
    capsules = shapes.get("capsules", [])
    if not isinstance(capsules, list) or not all(isinstance(capsule, dict) for capsule in capsules):
        raise InputError(f"{where}: capsules is {capsules!r}, expected a list of {{ start, end, radius }}")
    for number, capsule in enumerate(capsules, 1):
        one = f"{where}: capsule {number}"
        _check_keys(capsule, CAPSULE, one)
        _check_numbers(dict.fromkeys(CAPSULE) | capsule, CAPSULE, one)
        if capsule["radius"] <= 0:
            raise InputError(f"{one}: radius is {capsule['radius']!r}, expected a positive length [m]")
        if math.dist(capsule["start"], capsule["end"]) < 1e-6:
            raise InputError(f"{one}: start and end are the same point; expected a length above zero")


def _check_keys(entries: dict[str, Any], known: Iterable[str], where: str) -> None:
    if unknown := [key for key in entries if key not in known]:
        raise InputError(f"{where}: {unknown[0]!r} is not known, expected some of {', '.join(known)}")


def _check_name(entries: dict[str, Any], where: str) -> None:
    name = entries.get("name", "robot")
    if not isinstance(name, str) or not name:
        raise InputError(f"{where}: name is {name!r}, expected a text")


def _check_numbers(entries: dict[str, Any], sizes: dict[str, int], where: str) -> None:
    """Checks that each entry is a finite number (size 0) or a list of that many; None stands for a missing one."""
    for key, size in sizes.items():
        if key not in entries:
            continue
        numbers = entries[key] if size and isinstance(entries[key], list) else [entries[key]]
        plain = all(type(x) in (int, float) and abs(x) <= LARGEST for x in numbers)
        if not plain or len(numbers) != max(size, 1) or (size and not isinstance(entries[key], list)):
            found = "missing" if entries[key] is None else repr(entries[key])
            raise InputError(
                f"{where}: {key} is {found}, expected {f'{size} finite numbers' if size else 'a finite number'}"
            )
