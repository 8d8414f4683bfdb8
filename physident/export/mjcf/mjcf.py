"""Writes a model as MJCF, the language of MuJoCo: bodies, joints, motors, and the shapes of the robot's description."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from physident.dynamics.model import Model
from physident.estimation.estimate import Estimate
from physident.export.held import Held
from physident.export.mjcf.shapes import assets, shapes
from physident.export.mjcf.values import MjcfValues, element, inertial, mjcf_values, numbers
from physident.export.urdf import fixed_links
from physident.export.urdf_edit import MARK, parse_elements
from physident.files import write_text
from physident.graphics.visuals import arm_visuals
from physident.robots.inertia import violations
from physident.robots.robot import Robot

Array = NDArray[np.float64]
INDENT = "  "
# A joint that sticks in MuJoCo creeps in proportion to one minus the impedance and to the time constant of its friction:
# these values give a ten-thousandth of the speed of the default ones
STIFF = {"solimpfriction": "0.9999 0.9999 0.001 0.5 2", "solreffriction": "0.002 1"}
HEAD = (
    element("compiler", {"angle": "radian", "autolimits": "true", "inertiafromgeom": "false"}),
    element("option", {"timestep": "0.001", "integrator": "implicitfast"}),
)


@dataclass(frozen=True, eq=False)
class MjcfExport:
    """The MJCF ``text`` of a model. ``stated`` has one line for each thing that it does not hold as the model does, and
    ``held`` is the part of the model that it holds (see ``Held``)."""

    text: str
    stated: tuple[str, ...]
    held: Held

    def __repr__(self) -> str:
        return "\n".join(self.stated) or "MJCF holds the whole model"


def export_mjcf(model: Model | Estimate, path: str | Path, meshes: str | Path | None = None) -> MjcfExport:
    """Write a model or an estimate as an MJCF file, whole or not at all; ``meshes`` is the folder that package:// stands for.

    Raises InputError like ``mjcf_of``, and for a path that cannot be written.
    """
    result = mjcf_of(model.model if isinstance(model, Estimate) else model, Path(path).parent, meshes)
    write_text(path, result.text)
    return result


def mjcf_of(model: Model, folder: str | Path = ".", meshes: str | Path | None = None) -> MjcfExport:
    """The model as MJCF, to be written in ``folder``, which the paths of its meshes start from.

    Bodies and joints have the names of the robot's links and joints; each joint has a motor of its name, whose control is
    the torque [N m|N]. The inertia of all links that move with a joint is that of the joint's child link. Raises InputError
    for a model without rigid bodies and for a link that is not physical, with its name and the condition that it violates.
    """
    robot = model.robot
    together = fixed_links(parse_elements(robot.urdf))[1]
    links = child_links(robot)
    values = mjcf_values(model, links)
    visuals = arm_visuals(robot, meshes)
    files, unread = assets(visuals, Path(os.path.abspath(folder)))
    lines = [element("mujoco", {"model": robot.name}, open=True)]
    lines += [INDENT + text for text in HEAD]
    lines.append(INDENT + element("option", {"gravity": numbers(values.gravity)}))
    lines.append(INDENT + f"<default>{element('joint', STIFF)}</default>")
    if files:
        lines += ["  <asset>", *(f"    {element('mesh', asset)}" for asset in files.values()), "  </asset>"]
    lines.append("  <worldbody>")
    lines += _indented(shapes(visuals, -1, files), 2)
    lines += _indented(_frames(robot, -1, []), 2)
    payload = _payload(model, values)
    for j in range(robot.n):
        if robot.joints[j].parent < 0:
            lines += _indented(_body(robot, j, values, links, together, visuals, files, payload), 2)
    lines += ["  </worldbody>", *_tendons(robot, values), *_motors(robot), "</mujoco>", MARK, ""]
    return MjcfExport("\n".join(lines), (*values.stated, *unread), values.held)


def child_links(robot: Robot) -> tuple[str, ...]:
    """The name of the link that each joint moves (n,)."""
    child, _ = fixed_links(parse_elements(robot.urdf))
    return tuple(child[name] for name in robot.joint_names)


def _body(robot: Robot, j: int, values: MjcfValues, links: tuple, together: dict, *rest: object) -> list[str]:
    """The body that joint j (from 0) moves, with all bodies that it carries."""
    visuals, files, payload = rest
    joint, phi = robot.joints[j], values.links[j]
    place = {"pos": numbers(joint.translation), "quat": numbers(quaternion(joint.rotation))}
    carried: list[str] = []
    if payload is not None and j == robot.n - 1:
        assert isinstance(payload, np.ndarray)
        phi = phi - payload
        names = {*links, *(name for names in together.values() for name in names)}
        name = next(f"payload{k}" for k in ("", *range(1, robot.n + 9)) if f"payload{k}" not in names)
        carried = [
            element("body", {"name": name}, open=True),
            INDENT + element("inertial", inertial(payload)),
            "</body>",
        ]
    inside = [element("inertial", inertial(phi)), element("joint", _joint(robot, j, values))]
    inside += shapes(visuals, j, files)  # pyright: ignore[reportArgumentType]
    inside += carried + _frames(robot, j, [links[j]])
    for k in range(robot.n):
        if robot.joints[k].parent == j:
            inside += _body(robot, k, values, links, together, *rest)
    return [element("body", {"name": links[j], **place}, open=True), *_indented(inside, 1), "</body>"]


def _joint(robot: Robot, j: int, values: MjcfValues) -> dict[str, str]:
    joint = robot.joints[j]
    attributes = {
        "name": joint.name,
        "type": "slide" if joint.kind == "prismatic" else "hinge",
        "axis": numbers(joint.axis),
    }
    if values.armature is not None:
        attributes["armature"] = numbers([values.armature[j]])
    if np.isfinite([robot.lower[j], robot.upper[j]]).all():
        attributes["range"] = numbers([robot.lower[j], robot.upper[j]])
    if np.isfinite(robot.torque_limit[j]):
        attributes["actuatorfrcrange"] = numbers([-robot.torque_limit[j], robot.torque_limit[j]])
    return attributes | {name: numbers([value]) for name, value in values.joints[j].items()}


def _frames(robot: Robot, joint: int, without: list[str]) -> list[str]:
    """The links that are fixed to a joint (from 0, -1 the base) as bodies without mass, so that their names and poses stay."""
    bodies = []
    for frame in robot.pinocchio.frames:
        known = "BODY" in str(frame.type) and frame.parentJoint == joint + 1
        if known and frame.name not in (*without, "world"):  # MuJoCo's own name of the base
            place = frame.placement
            at = {"pos": numbers(place.translation), "quat": numbers(quaternion(place.rotation))}
            bodies.append(element("body", {"name": frame.name, **at}))
    return bodies


def _payload(model: Model, values: MjcfValues) -> Array | None:
    """Parameters (10,) of the payload where it can be a body by itself, and the last link without it too; or None."""
    loads = [theta for effect, theta in model.effect_parameters() if effect.name == "payload"]
    if not loads:
        return None
    load = np.sum(loads, axis=0)
    parts = (load, values.links[-1] - load)
    return None if any(part[0] <= 0 or violations(part) for part in parts) else load


def _tendons(robot: Robot, values: MjcfValues) -> list[str]:
    """One tendon for each pair of joints that a motor turns together."""
    if not values.pairs:
        return []
    lines = ["  <tendon>"]
    for places, pair in values.pairs.items():
        name = "_and_".join(robot.joint_names[j] for j in places)
        settings = {"name": name, **{key: numbers([value]) for key, value in pair.items()}, **STIFF}
        lines.append(f"    {element('fixed', settings, open=True)}")
        lines += [f"      {element('joint', {'joint': robot.joint_names[j], 'coef': '1'})}" for j in places]
        lines.append("    </fixed>")
    return [*lines, "  </tendon>"]


def _motors(robot: Robot) -> list[str]:
    lines = ["  <actuator>"]
    for name, limit in zip(robot.joint_names, robot.torque_limit, strict=True):
        motor = {"name": name, "joint": name, "gear": "1"}
        if np.isfinite(limit):
            motor["ctrlrange"] = numbers([-limit, limit])
        lines.append(f"    {element('motor', motor)}")
    return [*lines, "  </actuator>"]


def quaternion(rotation: Array) -> Array:
    """Unit quaternion (4,), scalar first, of a rotation (3, 3)."""
    from scipy.spatial.transform import Rotation

    return np.roll(Rotation.from_matrix(rotation).as_quat(), 1)


def _indented(lines: list[str], levels: int) -> list[str]:
    return [INDENT * levels + line for line in lines]
