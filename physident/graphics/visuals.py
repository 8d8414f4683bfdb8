"""What an arm looks like: the visuals of its URDF, or capsules between its joints where these cannot be read."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlparse
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from physident.robots.robot import Robot
from physident.robots.sources import packaged_meshes

Array = NDArray[np.float64]
MESHES = (".stl", ".obj", ".glb", ".gltf", ".dae")  # formats that the viewer reads
THICKNESS = 0.045  # radius of a capsule as a share of the arm's length, as of an industrial arm
SHORT = 0.02  # of the arm's length: joints closer than this get no capsule between them


@dataclass(frozen=True, eq=False)
class Visual:
    """A box, cylinder, sphere, capsule or mesh in the frame of a joint (index from 0, -1 the base).

    ``rotation`` (3, 3) and ``translation`` (3,) [m] are its pose there. ``size`` [m] is three sides for a box, radius and
    length along z for a cylinder or a capsule (between the centres of its ends), a radius for a sphere, and three scales
    for a mesh, whose file is ``mesh``.
    """

    kind: str
    joint: int
    rotation: Array
    translation: Array
    size: tuple[float, ...]
    mesh: Path | None = None


def arm_visuals(robot: Robot, folder: str | Path | None = None) -> list[Visual]:
    """The visuals of every link, or capsules for a link with a visual that cannot be read.

    Meshes are searched in ``folder``, by the path after ``package://`` and by the ends of that path, then in the package
    folders of ROS's environment variables and in the installed package of descriptions; other paths are used as they are.
    """
    visuals = _visuals(robot, folder)
    capsules = _capsules(robot)
    shown = {visual.joint for visual in visuals}
    return visuals + [capsule for capsule in capsules if capsule.joint not in shown]


def _visuals(robot: Robot, folder: str | Path | None) -> list[Visual]:
    frames = {frame.name: frame for frame in robot.pinocchio.frames}
    found: dict[int, list[Visual | None]] = {}
    for link in ElementTree.fromstring(robot.urdf).findall("link"):
        frame = frames.get(link.get("name", ""))
        if frame is None:
            continue
        joint = frame.parentJoint - 1
        for visual in link.findall("visual"):
            read = _visual(visual, joint, frame.placement.rotation, frame.placement.translation, folder)
            found.setdefault(joint, []).append(read)
    complete = [visuals for visuals in found.values() if None not in visuals]
    return [visual for visuals in complete for visual in visuals if visual is not None]


def _visual(visual: Any, joint: int, rotation: Array, translation: Array, folder: str | Path | None) -> Visual | None:
    """The visual of a URDF element, None where it cannot be read or its mesh does not exist."""
    from scipy.spatial.transform import Rotation

    try:
        origin = visual.find("origin")
        xyz, rpy = (_numbers(origin, key, "0 0 0", 3) for key in ("xyz", "rpy"))
        turned = Rotation.from_euler("xyz", rpy).as_matrix()
        geometry = visual.find("geometry")
        kind = next(tag for tag in ("box", "cylinder", "sphere", "mesh") if geometry.find(tag) is not None)
        element = geometry.find(kind)
        mesh = None
        if kind == "box":
            size = _numbers(element, "size", "", 3)
        elif kind == "mesh":
            size, mesh = _numbers(element, "scale", "1 1 1", 3), _mesh_file(element.get("filename", ""), folder)
            if mesh is None:
                return None
        else:
            keys = ("radius", "length") if kind == "cylinder" else ("radius",)
            size = [_numbers(element, key, "", 1)[0] for key in keys]
    except (AttributeError, StopIteration, ValueError):  # a robot is not refused for its looks
        return None
    return Visual(kind, joint, rotation @ turned, translation + rotation @ np.array(xyz), tuple(size), mesh)


def _numbers(element: Any, key: str, default: str, count: int) -> list[float]:
    text = default if element is None else element.get(key, default)
    values = [float(x) for x in text.split()]
    if len(values) != count or not np.isfinite(values).all():
        raise ValueError(text)
    return values


def _mesh_file(name: str, folder: str | Path | None) -> Path | None:
    """The file of a mesh, None where it does not exist or the viewer cannot read its format."""
    if not name.lower().endswith(MESHES):
        return None
    parsed = urlparse(name)
    path = Path(unquote(parsed.netloc + parsed.path)) if parsed.scheme else Path(name)
    candidates = [path] if parsed.scheme != "package" else []
    if folder is not None:
        candidates += [Path(folder, *path.parts[start:]) for start in range(path.is_absolute(), len(path.parts))]
    if parsed.scheme == "package":
        roots = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
        roots += [os.path.join(p, "share") for p in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p]
        roots += [str(found)] if (found := packaged_meshes()) is not None else []
        candidates += [Path(root, path) for root in roots if root]
    return next((candidate for candidate in candidates if candidate.is_file()), None)


def _capsules(robot: Robot) -> list[Visual]:
    """For each joint a short capsule along its axis, and one to each child joint or to the tool."""
    offsets = np.array([joint.translation for joint in robot.joints])
    length = float(np.linalg.norm(offsets, axis=1).sum() + np.linalg.norm(robot.tool)) or 1.0
    capsules = []
    for index in range(-1, robot.n):
        radius = THICKNESS * length * (1 - 0.5 * (index + 1) / robot.n)
        ends = [joint.translation for joint in robot.joints if joint.parent == index]
        if index == robot.n - 1:
            ends.append(robot.tool)
        capsules += [
            _between(index, np.zeros(3), end, 0.8 * radius) for end in ends if np.linalg.norm(end) > SHORT * length
        ]
        if index >= 0:
            axis = robot.joints[index].axis
            capsules.append(_between(index, -0.6 * radius * axis, 0.6 * radius * axis, radius))
    return capsules


def _between(joint: int, start: Array, end: Array, radius: float) -> Visual:
    """A capsule with the centres of its ends at two points (3,) [m] of a joint's frame."""
    return Visual("capsule", joint, turned_to(end - start), start, (radius, float(np.linalg.norm(end - start))))


def turned_to(direction: Sequence[float] | Array) -> Array:
    """A rotation (3, 3) that turns the z axis into a direction (3,)."""
    z = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    x = np.eye(3)[int(np.argmin(np.abs(z)))]
    y = np.array(np.cross(z, x), dtype=float)
    y /= np.linalg.norm(y)
    return np.column_stack([np.array(np.cross(y, z), dtype=float), y, z])
