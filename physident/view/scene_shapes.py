"""What an arm looks like: the shapes of its URDF where they can be had, capsules between its joints otherwise."""

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

Array = NDArray[np.float64]
MESHES = (".stl", ".obj", ".glb", ".gltf", ".dae")  # what the viewer reads
THICKNESS = 0.045  # radius of a capsule as a share of the arm's length: looks like an industrial arm's
SHORT = 0.02  # of the arm's length: joints nearer to each other get no capsule between them


@dataclass(frozen=True, eq=False)
class Shape:
    """A box, cylinder, sphere, capsule or mesh in the frame of a joint (index from 0, -1 the base).

    ``rotation`` (3, 3) and ``translation`` (3,) [m] place its own frame; ``size`` [m]: three sides; radius and length along
    z, for a capsule between the centres of its ends; radius; a mesh's three scales. ``mesh`` is the file.
    """

    kind: str
    joint: int
    rotation: Array
    translation: Array
    size: tuple[float, ...]
    mesh: Path | None = None


def arm_shapes(robot: Robot, folder: str | Path | None = None) -> list[Shape]:
    """Shapes of every link: its visuals where all of them can be had, else capsules.

    ``folder`` is where meshes are looked for, by the whole path after ``package://`` and by its ends; beside it the
    packages that ROS knows, and paths that exist as they stand.
    """
    visuals = _visuals(robot, folder)
    capsules = _capsules(robot)
    seen = {shape.joint for shape in visuals}
    return visuals + [capsule for capsule in capsules if capsule.joint not in seen]


def _visuals(robot: Robot, folder: str | Path | None) -> list[Shape]:
    frames = {frame.name: frame for frame in robot.pinocchio.frames}
    found: dict[int, list[Shape | None]] = {}
    for link in ElementTree.fromstring(robot.urdf).findall("link"):
        frame = frames.get(link.get("name", ""))
        if frame is None:
            continue
        joint = frame.parentJoint - 1
        for visual in link.findall("visual"):
            shape = _visual(visual, joint, frame.placement.rotation, frame.placement.translation, folder)
            found.setdefault(joint, []).append(shape)
    complete = [shapes for shapes in found.values() if None not in shapes]
    return [shape for shapes in complete for shape in shapes if shape is not None]


def _visual(visual: Any, joint: int, rotation: Array, translation: Array, folder: str | Path | None) -> Shape | None:
    """The shape of a <visual>, None where it cannot be read or its mesh is not there."""
    from scipy.spatial.transform import Rotation

    try:
        origin = visual.find("origin")
        xyz, rpy = (_numbers(origin, key, "0 0 0", 3) for key in ("xyz", "rpy"))
        own = Rotation.from_euler("xyz", rpy).as_matrix()
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
    except (AttributeError, StopIteration, ValueError):  # a picture is not worth refusing a robot
        return None
    return Shape(kind, joint, rotation @ own, translation + rotation @ np.array(xyz), tuple(size), mesh)


def _numbers(element: Any, key: str, default: str, count: int) -> list[float]:
    text = default if element is None else element.get(key, default)
    values = [float(x) for x in text.split()]
    if len(values) != count or not np.isfinite(values).all():
        raise ValueError(text)
    return values


def _mesh_file(name: str, folder: str | Path | None) -> Path | None:
    """The file of a mesh, None where there is none that the viewer reads."""
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
        candidates += [Path(root, path) for root in roots if root]
    return next((candidate for candidate in candidates if candidate.is_file()), None)


def _capsules(robot: Robot) -> list[Shape]:
    """For each joint a short capsule along its axis, and one to each joint after it or to the tool."""
    offsets = np.array([joint.translation for joint in robot.joints])
    length = float(np.linalg.norm(offsets, axis=1).sum() + np.linalg.norm(robot.tool)) or 1.0
    shapes = []
    for index in range(-1, robot.n):
        radius = THICKNESS * length * (1 - 0.5 * (index + 1) / robot.n)
        ends = [joint.translation for joint in robot.joints if joint.parent == index]
        if index == robot.n - 1:
            ends.append(robot.tool)
        shapes += [
            _between(index, np.zeros(3), end, 0.8 * radius) for end in ends if np.linalg.norm(end) > SHORT * length
        ]
        if index >= 0:
            axis = robot.joints[index].axis
            shapes.append(_between(index, -0.6 * radius * axis, 0.6 * radius * axis, radius))
    return shapes


def _between(joint: int, start: Array, end: Array, radius: float) -> Shape:
    """A capsule with the centres of its ends at two points (3,) [m] of a joint's frame."""
    return Shape("capsule", joint, turned_to(end - start), start, (radius, float(np.linalg.norm(end - start))))


def turned_to(direction: Sequence[float] | Array) -> Array:
    """A rotation (3, 3) that turns the z axis into a direction (3,)."""
    z = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    x = np.eye(3)[int(np.argmin(np.abs(z)))]
    y = np.array(np.cross(z, x), dtype=float)
    y /= np.linalg.norm(y)
    return np.column_stack([np.array(np.cross(y, z), dtype=float), y, z])
