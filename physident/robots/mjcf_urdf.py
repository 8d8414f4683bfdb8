"""A compiled MuJoCo model written as URDF text: bodies, joints with any anchor and reference, inertia, plain shapes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
KINDS = {0: "floating", 1: "floating", 2: "prismatic", 3: "revolute"}  # of mjtJoint: free, ball, slide, hinge


@dataclass(frozen=True)
class MjcfNames:
    """The names of a MuJoCo model's bodies and joints, by index; those without a name get one from their body."""

    bodies: tuple[str, ...]
    joints: tuple[str, ...]

    @staticmethod
    def of(model: Any) -> MjcfNames:
        """The names of a compiled model."""
        bodies = _unique([model.body(i).name or f"body_{i}" for i in range(model.nbody)])
        joints = []
        for i in range(model.njnt):
            owner = bodies[model.jnt_bodyid[i]]
            joints.append(model.joint(i).name or f"{owner}_joint")
        return MjcfNames(tuple(bodies), tuple(_unique(joints)))


@dataclass
class _Place:
    """A frame in another: ``rotation`` (3, 3), ``translation`` (3,) [m]."""

    rotation: Array = field(default_factory=lambda: np.eye(3))
    translation: Array = field(default_factory=lambda: np.zeros(3))

    def __matmul__(self, other: _Place) -> _Place:
        return _Place(self.rotation @ other.rotation, self.translation + self.rotation @ other.translation)

    def origin(self) -> Element:
        import pinocchio

        return _origin(self.translation, pinocchio.rpy.matrixToRpy(self.rotation))


def urdf_of_mjcf(model: Any, names: MjcfNames, name: str, efforts: Array) -> str:
    """URDF text with the same motion and inertia as a compiled MuJoCo model, its joints' positions counted as in MuJoCo.

    A body with several joints becomes a row of massless links; free and ball joints become floating ones. ``efforts``
    (njnt,) [N m|N] are the joints' effort limits, 0 for none. Meshes are left out.
    """
    robot = Element("robot", name=name)
    inner = [_Place() for _ in range(model.nbody)]  # where each body's frame is in the frame of its URDF link
    for body in range(model.nbody):
        if body:
            link_of_parent = names.bodies[model.body_parentid[body]]
            outer = inner[model.body_parentid[body]] @ _place(model.body_pos[body], model.body_quat[body])
            first = int(model.body_jntadr[body])
            joints = range(first, first + int(model.body_jntnum[body]))
            inner[body] = _hang(robot, model, names, body, joints, (link_of_parent, outer), efforts)
        link = SubElement(robot, "link", name=names.bodies[body])
        _add_inertial(link, model, body, inner[body])
        _add_shapes(link, model, body, inner[body])
    for equality, joint, other in coupled_joints(model):
        element = next(e for e in robot.findall("joint") if e.get("name") == names.joints[joint])
        offset, slope = (float(x) for x in model.eq_data[equality][:2])
        reference = [float(model.qpos0[model.jnt_qposadr[j]]) for j in (joint, other)]
        shift = offset + reference[0] - slope * reference[1]
        SubElement(element, "mimic", joint=names.joints[other], multiplier=repr(slope), offset=repr(shift))
    ElementTree.indent(robot)
    return ElementTree.tostring(robot, encoding="unicode") + "\n"


def coupled_joints(model: Any) -> Iterator[tuple[int, int, int]]:
    """The active equality constraints that make one joint a linear function of another: their index and the two joints."""
    import mujoco

    for i in range(model.neq):
        joint, other = int(model.eq_obj1id[i]), int(model.eq_obj2id[i])
        is_joint = int(model.eq_type[i]) == int(mujoco.mjtEq.mjEQ_JOINT)
        if is_joint and model.eq_active0[i] and other >= 0 and not np.any(model.eq_data[i][2:5]):
            yield i, joint, other


def _hang(
    robot: Element,
    model: Any,
    names: MjcfNames,
    body: int,
    joints: range,
    outer: tuple[str, _Place],
    efforts: Array,
) -> _Place:
    """Add the joints between a body and its parent; returns where the body's frame is in the frame of its link."""
    parent, place = outer
    if not joints:
        joint = SubElement(robot, "joint", name=f"{names.bodies[body]}_fixed", type="fixed")
        _connect(joint, parent, names.bodies[body], place)
        return _Place()
    inner = _Place()
    for i in joints:
        child = names.bodies[body] if i == joints[-1] else f"{names.bodies[body]}_before_{names.joints[i + 1]}"
        if child != names.bodies[body]:
            SubElement(robot, "link", name=child)
        kind = KINDS[int(model.jnt_type[i])]
        joint = SubElement(robot, "joint", name=names.joints[i], type=kind)
        anchor, axis = model.jnt_pos[i].copy(), model.jnt_axis[i].copy()
        if kind == "floating":
            _connect(joint, parent, child, place)
            parent, place, inner = child, _Place(), _Place()
            continue
        _connect(joint, parent, child, place @ _Place(translation=anchor) @ _unreferenced(model, i, axis))
        SubElement(joint, "axis", xyz=_text(axis))
        if not model.jnt_limited[i] and kind == "revolute":
            joint.set("type", "continuous")
        low, high = model.jnt_range[i] if model.jnt_limited[i] else (-1e10, 1e10)
        SubElement(
            joint,
            "limit",
            lower=repr(float(low)),
            upper=repr(float(high)),
            velocity="0",
            effort=repr(float(efforts[i])),
        )
        inner = _Place(translation=-anchor)
        parent, place = child, inner
    return inner


def _unreferenced(model: Any, joint: int, axis: Array) -> _Place:
    """The displacement by minus the joint's reference: MuJoCo places bodies by position minus reference."""
    import pinocchio

    reference = float(model.qpos0[model.jnt_qposadr[joint]])
    if KINDS[int(model.jnt_type[joint])] == "prismatic":
        return _Place(translation=-reference * axis)
    return _Place(rotation=pinocchio.exp3(-reference * axis) if reference else np.eye(3))


def _connect(joint: Element, parent: str, child: str, place: _Place) -> None:
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=child)
    joint.append(place.origin())


def _add_inertial(link: Element, model: Any, body: int, inner: _Place) -> None:
    mass = float(model.body_mass[body])
    if body == 0 or mass == 0:
        return
    place = inner @ _place(model.body_ipos[body], model.body_iquat[body])
    tensor = place.rotation @ np.diag(model.body_inertia[body]) @ place.rotation.T
    inertial = SubElement(link, "inertial")
    inertial.append(_origin(place.translation, np.zeros(3)))
    SubElement(inertial, "mass", value=repr(mass))
    entries = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    SubElement(inertial, "inertia", {key: repr(float(tensor[at])) for key, at in entries.items()})


def _add_shapes(link: Element, model: Any, body: int, inner: _Place) -> None:
    """The body's spheres, capsules, cylinders and boxes, to be seen, and to collide where they do in MuJoCo."""
    first = int(model.body_geomadr[body])
    for geom in range(first, first + int(model.body_geomnum[body])):
        shapes = _shapes(model, geom, inner @ _place(model.geom_pos[geom], model.geom_quat[geom]))
        collides = model.geom_contype[geom] or model.geom_conaffinity[geom]
        for use in ("visual", "collision") if collides else ("visual",):
            for place, tag, attributes in shapes:
                element = SubElement(link, use)
                element.append(place.origin())
                SubElement(SubElement(element, "geometry"), tag, attributes)


def _shapes(model: Any, geom: int, place: _Place) -> list[tuple[_Place, str, dict[str, str]]]:
    """URDF's shapes of a geom: a capsule is a cylinder with a sphere at each end."""
    import mujoco

    kind, (a, b, c) = mujoco.mjtGeom(model.geom_type[geom]), (float(x) for x in model.geom_size[geom])
    sphere, cylinder = {"radius": repr(a)}, {"radius": repr(a), "length": repr(2 * b)}
    if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        return [(place, "sphere", sphere)]
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return [(place, "box", {"size": f"{2 * a!r} {2 * b!r} {2 * c!r}"})]
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        return [(place, "cylinder", cylinder)]
    if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        ends = [place @ _Place(translation=np.array([0.0, 0.0, z])) for z in (-b, b)]
        return [(place, "cylinder", cylinder), *((end, "sphere", sphere) for end in ends)]
    return []


def _place(position: Array, quaternion: Array) -> _Place:
    """The frame at a position with MuJoCo's quaternion w, x, y, z."""
    import pinocchio

    w, x, y, z = (float(value) for value in quaternion / math.sqrt(float(quaternion @ quaternion)))
    return _Place(pinocchio.Quaternion(w, x, y, z).matrix(), position.copy())


def _origin(xyz: Array, rpy: Array) -> Element:
    return Element("origin", xyz=_text(xyz), rpy=_text(rpy))


def _text(values: Array) -> str:
    return " ".join(repr(float(x) + 0.0) for x in values)


def _unique(names: list[str]) -> list[str]:
    """The names, later ones of the same name numbered: elements without a name get that of their body."""
    result: list[str] = []
    for name in names:
        candidate, number = name, 2
        while candidate in result:
            candidate, number = f"{name}_{number}", number + 1
        result.append(candidate)
    return result
