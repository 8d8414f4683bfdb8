"""A robot arm: its joints and their placement, its links' nominal inertia, its limits and drives."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.robots.dh_table import DRIVE, LARGEST
from physident.robots.urdf import pinocchio_model

Array = NDArray[np.float64]
MAX_GRAVITY = 1e3  # m/s^2
STANDARD_GRAVITY = (0.0, 0.0, -9.81)


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


@dataclass(frozen=True)
class Drive:
    """One joint's motor and gear: ratio G [-], torque constant [N m/A], rotor inertia [kg m^2] and the motor's Coulomb
    friction in either direction [N m], on the motor's side (thesis Table 2.5)."""

    gear_ratio: float
    torque_constant: float
    motor_inertia: float
    motor_friction: tuple[float, float]

    def __post_init__(self) -> None:
        for name, size in DRIVE.items():
            values = np.asarray(getattr(self, name))
            if values.dtype.kind not in "if" or values.size != max(size, 1) or not (np.abs(values) <= LARGEST).all():
                raise InputError(f"drive: {name} is {getattr(self, name)!r}, expected {max(size, 1)} finite numbers")


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot arm of n joints as its URDF describes it; bodies that are fixed to one joint count as one link.

    ``urdf`` is the text itself; ``gravity`` (3,) [m/s^2] in the base frame. ``nominal`` (10 n,) are the links' parameters
    in Pinocchio's order; ``lower``, ``upper`` [rad|m], ``velocity_limit`` [rad/s|m/s], ``acceleration_limit``
    [rad/s^2|m/s^2], ``torque_limit`` [N m|N] are (n,), infinite for a joint without a limit. ``tool`` (3,) [m] is the
    origin of the last fixed frame, in the frame of joint n.
    """

    name: str
    urdf: str
    gravity: tuple[float, float, float] = STANDARD_GRAVITY
    drives: tuple[Drive, ...] | None = None
    acceleration_limit: tuple[float, ...] | None = None
    tool_speed_limit: float | None = None
    source: str = "URDF"
    joints: tuple[Joint, ...] = field(init=False)
    nominal: Array = field(init=False)
    lower: Array = field(init=False)
    upper: Array = field(init=False)
    velocity_limit: Array = field(init=False)
    torque_limit: Array = field(init=False)
    tool: Array = field(init=False)

    def __post_init__(self) -> None:
        checked_gravity(self.gravity)
        model = self.pinocchio
        joints = tuple(_joint(model, i) for i in range(1, model.njoints))
        nominal = np.concatenate([body.toDynamicParameters() for body in list(model.inertias)[1:]])
        values = {
            "joints": joints,
            "nominal": nominal,
            "lower": np.where(np.isfinite(model.lowerPositionLimit), model.lowerPositionLimit, -math.inf),
            "upper": np.where(np.isfinite(model.upperPositionLimit), model.upperPositionLimit, math.inf),
            "velocity_limit": _limit(model.velocityLimit),
            "torque_limit": _limit(model.effortLimit),
            "tool": _tool(model),
        }
        for key, value in values.items():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
            object.__setattr__(self, key, value)
        for name in ("drives", "acceleration_limit"):
            entries = getattr(self, name)
            if entries is not None and len(entries) != self.n:
                raise InputError(f"{self.source}: {name} has {len(entries)} entries, expected {self.n}, one a joint")

    @property
    def n(self) -> int:
        """Number of moving joints."""
        return len(self.joints)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the moving joints, in the order of every array's joint axis."""
        return tuple(joint.name for joint in self.joints)

    @cached_property
    def pinocchio(self) -> Any:
        """The Pinocchio model of this robot, without armature (rotor inertia is an effect) and with its gravity."""
        model = pinocchio_model(self.urdf, self.source)
        model.gravity.linear = np.array(self.gravity, dtype=float)
        return model

    def link(self, number: int) -> Array:
        """Nominal parameters (10,) [kg, kg m, kg m^2] of link ``number``, counted from 1."""
        return self.nominal[10 * (number - 1) : 10 * number]

    def as_dict(self) -> dict[str, Any]:
        """The whole robot as plain numbers and texts for JSON."""
        drives = (
            None
            if self.drives is None
            else [vars(drive) | {"motor_friction": list(drive.motor_friction)} for drive in self.drives]
        )
        return {
            "name": self.name,
            "gravity": list(self.gravity),
            "drives": drives,
            "acceleration_limit": self.acceleration_limit
            and [limit if math.isfinite(limit) else None for limit in self.acceleration_limit],
            "tool_speed_limit": self.tool_speed_limit,
            "source": self.source,
            "urdf": self.urdf,
        }

    @staticmethod
    def from_dict(data: dict[str, Any]) -> Robot:
        """The robot that ``as_dict`` described."""
        drives = data["drives"] and tuple(
            Drive(**drive | {"motor_friction": tuple(drive["motor_friction"])}) for drive in data["drives"]
        )
        limit = data["acceleration_limit"] and tuple(
            math.inf if one is None else float(one) for one in data["acceleration_limit"]
        )
        return Robot(**data | {"gravity": tuple(data["gravity"]), "drives": drives, "acceleration_limit": limit})

    def __repr__(self) -> str:
        rows = [f"Robot {self.name}: {self.n} joints, gravity {list(self.gravity)} m/s^2"]
        rows += [
            f"  {i} {joint.name:<24} {joint.kind:<9} {self.link(i)[0]:8.3f} kg"
            for i, joint in enumerate(self.joints, 1)
        ]
        return "\n".join(rows)


def checked_gravity(values: Sequence[float]) -> tuple[float, float, float]:
    """Gravity (3,) [m/s^2] in the base frame; raises InputError for other than three finite numbers."""
    numbers = np.asarray(values)
    if numbers.shape != (3,) or numbers.dtype.kind not in "if" or not (np.abs(numbers) <= MAX_GRAVITY).all():
        raise InputError(f"gravity is {values!r}, expected three numbers [m/s^2] in the base frame, as [0, 0, -9.81]")
    return (float(numbers[0]), float(numbers[1]), float(numbers[2]))


def _limit(values: Array) -> Array:
    return np.where((values > 0) & np.isfinite(values), values, math.inf)


def _tool(model: Any) -> Array:
    """Position (3,) [m] of the tool in the last joint's frame: the origin of the last link that is fixed to it."""
    last = [frame for frame in model.frames if frame.parentJoint == model.njoints - 1]
    return last[-1].placement.translation.copy()


def _joint(model: Any, index: int) -> Joint:
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
