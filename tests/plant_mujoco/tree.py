"""The joints of a serial arm, read from its URDF."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
KINDS: dict[str, Literal["hinge", "slide"]] = {"revolute": "hinge", "continuous": "hinge", "prismatic": "slide"}


@dataclass(frozen=True, eq=False)
class Joint:
    """One moving joint: its ``place`` (4, 4) in the frame of the joint before it, and its ``axis`` (3,) in its own frame."""

    name: str
    kind: Literal["hinge", "slide"]
    place: Array
    axis: Array


@dataclass(frozen=True, eq=False)
class Tree:
    """The n moving joints from the base on, and the ``tool`` (4, 4) in the frame of the last one."""

    joints: tuple[Joint, ...]
    tool: Array


def read_tree(urdf: str, tool: str) -> Tree:
    """The chain from the base to the frame ``tool``; ValueError where a moving joint lies beside it."""
    root = ET.fromstring(urdf)
    elements = root.findall("joint")
    by_child = {_link(e, "child"): e for e in elements}
    names = {e.get("name"): _link(e, "child") for e in elements}
    link = tool if root.find(f"link[@name='{tool}']") is not None else names[tool]
    chain: list[ET.Element] = []
    while link in by_child:
        chain.insert(0, by_child[link])
        link = _link(chain[0], "parent")
    joints: list[Joint] = []
    place = np.eye(4)
    for element in chain:
        place = place @ _origin(element)
        if (kind := element.get("type", "")) == "fixed":
            continue
        axis = _numbers(element.find("axis"), "xyz", "1 0 0")
        joints.append(Joint(str(element.get("name")), KINDS[kind], place, axis / np.linalg.norm(axis)))
        place = np.eye(4)
    if len(joints) != sum(e.get("type") != "fixed" for e in elements):
        raise ValueError(f"the joints of {root.get('name')} do not form one chain to {tool}")
    return Tree(tuple(joints), place)


def _link(element: ET.Element, end: str) -> str:
    found = element.find(end)
    assert found is not None
    return found.attrib["link"]


def _numbers(element: ET.Element | None, name: str, default: str) -> Array:
    text = default if element is None else element.get(name, default)
    return np.array([float(word) for word in text.split()])


def _origin(joint: ET.Element) -> Array:
    """Placement (4, 4) of a joint in its parent link; roll, pitch and yaw turn about fixed axes x, y, z."""
    origin = joint.find("origin")
    place = np.eye(4)
    place[:3, 3] = _numbers(origin, "xyz", "0 0 0")
    for axis, angle in enumerate(_numbers(origin, "rpy", "0 0 0")):
        place[:3, :3] = _turn(axis, angle) @ place[:3, :3]
    return place


def _turn(axis: int, angle: float) -> Array:
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(3)
    turn[i, i] = turn[j, j] = np.cos(angle)
    turn[j, i], turn[i, j] = np.sin(angle), -np.sin(angle)
    return turn
