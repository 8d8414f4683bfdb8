"""A robot arm: its joints and their placement, its links' nominal inertia, its limits and drives."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from physident.errors import InputError
from physident.json_records import RecordReader
from physident.robots.drives import Drive, JointDynamics
from physident.robots.joint_selection import LockedJoint
from physident.robots.kinematic_tree import Joint, joint_of, pinocchio_model, tool_position
from physident.robots.urdf import Description, read_description

Array = NDArray[np.float64]
MAX_GRAVITY = 1e3  # m/s^2
LARGEST_RATIO = 10_000  # of a gear
STANDARD_GRAVITY = (0.0, 0.0, -9.81)
SHOWN = 8  # locked joints that are printed
READER = RecordReader("expected a robot as this program writes it")


@dataclass(frozen=True, kw_only=True)
class Origin:
    """Where a robot's description comes from: the format and, unless it is built in, the path as it was given.

    ``bodies`` (n,) are the names of the MuJoCo bodies that the joints move; empty for other formats.
    """

    format: Literal["urdf", "dh", "mjcf"]
    path: str | None = None
    bodies: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot arm of n joints as its URDF describes it; bodies that are fixed to one joint count as one link.

    ``urdf`` is the text itself; ``gravity`` (3,) [m/s^2] in the base frame. ``nominal`` (10 n,) are the links' parameters
    in Pinocchio's order; ``lower``, ``upper`` [rad|m], ``velocity_limit`` [rad/s|m/s], ``acceleration_limit``
    [rad/s^2|m/s^2], ``torque_limit`` [N m|N] are (n,), infinite for a joint without a limit. ``joint_order`` names the
    joints in another order than the description's. ``tool`` (3,) [m] is the origin of the link ``tool_frame``, or of the
    last link fixed to joint n, in the frame of joint n. ``locked`` are joints that the file lets move and ``urdf`` fixes;
    ``joint_dynamics`` (n,) is what a simulator adds at each joint, for a description that is a simulation. ``gear_ratios`` (n,) are the turns
    of each motor for one turn of its joint, where they are known without the rest of the ``drives``.
    """

    name: str
    urdf: str
    gravity: tuple[float, float, float] = STANDARD_GRAVITY
    drives: tuple[Drive, ...] | None = None
    acceleration_limit: tuple[float, ...] | None = None
    tool_speed_limit: float | None = None
    source: str = "URDF"
    joint_order: tuple[str, ...] | None = None
    tool_frame: str | None = None
    locked: tuple[LockedJoint, ...] = ()
    joint_dynamics: tuple[JointDynamics, ...] | None = None
    gear_ratios: tuple[float, ...] | None = None
    origin: Origin | None = None
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
        joints = tuple(joint_of(model, i) for i in range(1, model.njoints))
        nominal = np.concatenate([body.toDynamicParameters() for body in list(model.inertias)[1:]])
        values = {
            "joints": joints,
            "nominal": nominal,
            "lower": np.where(np.isfinite(model.lowerPositionLimit), model.lowerPositionLimit, -math.inf),
            "upper": np.where(np.isfinite(model.upperPositionLimit), model.upperPositionLimit, math.inf),
            "velocity_limit": _limit(model.velocityLimit),
            "torque_limit": _limit(model.effortLimit),
            "tool": tool_position(
                self.description, model, self.source, self.tool_frame, {joint.name for joint in self.locked}
            ),
        }
        for key, value in values.items():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
            object.__setattr__(self, key, value)
        for name in ("drives", "acceleration_limit", "joint_dynamics", "gear_ratios"):
            entries = getattr(self, name)
            if entries is not None and len(entries) != self.n:
                raise InputError(f"{self.source}: {name} has {len(entries)} entries, expected {self.n}, one a joint")
        if self.gear_ratios is not None and not all(1 <= ratio <= LARGEST_RATIO for ratio in self.gear_ratios):
            raise InputError(
                f"{self.source}: gear_ratios are {list(self.gear_ratios)}, expected numbers from 1 to {LARGEST_RATIO}: turns of the motor for"
                " one turn of the joint"
            )

    @property
    def n(self) -> int:
        """Number of moving joints."""
        return len(self.joints)

    @property
    def torque_units(self) -> tuple[str, ...]:
        """The unit of each joint's torque: N of one that slides."""
        return tuple(joint.unit("N m") for joint in self.joints)

    @property
    def torque_unit(self) -> str:
        """The unit of all joints' torques: both, where some turn and some slide."""
        return "|".join(sorted(set(self.torque_units), reverse=True))

    @property
    def radian(self) -> Array:
        """The position (n,) [rad|m] of each joint that counts as a radian: of one that slides a lever of an arm."""
        return np.array([joint.radian for joint in self.joints])

    def units_where_it_slides(self, *turning: str) -> str:
        """One line on the units of the joints that slide, of what is shown in the units ``turning``; empty where none slides."""
        slides = [i for i, joint in enumerate(self.joints) if joint.kind == "prismatic"]
        if not slides:
            return ""
        numbers = ", ".join(str(i + 1) for i in slides)
        units = ", ".join(dict.fromkeys(self.joints[slides[0]].unit(unit) for unit in turning))
        return f"joint {numbers} slides: {units}" if len(slides) == 1 else f"joints {numbers} slide: {units}"

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the moving joints, in the order of every array's joint axis."""
        return tuple(joint.name for joint in self.joints)

    @cached_property
    def description(self) -> Description:
        """Links and joints as ``urdf`` states them, each number read once."""
        return read_description(self.urdf, self.source)

    @property
    def motor_turns(self) -> tuple[float, ...] | None:
        """Turns (n,) of each motor for one turn of its joint: by the drives, else the stated gear ratios; None where neither is known."""
        return self.gear_ratios if self.drives is None else tuple(abs(drive.gear_ratio) for drive in self.drives)

    @property
    def rotor_inertia(self) -> Array:
        """Described rotor inertia (n,) [kg m^2|kg] at the joints: G^2 Jm of the drives, or the simulator's armature."""
        if self.joint_dynamics is not None:
            return np.array([one.armature for one in self.joint_dynamics])
        return np.array([d.gear_ratio**2 * d.motor_inertia for d in self.drives or ()] or np.zeros(self.n))

    @property
    def dry_friction(self) -> Array:
        """Described dry friction (n,) [N m|N] at the joints: of the drives, mean of both directions, or the simulator's."""
        if self.joint_dynamics is not None:
            return np.array([one.friction for one in self.joint_dynamics])
        forces = [d.gear_ratio * (d.motor_friction[0] - d.motor_friction[1]) / 2 for d in self.drives or ()]
        return np.array(forces or np.zeros(self.n))

    @property
    def friction_lead(self) -> Array:
        """Time (n,) [s] by which a simulator's dry friction leads the velocity, zero where none is described."""
        return np.array([one.friction_lead for one in self.joint_dynamics or ()] or np.zeros(self.n))

    @property
    def friction_width(self) -> Array:
        """Speed (n,) [rad/s|m/s] at which a simulator's dry friction has its full size, zero where none is described."""
        return np.array([one.friction_width for one in self.joint_dynamics or ()] or np.zeros(self.n))

    @property
    def damping(self) -> Array:
        """Described damping (n,) [N m s/rad|N s/m] of the joints, zero where none is described."""
        return np.array([one.damping for one in self.joint_dynamics or ()] or np.zeros(self.n))

    @property
    def damping_lead(self) -> Array:
        """Time (n,) [s] by which a simulator's damping leads the velocity, zero where none is described."""
        return np.array([one.damping_lead for one in self.joint_dynamics or ()] or np.zeros(self.n))

    @property
    def spring_stiffness(self) -> Array:
        """Described stiffness (n,) [N m/rad|N/m] of a spring at each joint, zero where none is described."""
        return np.array([one.stiffness for one in self.joint_dynamics or ()] or np.zeros(self.n))

    @property
    def spring_offset(self) -> Array:
        """Torque (n,) [N m|N] that holds each joint at zero against its described spring."""
        return np.array([-d.stiffness * d.spring_position for d in self.joint_dynamics or ()] or np.zeros(self.n))

    @cached_property
    def pinocchio(self) -> Any:
        """The Pinocchio model of this robot, without armature (rotor inertia is an effect) and with its gravity."""
        model = pinocchio_model(self.description, self.source, self.joint_order)
        model.gravity.linear = np.array(self.gravity, dtype=float)
        return model

    def link(self, number: int) -> Array:
        """Nominal parameters (10,) [kg, kg m, kg m^2] of link ``number``, counted from 1."""
        return self.nominal[10 * (number - 1) : 10 * number]

    def as_dict(self) -> dict[str, Any]:
        """The whole robot as plain numbers and texts for JSON; what loading chose is left out where it chose nothing."""
        drives = (
            None
            if self.drives is None
            else [vars(drive) | {"motor_friction": list(drive.motor_friction)} for drive in self.drives]
        )
        chosen = {
            "joint_order": self.joint_order and list(self.joint_order),
            "tool_frame": self.tool_frame,
            "locked": [vars(joint) for joint in self.locked],
            "gear_ratios": self.gear_ratios and list(self.gear_ratios),
            "joint_dynamics": self.joint_dynamics and [vars(one) for one in self.joint_dynamics],
            "origin": self.origin and vars(self.origin) | {"bodies": list(self.origin.bodies)},
        }
        return {
            "name": self.name,
            "gravity": list(self.gravity),
            "drives": drives,
            "acceleration_limit": self.acceleration_limit
            and [limit if math.isfinite(limit) else None for limit in self.acceleration_limit],
            "tool_speed_limit": self.tool_speed_limit,
            "source": self.source,
            "urdf": self.urdf,
            **{name: value for name, value in chosen.items() if value},
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
        read = {name: READER.read(kind, data.get(name, default), name) for name, (kind, default) in ENTRIES.items()}
        return Robot(**data | read | {"gravity": tuple(data["gravity"]), "drives": drives, "acceleration_limit": limit})

    def __repr__(self) -> str:
        rows = [f"Robot {self.name}: {self.n} joints, gravity {list(self.gravity)} m/s^2"]
        rows += [
            f"  {i} {joint.name:<24} {joint.kind:<9} {self.link(i)[0]:8.3f} kg"
            for i, joint in enumerate(self.joints, 1)
        ]
        if self.locked:
            rows.append(f"  locked: {self.locked_text()}")
        return "\n".join(rows)

    def locked_text(self) -> str:
        """What was locked, in one line."""
        more = f", and {len(self.locked) - SHOWN} more" if len(self.locked) > SHOWN else ""
        return ", ".join(map(repr, self.locked[:SHOWN])) + more


def checked_gravity(values: Sequence[float]) -> tuple[float, float, float]:
    """Gravity (3,) [m/s^2] in the base frame; raises InputError for other than three finite numbers."""
    numbers = np.asarray(values)
    if numbers.shape != (3,) or numbers.dtype.kind not in "if" or not (np.abs(numbers) <= MAX_GRAVITY).all():
        raise InputError(f"gravity is {values!r}, expected three numbers [m/s^2] in the base frame, as [0, 0, -9.81]")
    return (float(numbers[0]), float(numbers[1]), float(numbers[2]))


def _limit(values: Array) -> Array:
    return np.where((values > 0) & np.isfinite(values), values, math.inf)


# entries of a saved robot that older files lack: their type, and what they are there
ENTRIES: dict[str, tuple[Any, Any]] = {
    "joint_order": (tuple[str, ...] | None, None),
    "tool_frame": (str | None, None),
    "locked": (tuple[LockedJoint, ...], []),
    "joint_dynamics": (tuple[JointDynamics, ...] | None, None),
    "origin": (Origin | None, None),
    "gear_ratios": (tuple[float, ...] | None, None),
}
