"""URDF text into a Pinocchio model: only kinematics, inertia and limits are read; shapes and meshes are set aside."""

from __future__ import annotations

import math
from typing import Any
from xml.etree import ElementTree

import numpy as np

from physident.errors import InputError

MAX_BYTES = 20_000_000
LARGEST = 1e6  # kg, m, kg m^2: more than any arm, and its square does not overflow
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
    links, joints = root.findall("link"), root.findall("joint")
    _check_links(links, source)
    _check_joints(joints, source)
    _check_tree(links, joints, source)
    try:
        model = pinocchio.buildModelFromXML(_kinematics(root.get("name") or "robot", links, joints))
    except Exception as error:  # the binding raises several kinds for one cause
        reason = (str(error).splitlines() or [type(error).__name__])[0][:200]
        raise InputError(f"{source}: not a robot description Pinocchio can read ({reason})") from None
    model.armature[:] = 0.0
    unlimited = np.abs(model.upperPositionLimit) > 1e9
    model.upperPositionLimit[unlimited], model.lowerPositionLimit[unlimited] = math.inf, -math.inf
    return model


def _kinematics(name: str, links: list[ElementTree.Element], joints: list[ElementTree.Element]) -> str:
    """URDF text with only the elements that are read and checked here, so that no other element can upset a parser."""
    clean = ElementTree.Element("robot", name=name)
    for link in links:
        one = ElementTree.SubElement(clean, "link", name=link.attrib["name"])
        one.extend(link.findall("inertial")[:1])
    for joint in joints:
        one = ElementTree.SubElement(clean, "joint", name=joint.attrib["name"], type=joint.attrib["type"])
        for tag in ("parent", "child", "origin", "axis", "limit"):
            one.extend(joint.findall(tag)[:1])
        if one.get("type") == "continuous":  # one angle for each joint, not Pinocchio's (cos, sin)
            one.set("type", "revolute")
            for limit in one.findall("limit"):
                one.remove(limit)
            given = dict(joint.find("limit").attrib) if joint.find("limit") is not None else {}  # pyright: ignore[reportOptionalMemberAccess]
            given = {"effort": "0", "velocity": "0"} | given | {"lower": "-1e10", "upper": "1e10"}
            ElementTree.SubElement(one, "limit", given)
    return ElementTree.tostring(clean, encoding="unicode")


def _parse(text: str, source: str) -> ElementTree.Element:
    if len(text) > MAX_BYTES:
        raise InputError(f"{source}: {len(text)} characters, expected a URDF of at most {MAX_BYTES}")
    if "<!ENTITY" in text:
        raise InputError(f"{source}: declares XML entities, which a URDF does not need; expand xacro before loading")
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError, RecursionError) as error:
        raise InputError(f"{source}: malformed XML ({error}), expected a URDF") from None
    if root.tag != "robot":
        raise InputError(
            f"{source}: the root element is <{root.tag}>, expected <robot>; run xacro first if this is one"
        )
    return root


def _check_links(links: list[ElementTree.Element], source: str) -> None:
    _check_names(links, source)
    for link in links:
        inertial = link.find("inertial")
        if inertial is None:
            continue
        where = f"{source}: link {link.get('name')!r}"
        _number(inertial.find("mass"), "value", where, "mass", minimum=0.0)
        tensor = inertial.find("inertia")
        for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
            _number(tensor, key, where, f"inertia {key}")
        _check_placement(inertial.find("origin"), f"{where} inertial origin")


def _check_joints(joints: list[ElementTree.Element], source: str) -> None:
    _check_names(joints, source)
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
        _check_placement(joint.find("origin"), f"{where} origin")
        if kind == "fixed":
            continue
        axis = joint.find("axis")
        if axis is not None and not np.any(_triple(axis, "xyz", f"{where} axis")):
            raise InputError(f'{where}: its axis is zero, expected a direction such as "0 0 1"')
        _check_limit(joint.find("limit"), kind, where)
    if not any(joint.get("type") in MOVING for joint in joints):
        raise InputError(f"{source}: no moving joint, expected at least one revolute, continuous or prismatic joint")


def _check_limit(limit: ElementTree.Element | None, kind: str, where: str) -> None:
    if limit is None and kind == "continuous":
        return
    for key in ("effort", "velocity"):
        _number(limit, key, where, f"limit {key}", minimum=0.0)
    if kind != "continuous" and limit is not None:
        stated = {key: limit.get(key, "0") for key in ("lower", "upper")}
        for key in stated:
            _number(ElementTree.Element("limit", stated), key, where, f"limit {key}")
        if float(stated["lower"]) > float(stated["upper"]):
            raise InputError(f"{where}: limit lower {stated['lower']} is above its upper {stated['upper']}; swap them")


def _check_names(elements: list[ElementTree.Element], source: str) -> None:
    seen: set[str] = set()
    for number, element in enumerate(elements, 1):
        name = element.get("name")
        if not name:
            raise InputError(f"{source}: {element.tag} {number} has no name, expected one")
        if name in seen:
            raise InputError(f"{source}: {element.tag} {name!r} is given twice, expected each name once")
        seen.add(name)


def _check_tree(links: list[ElementTree.Element], joints: list[ElementTree.Element], source: str) -> None:
    """Every link but one hangs on one joint, and following parents from any link leads to that one."""
    names = [link.get("name", "") for link in links]
    parents: dict[str, str] = {}
    for joint in joints:
        ends = []
        for end in ("parent", "child"):
            element = joint.find(end)
            link = None if element is None else element.get("link")
            if link not in names:
                found = "missing" if link is None else f"{link!r}, which is not a link"
                raise InputError(f"{source}: joint {joint.get('name')!r}: its {end} is {found}; expected a link's name")
            ends.append(link)
        if ends[1] in parents:
            raise InputError(f"{source}: link {ends[1]!r} hangs on two joints, expected a tree: loops cannot be read")
        parents[ends[1]] = ends[0]
    roots = [name for name in names if name not in parents]
    if len(roots) != 1:
        found = ", ".join(roots[:5]) or "none: the joints close a loop"
        raise InputError(f"{source}: {len(roots)} root links ({found}), expected one: the base")
    reached = {roots[0]}
    for name in names:
        path = []
        while name not in reached and name not in path:
            path.append(name)
            name = parents[name]
        if name not in reached:
            raise InputError(f"{source}: link {name!r} is in a loop of joints, expected a tree")
        reached.update(path)


def _check_placement(origin: ElementTree.Element | None, where: str) -> None:
    for key in ("xyz", "rpy"):
        _triple(origin, key, where)


def _number(element: ElementTree.Element | None, key: str, where: str, what: str, minimum: float = -math.inf) -> None:
    text = None if element is None else element.get(key)
    try:
        value = float(text if text is not None and "_" not in text else "missing")
    except ValueError:
        value = math.nan
    limit = math.inf if what.startswith("limit") else LARGEST
    if not math.isfinite(value) or value < minimum or abs(value) > limit:
        wanted = "a number of an arm's size" if abs(value) > limit else "a finite number"
        wanted += " that is not negative" if minimum == 0 else ""
        xacro = ": run xacro first" if text and "${" in text else ""
        raise InputError(f"{where}: {what} is {text or 'missing'}, expected {wanted}{xacro}")


def _triple(element: ElementTree.Element | None, key: str, where: str) -> list[float]:
    text = "0 0 0" if element is None else element.get(key, "0 0 0")
    try:
        values = [float(x) for x in text.split()] if "_" not in text else []
    except ValueError:
        values = []
    if len(values) != 3 or not np.isfinite(values).all() or np.abs(values).max() > LARGEST:
        raise InputError(f"{where}: {key} is {text!r}, expected three finite numbers")
    return values
