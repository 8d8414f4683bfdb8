"""URDF text into a Pinocchio model: only kinematics, inertia and limits are read; shapes and meshes are set aside."""

from __future__ import annotations

import math
from typing import Any
from xml.etree import ElementTree

import numpy as np

from physident.errors import InputError

MAX_BYTES = 20_000_000
MOVING = ("revolute", "continuous", "prismatic")


def robot_name(text: str, source: str) -> str:
    """The robot's name in a URDF text, "robot" where it has none; raises InputError where the text is no URDF."""
    return _parse(text, source).get("name") or "robot"


def pinocchio_model(text: str, source: str) -> Any:
    """The Pinocchio model of a URDF text with a fixed base, armature set to zero.

    Raises InputError, naming ``source`` and the element, for malformed XML, joints that are not revolute, continuous,
    prismatic or fixed, mimicking joints, no moving joint, and masses or inertias that are negative or not finite.
    """
    import pinocchio

    root = _parse(text, source)
    _check_links(root, source)
    _check_joints(root, source)
    for link in root.iter("link"):
        for shape in [child for child in link if child.tag in ("visual", "collision")]:
            link.remove(shape)
    for joint in root.iter("joint"):
        if joint.get("type") == "continuous":  # one angle for each joint, not Pinocchio's (cos, sin)
            joint.set("type", "revolute")
            limit = joint.find("limit")
            limit = ElementTree.SubElement(joint, "limit") if limit is None else limit
            limit.attrib.update({"lower": "-1e10", "upper": "1e10"})
            limit.attrib.setdefault("effort", "0")
            limit.attrib.setdefault("velocity", "0")
    try:
        model = pinocchio.buildModelFromXML(ElementTree.tostring(root, encoding="unicode"))
    except Exception as error:  # the binding raises several kinds for one cause
        raise InputError(
            f"{source}: not a robot description Pinocchio can read ({str(error).splitlines()[0]})"
        ) from None
    model.armature[:] = 0.0
    unlimited = np.abs(model.upperPositionLimit) > 1e9
    model.upperPositionLimit[unlimited], model.lowerPositionLimit[unlimited] = math.inf, -math.inf
    return model


def _parse(text: str, source: str) -> ElementTree.Element:
    if len(text) > MAX_BYTES:
        raise InputError(f"{source}: {len(text)} characters, expected a URDF of at most {MAX_BYTES}")
    if "<!ENTITY" in text:
        raise InputError(f"{source}: declares XML entities, which a URDF has no use for; expand xacro before loading")
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise InputError(f"{source}: malformed XML ({error}), expected a URDF") from None
    if root.tag != "robot":
        raise InputError(
            f"{source}: the root element is <{root.tag}>, expected <robot>; run xacro first if this is one"
        )
    return root


def _check_links(root: ElementTree.Element, source: str) -> None:
    for link in root.iter("link"):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        where = f"{source}: link {link.get('name')!r}"
        mass = inertial.find("mass")
        _number(mass, "value", where, "mass", minimum=0.0)
        tensor = inertial.find("inertia")
        for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
            _number(tensor, key, where, f"inertia {key}")
        origin = inertial.find("origin")
        for key in () if origin is None else ("xyz", "rpy"):
            _triple(origin, key, f"{where} inertial origin")


def _check_joints(root: ElementTree.Element, source: str) -> None:
    joints = root.findall("joint")
    for joint in joints:
        kind, where = joint.get("type"), f"{source}: joint {joint.get('name')!r}"
        if kind not in (*MOVING, "fixed"):
            raise InputError(
                f"{where} is {kind!r}, expected revolute, continuous, prismatic or fixed (arms have a fixed base)"
            )
        if joint.find("mimic") is not None:
            raise InputError(
                f"{where} mimics another joint; expected independent joints: make it fixed or drop <mimic>"
            )
        origin = joint.find("origin")
        for key in () if origin is None else ("xyz", "rpy"):
            _triple(origin, key, f"{where} origin")
        if (
            kind in MOVING
            and (axis := joint.find("axis")) is not None
            and not np.any(_triple(axis, "xyz", f"{where} axis"))
        ):
            raise InputError(f'{where}: its axis is zero, expected a direction such as "0 0 1"')
    if not any(joint.get("type") in MOVING for joint in joints):
        raise InputError(f"{source}: no moving joint, expected at least one revolute, continuous or prismatic joint")


def _number(element: ElementTree.Element | None, key: str, where: str, what: str, minimum: float = -math.inf) -> None:
    text = None if element is None else element.get(key)
    try:
        value = float(text if text is not None else "missing")
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or value < minimum:
        wanted = "a finite number" + (" that is not negative" if minimum == 0 else "")
        raise InputError(f"{where}: {what} is {text or 'missing'}, expected {wanted}")


def _triple(element: ElementTree.Element | None, key: str, where: str) -> list[float]:
    text = "0 0 0" if element is None else element.get(key, "0 0 0")
    try:
        values = [float(x) for x in text.split()]
    except ValueError:
        values = []
    if len(values) != 3 or not np.isfinite(values).all():
        raise InputError(f"{where}: {key} is {text!r}, expected three finite numbers")
    return values
