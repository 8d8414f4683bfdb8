"""Which joints of a description move: the arm's. Fingers, mobile bases and other arms are locked at a stated position."""

from __future__ import annotations

import fnmatch
import math
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass
from difflib import get_close_matches
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError, warn
from physident.robots.urdf import MOVING, joint_axis, joint_place, parse_urdf
from physident.robots.urdf_numbers import parse_plain

CARRIERS = ("floating", "planar")  # joints of mobile bases: several coordinates each
LISTED = 12  # names in a message
Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class LockedJoint:
    """A joint that the description lets move and that is fixed here, at ``position`` [rad|m], and the reason for it."""

    name: str
    kind: str
    position: float
    reason: str

    def __repr__(self) -> str:
        unit = "m" if self.kind == "prismatic" else "rad"
        place = "where it is described" if self.kind in CARRIERS else f"at {self.position:g} {unit}"
        return f"{self.name} {place} ({self.reason})"


@dataclass(frozen=True, kw_only=True)
class JointSelection:
    """A URDF text in which only the chosen joints move, their order, None for the description's, and what was locked."""

    urdf: str
    order: tuple[str, ...] | None
    locked: tuple[LockedJoint, ...]


def select_joints(
    text: str,
    source: str,
    *,
    joints: Sequence[str] | Set[str] | None = None,
    lock: Mapping[str, float] | None = None,
    rest: Mapping[str, float] | None = None,
) -> JointSelection:
    """The description with only ``joints`` moving, in their order; by default all that are driven on their own.

    ``joints`` are names or patterns such as "panda_joint*"; a set of them has the description's order. All others are
    locked: at their value in ``lock`` [rad|m], where the joint that they mimic puts them, at their value in ``rest``, or at
    zero or the limit next to it. Without ``joints``, floating and planar joints, joints that mimic another, and the joints
    that these mimic are locked. Raises InputError for names that are unknown, repeated, chosen and locked at once, or in an
    order that is not from base to tip.
    """
    root = parse_urdf(text, source)
    elements = {e.attrib["name"]: e for e in root.findall("joint") if e.get("type") in (*MOVING, *CARRIERS)}
    lock = dict(lock or {})
    for name, value in lock.items():
        _check_known([name], elements, "lock", source)
        _check_position(elements[name], value, source)
    mimicked = _mimicked(elements, source)
    ordered = joints is not None and not isinstance(joints, Set)
    named = sorted(joints) if isinstance(joints, Set) else joints
    chosen = _chosen(elements, mimicked, named, lock, source)
    positions = _positions(elements, mimicked, lock, rest or {})
    locked = tuple(
        LockedJoint(
            name=name, kind=str(e.get("type")), position=positions[name], reason=_reason(name, e, mimicked, lock)
        )
        for name, e in elements.items()
        if name not in chosen
    )
    for name, (other, _, _) in mimicked.items():
        if other in chosen:
            warn(
                f"{source}: {name} mimics {other}, which moves; here it stays at {positions[name]:g}, so its motion is lost"
            )
    for one in locked:
        _fix(elements[one.name], one.position, source)
    urdf = ElementTree.tostring(root, encoding="unicode") + "\n" if locked else text
    return JointSelection(urdf=urdf, order=chosen if ordered else None, locked=locked)


def _chosen(
    elements: Mapping[str, Element],
    mimicked: Mapping[str, tuple[str, float, float]],
    joints: Sequence[str] | None,
    lock: Mapping[str, float],
    source: str,
) -> tuple[str, ...]:
    coupled = {*mimicked, *(other for other, _, _ in mimicked.values())}
    own = [name for name, e in elements.items() if e.get("type") in MOVING]
    if joints is None:
        chosen = tuple(name for name in own if name not in coupled and name not in lock)
        if not chosen and own:
            raise InputError(f"{source}: every joint is locked or mimics another, expected at least one that moves")
        return chosen
    chosen = tuple(name for entry in joints for name in _matching(entry, own, elements, source))
    if not chosen:
        raise InputError(f"{source}: no joints were chosen, expected some of {_listed(own)}")
    if repeated := [name for name in chosen if chosen.count(name) > 1]:
        raise InputError(f"{source}: joint {repeated[0]!r} is chosen twice, expected each joint once")
    if both := [name for name in chosen if name in lock]:
        raise InputError(f"{source}: joint {both[0]!r} is chosen to move and locked, expected one of both")
    if follower := [name for name in chosen if name in mimicked]:
        raise InputError(
            f"{source}: joint {follower[0]!r} mimics {mimicked[follower[0]][0]!r}, expected joints that are driven on their own"
        )
    return chosen


def _matching(entry: str, own: Sequence[str], elements: Mapping[str, Element], source: str) -> list[str]:
    """The joints that a name or a pattern means."""
    if entry in own:
        return [entry]
    if entry in elements:
        raise InputError(
            f"{source}: joint {entry!r} is {elements[entry].get('type')}, expected one with one coordinate"
        )
    if found := [name for name in own if fnmatch.fnmatchcase(name, entry)]:
        return found
    _check_known([entry], own, "joints", source)
    return []


def _check_known(names: Iterable[str], known: Iterable[str], option: str, source: str) -> None:
    known = list(known)
    for name in names:
        if name not in known:
            close = get_close_matches(name, known, 1)
            meant = f"did you mean {close[0]!r}? " if close else ""
            raise InputError(f"{source}: {option}: no moving joint {name!r}; {meant}expected some of {_listed(known)}")


def _check_position(joint: Element, value: float, source: str) -> None:
    name, kind = joint.attrib["name"], joint.get("type")
    if kind in CARRIERS:
        raise InputError(f"{source}: lock: joint {name!r} is {kind} and stays where it is described; expected no value")
    lower, upper = _range(joint)
    if type(value) not in (int, float) or not lower - 1e-9 <= value <= upper + 1e-9:
        raise InputError(
            f"{source}: lock: {name} = {value!r}, expected a number within its limits, {lower:g} to {upper:g}"
        )


def _range(joint: Element) -> tuple[float, float]:
    """The limits of a joint's position, infinite where it states none that can be read."""
    limit = joint.find("limit")
    if limit is None or joint.get("type") == "continuous":
        return -math.inf, math.inf
    lower, upper = (parse_plain(limit.get(key, "0")) for key in ("lower", "upper"))
    return (lower, upper) if lower <= upper else (-math.inf, math.inf)


def _mimicked(elements: Mapping[str, Element], source: str) -> dict[str, tuple[str, float, float]]:
    """For each joint that mimics: the other joint, and multiplier and offset of its position."""
    result = {}
    for name, joint in elements.items():
        if (mimic := joint.find("mimic")) is None:
            continue
        multiplier, offset = parse_plain(mimic.get("multiplier", "1")), parse_plain(mimic.get("offset", "0"))
        if not (math.isfinite(multiplier) and math.isfinite(offset)):
            raise InputError(
                f"{source}: joint {name!r} mimics another with {dict(mimic.attrib)}; expected multiplier and offset in plain digits"
            )
        result[name] = (mimic.get("joint", ""), multiplier, offset)
    return result


def _positions(
    elements: Mapping[str, Element],
    mimicked: Mapping[str, tuple[str, float, float]],
    lock: Mapping[str, float],
    rest: Mapping[str, float],
) -> dict[str, float]:
    """Where each joint stands when it is locked."""
    result = {}
    for name, joint in elements.items():
        lower, upper = _range(joint)
        result[name] = lock[name] if name in lock else min(max(rest.get(name, 0.0), lower), upper)
    for _ in mimicked:  # a joint may mimic one that mimics another
        for name, (other, multiplier, offset) in mimicked.items():
            if name not in lock and other in result:  # hands are shipped whose fingers mimic joints of another hand
                result[name] = multiplier * result[other] + offset
    return result


def _reason(
    name: str, joint: Element, mimicked: Mapping[str, tuple[str, float, float]], lock: Mapping[str, float]
) -> str:
    if name in lock:
        return "as given"
    if joint.get("type") in CARRIERS:
        return f"a {joint.get('type')} base"
    if name in mimicked:
        return f"mimics {mimicked[name][0]}"
    followers = [follower for follower, (other, _, _) in mimicked.items() if other == name]
    return f"mimicked by {followers[0]}" if followers else "not chosen"


def _fix(joint: Element, position: float, source: str) -> None:
    """Turn a joint element into a fixed one at a position."""
    kind = joint.get("type")
    if kind in MOVING and position:
        _move_origin(joint, position, source)
    joint.set("type", "fixed")
    for tag in ("mimic", "limit", "dynamics", "safety_controller", "calibration"):
        for element in joint.findall(tag):
            joint.remove(element)


def _move_origin(joint: Element, position: float, source: str) -> None:
    import pinocchio as pin

    rotation, translation = joint_place(joint, source)
    axis = joint_axis(joint, source)
    if joint.get("type") == "prismatic":
        translation = translation + rotation @ axis * position
    else:
        rotation = rotation @ pin.exp3(axis * position)
    for old in joint.findall("origin"):
        joint.remove(old)
    numbers = (
        " ".join(repr(float(x) + 0.0) for x in values) for values in (translation, pin.rpy.matrixToRpy(rotation))
    )
    joint.append(Element("origin", dict(zip(("xyz", "rpy"), numbers, strict=True))))


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
    return ", ".join(names[:LISTED]) + more
