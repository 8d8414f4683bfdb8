"""URDF text, parsed and checked: only kinematics, inertia and limits are read; shapes and meshes are set aside."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.robots.urdf_numbers import read_number, read_triple

MAX_BYTES = 20_000_000
MAX_LINKS = 1_000  # several times the largest humanoid's; parsers of other programs crash at some thousands in a row
MAX_JOINTS = 30  # that move: two arms on a torso have about 20
MOVING = ("revolute", "continuous", "prismatic")
Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class UrdfLink:
    """A link's mass [kg], centre of mass (3,) [m] and inertia (3, 3) [kg m^2] about it, both in the link's frame; zero
    where the text has no inertial element."""

    name: str
    mass: float
    centre: Array
    inertia: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class UrdfJoint:
    """A joint between two links by name: its frame in the parent's by ``rotation`` (3, 3) and ``translation`` (3,) [m],
    unit ``axis`` (3,) and limits [rad|m], [rad/s|m/s], [N m|N]; a fixed joint has no limits."""

    name: str
    kind: str
    parent: str
    child: str
    rotation: Array
    translation: Array
    axis: Array
    lower: float
    upper: float
    velocity: float
    effort: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Description:
    """What a URDF says about an arm's motion: links by name, joints, and the link that no joint moves (``root``)."""

    name: str
    root: str
    links: dict[str, UrdfLink]
    joints: tuple[UrdfJoint, ...]

    @cached_property
    def joints_below(self) -> dict[str, tuple[UrdfJoint, ...]]:
        """The joints that hang on each link, sorted by name: it makes the order of joints that of Pinocchio's parser."""
        below: dict[str, list[UrdfJoint]] = {name: [] for name in self.links}
        for joint in sorted(self.joints, key=lambda joint: joint.name):
            below[joint.parent].append(joint)
        return {name: tuple(joints) for name, joints in below.items()}

    def from_base(self) -> Iterator[UrdfJoint]:
        """All joints from base to tip, one branch after the other."""
        waiting = list(reversed(self.joints_below[self.root]))
        while waiting:  # a long chain would exhaust the stack of a recursion
            joint = waiting.pop()
            yield joint
            waiting.extend(reversed(self.joints_below[joint.child]))


def parse_urdf(text: str, source: str) -> Element:
    """The root element of a URDF text whose names, number of links and tree of joints have been checked.

    Raises InputError, naming ``source`` and the element, for malformed XML, another root element, entities, missing or
    repeated names, more than ``MAX_LINKS`` links, and joints that do not make a tree on one base.
    """
    if len(text) > MAX_BYTES:
        raise InputError(f"{source}: {len(text)} characters, expected a URDF of at most {MAX_BYTES}")
    if "<!ENTITY" in text:
        raise InputError(f"{source}: declares XML entities, which a URDF does not need; expand xacro before loading")
    try:
        parser = ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))
        root = ElementTree.fromstring(text, parser=parser)
    except (ElementTree.ParseError, ValueError, RecursionError) as error:
        raise InputError(f"{source}: malformed XML ({error}), expected a URDF") from None
    if root.tag != "robot":
        raise InputError(
            f"{source}: the root element is <{root.tag}>, expected <robot> of a URDF or <mujoco> of a MuJoCo model"
        )
    links, joints = root.findall("link"), root.findall("joint")
    for elements, kind in ((links, "links"), (joints, "joints")):
        if len(elements) > MAX_LINKS:
            raise InputError(
                f"{source}: {len(elements)} {kind}, expected at most {MAX_LINKS}; leave out all but the arm"
            )
    _check_names(links, source)
    _check_names(joints, source)
    _check_tree(links, joints, source)
    return root


def read_description(text: str, source: str) -> Description:
    """The description in a URDF text whose joints are revolute, continuous, prismatic or fixed.

    Raises InputError like ``parse_urdf``, and for joints of another kind, joints that mimic others, no moving joint or more
    than ``MAX_JOINTS``, and numbers that are malformed, not finite, negative masses or too large for an arm.
    """
    root = parse_urdf(text, source)
    links = [_link(element, source) for element in root.findall("link")]
    joints = tuple(_joint(element, source) for element in root.findall("joint"))
    moving = [joint.name for joint in joints if joint.kind in MOVING]
    if not moving:
        raise InputError(f"{source}: no moving joint, expected at least one revolute, continuous or prismatic joint")
    if len(moving) > MAX_JOINTS:
        raise InputError(
            f"{source}: {len(moving)} moving joints ({', '.join(moving[:6])}, ...), expected at most {MAX_JOINTS}; pick those of one arm with --joints, or joints=[...] in Python"
        )
    children = {joint.child for joint in joints}
    base = next(link.name for link in links if link.name not in children)
    name = root.get("name") or "robot"
    return Description(name=name, root=base, links={link.name: link for link in links}, joints=joints)


def joint_place(joint: Element, source: str) -> tuple[Array, Array]:
    """Rotation (3, 3) and translation (3,) [m] of a joint element's origin."""
    return _placement(joint.find("origin"), f"{source}: joint {joint.get('name')!r} origin")


def joint_axis(joint: Element, source: str) -> Array:
    """Unit axis (3,) of a joint element; raises InputError where it is zero."""
    where = f"{source}: joint {joint.get('name')!r}"
    axis = np.array(read_triple(joint.find("axis"), "xyz", f"{where} axis", default="1 0 0"))
    if not axis.any():
        raise InputError(f'{where}: its axis is zero, expected a direction such as "0 0 1"')
    return axis / np.linalg.norm(axis)


def _link(element: Element, source: str) -> UrdfLink:
    name, inertial = element.attrib["name"], element.find("inertial")
    if inertial is None:
        return UrdfLink(name=name, mass=0.0, centre=np.zeros(3), inertia=np.zeros((3, 3)))
    where = f"{source}: link {name!r}"
    mass = read_number(inertial.find("mass"), "value", where, "mass", minimum=0.0)
    tensor = inertial.find("inertia")
    keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    xx, xy, xz, yy, yz, zz = (read_number(tensor, key, where, f"inertia {key}") for key in keys)
    R, centre = _placement(inertial.find("origin"), f"{where} inertial origin")
    inertia = R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T
    return UrdfLink(name=name, mass=mass, centre=centre, inertia=inertia)


def _joint(element: Element, source: str) -> UrdfJoint:
    name, kind = element.attrib["name"], element.get("type")
    where = f"{source}: joint {name!r}"
    if kind not in (*MOVING, "fixed"):
        raise InputError(
            f"{where} is {kind!r}, expected revolute, continuous, prismatic or fixed (arms have a fixed base)"
        )
    if kind != "fixed" and element.find("mimic") is not None:
        raise InputError(f"{where} mimics another joint; expected independent joints: lock it or drop <mimic>")
    R, p = joint_place(element, source)
    axis, limits = np.array([1.0, 0.0, 0.0]), (-math.inf, math.inf, math.inf, math.inf)
    if kind != "fixed":
        axis, limits = joint_axis(element, source), _limits(element.find("limit"), str(kind), where)
    lower, upper, velocity, effort = limits
    ends = [element.find(end).attrib["link"] for end in ("parent", "child")]  # pyright: ignore[reportOptionalMemberAccess]
    return UrdfJoint(
        name=name, kind=str(kind), parent=ends[0], child=ends[1], rotation=R, translation=p, axis=axis,
        lower=lower, upper=upper, velocity=velocity, effort=effort,
    )  # fmt: skip


def _limits(limit: Element | None, kind: str, where: str) -> tuple[float, float, float, float]:
    """Lower, upper, velocity and effort limit."""
    if limit is None and kind == "continuous":
        return -math.inf, math.inf, math.inf, math.inf
    largest = math.inf
    effort, velocity = (
        read_number(limit, key, where, f"limit {key}", minimum=0.0, largest=largest) for key in ("effort", "velocity")
    )
    if kind == "continuous":
        return -math.inf, math.inf, velocity, effort
    stated = Element("limit", {key: limit.get(key, "0") for key in ("lower", "upper")} if limit is not None else {})
    lower, upper = (read_number(stated, key, where, f"limit {key}", largest=largest) for key in ("lower", "upper"))
    if lower > upper:
        raise InputError(f"{where}: limit lower {lower:g} is above its upper {upper:g}; swap them")
    return lower, upper, velocity, effort


def _placement(origin: Element | None, where: str) -> tuple[Array, Array]:
    import pinocchio

    xyz, rpy = read_triple(origin, "xyz", where), read_triple(origin, "rpy", where)
    return pinocchio.rpy.rpyToMatrix(*rpy), np.array(xyz)


def _check_names(elements: list[Element], source: str) -> None:
    seen: set[str] = set()
    for number, element in enumerate(elements, 1):
        name = element.get("name")
        if not name:
            raise InputError(f"{source}: {element.tag} {number} has no name, expected one")
        if name in seen:
            raise InputError(f"{source}: {element.tag} {name!r} is given twice, expected each name once")
        seen.add(name)


def _check_tree(links: list[Element], joints: list[Element], source: str) -> None:
    """Every link but one hangs on one joint, and following parents from any link leads to that one."""
    names = {link.attrib["name"] for link in links}
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
    if not links:
        raise InputError(
            f"{source}: no link found, expected links and joints; run xacro first if this holds macros only"
        )
    roots = [link.attrib["name"] for link in links if link.attrib["name"] not in parents]
    if len(roots) != 1:
        found = ", ".join(roots[:5]) or "none: the joints close a loop"
        raise InputError(f"{source}: {len(roots)} root links ({found}), expected one: the base")
    reached = {roots[0]}
    for link in links:
        name, path = link.attrib["name"], set()
        while name not in reached and name not in path:
            path.add(name)
            name = parents[name]
        if name not in reached:
            raise InputError(f"{source}: link {name!r} is in a loop of joints, expected a tree")
        reached.update(path)
