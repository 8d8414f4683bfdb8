"""The Pinocchio model of a checked description, built joint by joint, so that each number is read in one place only; and its joints."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError, did_you_mean
from physident.robots.urdf import MOVING, Description, UrdfJoint, UrdfLink

Array = NDArray[np.float64]
LEVER = 0.1  # m: a slide of 0.2 m at 0.2 m/s does what a joint does that turns by two radians at two radians a second
# of a joint that turns, and of one that slides
SLIDING_UNITS = ((r"\bkg m\^2", "kg"), (r"\(N m\)", "N"), (r"\bN m\b", "N"), (r"\brad\b", "m"), (r"\bmrad\b", "mm"))


def pinocchio_model(description: Description, source: str, order: Sequence[str] | None = None) -> Any:
    """The Pinocchio model of a description with a fixed base and without armature; a joint has one coordinate.

    ``order`` names all moving joints, each after those it hangs on; by default they are in ``Description.from_base``'s
    order. Links without a moving joint between them are one body. Raises InputError, naming ``source``, for another order.
    """
    import pinocchio as pin

    model = pin.Model()
    model.name = description.name
    places = {
        description.root: ("", pin.SE3.Identity())
    }  # of each link: the joint that moves it, and where it is there
    moving: dict[str, UrdfJoint] = {}
    for joint in description.from_base():
        carrier, place = places[joint.parent]
        if joint.kind in MOVING:
            moving[joint.name] = joint
            places[joint.child] = (joint.name, pin.SE3.Identity())
        else:
            places[joint.child] = (carrier, place * pin.SE3(joint.rotation, joint.translation))
    ids = {"": 0}
    for name in _checked_order(order, moving, source):
        joint = moving[name]
        carrier, place = places[joint.parent]
        if carrier not in ids:
            raise InputError(
                f"{source}: joint {name!r} comes before {carrier!r}, which it hangs on; expected joints from base to tip"
            )
        ids[name] = model.addJoint(
            ids[carrier], _joint_model(joint), place * pin.SE3(joint.rotation, joint.translation), name,
            *(np.array([x]) for x in (joint.effort, joint.velocity, joint.lower, joint.upper)),
        )  # fmt: skip
        model.addJointFrame(ids[name])
    for link in (description.root, *(joint.child for joint in description.from_base())):
        carrier, place = places[link]
        body = description.links[link]
        if body.mass or body.inertia.any():
            model.appendBodyToJoint(ids[carrier], _inertia(body), place)
        model.addBodyFrame(link, ids[carrier], place, 0)
    return model


def tool_position(
    description: Description, model: Any, source: str, frame: str | None = None, locked: Collection[str] = ()
) -> Array:
    """Position (3,) [m] of the tool in the last joint's frame: the origin of the link ``frame``, or of the last link fixed
    to the last joint.

    Links behind ``locked`` joints, such as fingers, are not taken by default. Raises InputError, naming the frames that
    can be taken, where the frame is unknown or does not move with the last joint.
    """
    last = str(model.names[model.njoints - 1])
    joints = {joint.name: joint for joint in description.joints}
    fixed, waiting = [joints[last].child], list(reversed(description.joints_below[joints[last].child]))
    while waiting:
        joint = waiting.pop()
        if joint.kind not in MOVING and joint.name not in locked:
            fixed.append(joint.child)
            waiting.extend(reversed(description.joints_below[joint.child]))
    chosen = fixed[-1] if frame is None else frame
    places = {f.name: f for f in model.frames if f.parentJoint == model.njoints - 1 and f.name in description.links}
    if chosen not in places:
        where = "is not a link" if chosen not in description.links else f"does not move with the last joint, {last!r}"
        raise InputError(
            f"{source}: the tool {chosen!r} {where}; expected one of {', '.join(fixed[-8:])}{did_you_mean(chosen, fixed)}"
        )
    return places[chosen].placement.translation.copy()


def _checked_order(order: Sequence[str] | None, moving: dict[str, UrdfJoint], source: str) -> Sequence[str]:
    if order is not None and (len(order) != len(moving) or set(order) != set(moving)):
        raise InputError(f"{source}: the order of joints is {list(order)}; expected all of {', '.join(moving)}")
    return tuple(moving) if order is None else order


def _inertia(body: UrdfLink) -> Any:
    """The body's inertia as Pinocchio has it; set entry by entry, because its constructor refuses what is not physical."""
    import pinocchio as pin

    inertia = pin.Inertia.Zero()
    inertia.mass, inertia.lever, inertia.inertia = body.mass, body.centre, body.inertia
    return inertia


def _joint_model(joint: UrdfJoint) -> Any:
    """The joint's Pinocchio model: the fast one for an axis along x, y or z."""
    import pinocchio as pin

    prismatic = joint.kind == "prismatic"
    for axis, name in zip(np.eye(3), "XYZ", strict=True):
        if (joint.axis == axis).all():
            return getattr(pin, f"JointModel{'P' if prismatic else 'R'}{name}")()
    return (pin.JointModelPrismaticUnaligned if prismatic else pin.JointModelRevoluteUnaligned)(joint.axis)


@dataclass(frozen=True)
class Joint:
    """One moving joint: its kind, axis and constant placement in the frame of the joint before it.

    ``axis`` (3,) unit vector in the joint's frame; ``rotation`` (3, 3) and ``translation`` (3,) [m] place that frame in
    the parent joint's (``parent`` is its index, -1 for the base).
    """

    name: str
    kind: str
    parent: int
    axis: Array
    rotation: Array
    translation: Array

    def unit(self, turning: str) -> str:
        """The unit on this joint, or a text with units, of what has the unit ``turning`` on one that turns: a force for a torque, a distance
        for an angle."""
        if self.kind == "prismatic":
            for turns, slides in SLIDING_UNITS:
                turning = re.sub(turns, slides, turning)
        return turning

    @property
    def radian(self) -> float:
        """The position [rad|m] that counts as a radian where what is searched for has a length or a speed."""
        return LEVER if self.kind == "prismatic" else 1.0


def joint_of(model: Any, index: int) -> Joint:
    """The joint of an index in a Pinocchio model."""
    placement = model.jointPlacements[index]
    motion = _motion_subspace(model, index)
    kind = "prismatic" if np.abs(motion[:3]).max() > 0.5 else "revolute"
    axis = motion[:3] if kind == "prismatic" else motion[3:]
    return Joint(
        model.names[index],
        kind,
        model.parents[index] - 1,
        axis,
        placement.rotation.copy(),
        placement.translation.copy(),
    )


def _motion_subspace(model: Any, index: int) -> Array:
    import pinocchio

    J = pinocchio.computeJointJacobian(model, model.createData(), pinocchio.neutral(model), index)
    return J.reshape(6, -1)[:, model.idx_vs[index]]  # of one joint, Pinocchio gives a vector
