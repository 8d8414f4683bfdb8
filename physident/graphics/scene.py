"""The arm in 3D: its links in motion, coloured by the size of their residual, and the path of its tool."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from physident.graphics import style
from physident.graphics.labels import log_joint_names
from physident.graphics.session.log import duration, rgb
from physident.graphics.visuals import Visual, arm_visuals, turned_to
from physident.robots.robot import Robot

if TYPE_CHECKING:
    import rerun as rr

Array = NDArray[np.float64]
NEUTRAL, BASE = "#C8C8C8", "#6E6E6E"
PATH_POINTS = 4000


def link_poses(robot: Robot, q: Array) -> tuple[Array, Array]:
    """Rotations (n, N, 3, 3) and positions (n, N, 3) [m] of the joints' frames in the base frame at positions (N, n)."""
    rotations, positions = np.empty((robot.n, len(q), 3, 3)), np.empty((robot.n, len(q), 3))
    for i, joint in enumerate(robot.joints):
        R, p = joint.rotation[None], joint.translation[None]
        if joint.parent >= 0:
            before = rotations[joint.parent]
            R, p = before @ R, positions[joint.parent] + before @ joint.translation
        if joint.kind == "prismatic":
            rotations[i], positions[i] = R, p + (R @ joint.axis) * q[:, i : i + 1]
        else:
            rotations[i], positions[i] = R @ _turns(joint.axis, q[:, i]), p
    return rotations, positions


def tool_path(robot: Robot, rotations: Array, positions: Array) -> Array:
    """The tool's position (N, 3) [m] in the base frame, from the poses that ``link_poses`` returns."""
    return positions[-1] + rotations[-1] @ robot.tool


def log_arm(
    rec: rr.RecordingStream,
    root: str,
    robot: Robot,
    clock: Array,
    q: Array,
    meshes: str | Path | None,
    *,
    cover: tuple[float, Array] | None = None,
    marked: Mapping[int, str] | None = None,
) -> Array:
    """Log the arm in motion through positions (N, n) at instants (N,) [s], and the path of its tool.

    ``cover`` is an instant [s] before the first, and the positions (n,) that are shown then. The names of the joints of
    ``marked`` (from 1) have its colours "#RRGGBB". Returns the points (P, 3) [m] of its joints and its tool along the motion,
    in the base frame.
    """
    import rerun as rr
    from scipy.spatial.transform import Rotation

    rec.log(root, rr.Transform3D(mat3x3=upright(robot.gravity)), rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    if cover is not None:
        clock, q = np.append(cover[0], clock), np.vstack([cover[1], q])
    rotations, positions = link_poses(robot, q)
    for i in range(robot.n):
        quaternions = Rotation.from_matrix(rotations[i]).as_quat()
        pose = rr.Transform3D.columns(translation=positions[i], quaternion=quaternions)
        rec.send_columns(f"{root}/link_{i + 1}", [duration(clock)], pose)
    log_joint_names(rec, root, clock, positions, upright(robot.gravity), marked or {})
    for name, visuals in _by_link(arm_visuals(robot, meshes)).items():
        for number, visual in enumerate(visuals):
            rec.log(f"{root}/{name}/shape_{number}", *_logged(visual), static=True)
            # a static colour would hide the colours over time
            start, colour = duration(clock[:1]), np.array([rgb(BASE if name == "base" else NEUTRAL)], dtype=np.uint8)
            rec.send_columns(f"{root}/{name}/shape_{number}", [start], _colour_columns(visual, colour))
    path = tool_path(robot, rotations, positions)
    moved = path if cover is None else path[1:]
    thin = moved[:: max(1, len(moved) // PATH_POINTS)]
    line = rr.LineStrips3D([thin], colors=[[*rgb(style.SESSION_MEASURED), 60]], radii=rr.Radius.ui_points(0.4))
    rec.log(f"{root}/tool_path", line, static=True)
    rec.send_columns(f"{root}/tool", [duration(clock)], rr.Points3D.columns(positions=path))
    rec.log(f"{root}/tool", rr.Points3D.from_fields(colors=[rgb(style.RESIDUAL)], radii=[0.015]), static=True)
    return np.concatenate([path, positions.reshape(-1, 3)])


def colour_links(
    rec: rr.RecordingStream, root: str, robot: Robot, time: Array, share: Array, meshes: str | Path | None
) -> None:
    """Colour each link at instants (M,) [s] by a share (M, n): 0 and NaN are grey, 1 and more the residual's colour."""
    low, high = np.array(rgb(NEUTRAL), dtype=float), np.array(rgb(style.RESIDUAL), dtype=float)
    level = np.clip(np.nan_to_num(share), 0.0, 1.0)
    for name, visuals in _by_link(arm_visuals(robot, meshes)).items():
        if name == "base":
            continue
        joint = visuals[0].joint
        colours = np.round(low + level[:, joint : joint + 1] * (high - low)).astype(np.uint8)
        for number, visual in enumerate(visuals):
            rec.send_columns(f"{root}/{name}/shape_{number}", [duration(time)], _colour_columns(visual, colours))


def _by_link(visuals: Sequence[Visual]) -> dict[str, list[Visual]]:
    """Visuals by the name of their link's entity."""
    links: dict[str, list[Visual]] = {}
    for visual in visuals:
        links.setdefault("base" if visual.joint < 0 else f"link_{visual.joint + 1}", []).append(visual)
    return links


def _logged(visual: Visual) -> list[Any]:
    """The rerun archetypes of a visual: its geometry and its pose."""
    import rerun as rr

    pose: dict[str, Any] = {"translation": visual.translation, "mat3x3": visual.rotation}
    solid = rr.components.FillMode.Solid
    if visual.kind == "mesh":
        pose["mat3x3"] = visual.rotation * np.array(visual.size)
        return [rr.Asset3D(path=visual.mesh, media_type=_media_type(visual.mesh)), rr.Transform3D(**pose)]
    if visual.kind == "box":
        drawn: Any = rr.Boxes3D(sizes=[visual.size], fill_mode=solid)
    elif visual.kind == "sphere":
        drawn = rr.Ellipsoids3D(radii=[visual.size[0]], fill_mode=solid)
    elif visual.kind == "cylinder":
        drawn = rr.Cylinders3D(radii=[visual.size[0]], lengths=[visual.size[1]], fill_mode=solid)
    else:
        drawn = rr.Capsules3D(radii=[visual.size[0]], lengths=[visual.size[1]], fill_mode=solid)
    return [drawn, rr.Transform3D(**pose)]


def _media_type(mesh: Path | None) -> str | None:
    """The type of a mesh that the SDK does not know by its file's ending, though the viewer draws it."""
    return "model/vnd.collada+xml" if mesh is not None and mesh.suffix.lower() == ".dae" else None


def _colour_columns(visual: Visual, colours: NDArray[np.uint8]) -> Any:
    import rerun as rr

    if visual.kind == "mesh":
        return rr.Asset3D.columns(albedo_factor=colours)
    kinds = {"box": rr.Boxes3D, "sphere": rr.Ellipsoids3D, "cylinder": rr.Cylinders3D, "capsule": rr.Capsules3D}
    return kinds[visual.kind].columns(colors=colours)


def _turns(axis: Array, angle: Array) -> Array:
    """Rotations (N, 3, 3) about a unit axis (3,) by angles (N,) [rad] (Rodrigues)."""
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle)[:, None, None] * K + (1 - np.cos(angle))[:, None, None] * (K @ K)


def upright(gravity: Sequence[float]) -> Array:
    """The rotation (3, 3) of the base frame that makes gravity point down on the screen; identity without gravity."""
    if not np.any(gravity) or np.allclose(np.asarray(gravity) / np.linalg.norm(gravity), [0, 0, -1]):
        return np.eye(3)
    return turned_to(-np.asarray(gravity)).T


def tint(
    rec: rr.RecordingStream, root: str, robot: Robot, start: float, colour: Sequence[int], meshes: str | Path | None
) -> None:
    """Give every shape of an arm that ``log_arm`` logged one colour, red to alpha (4,), from an instant [s] on."""
    colours = np.array([colour], dtype=np.uint8)
    for name, visuals in _by_link(arm_visuals(robot, meshes)).items():
        for number, visual in enumerate(visuals):
            columns = _colour_columns(visual, colours)
            rec.send_columns(f"{root}/{name}/shape_{number}", [duration(np.array([start]))], columns)
