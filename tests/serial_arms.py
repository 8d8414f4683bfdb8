"""Serial arms of any joints as `tests.truth` describes them, made of rods, for tests of the plants."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from tests.truth import ArmTruth, FrictionTruth

Array = NDArray[np.float64]
Kind = Literal["dry", "bristle", "smooth"]


@dataclass(frozen=True)
class Joint:
    """One joint and the rod behind it: ``axis``, its place on the link before [m], [rad], the rod's mass [kg], length [m]."""

    axis: str = "0 1 0"
    xyz: str = "0 0 0.3"
    rpy: str = "0 0 0"
    mass: float = 3.0
    length: float = 0.3
    kind: str = "revolute"


ARMS: dict[str, tuple[Joint, ...]] = {
    "pendulum": (Joint(),),
    "two": (Joint(mass=4.0), Joint(mass=2.0)),
    "scara": (
        Joint("0 0 1", mass=6.0), Joint("0 0 1", "0.35 0 0", mass=4.0),
        Joint("0 0 1", "0.3 0 0", mass=1.0, length=0.2, kind="prismatic"), Joint("0 0 1", "0 0 -0.1", mass=0.6, length=0.1),
    ),
    "seven": tuple(
        Joint(("0 0 1", "0 1 0")[i % 2], "0.02 0 0.22", f"{0.1 * i} 0 0.05", 3.5 - 0.4 * i, 0.22) for i in range(7)
    ),
}  # fmt: skip


def _link(name: str, rod: Joint) -> str:
    m, L = rod.mass, rod.length
    long, thick = m * L * L / 12, m * 0.05**2 / 2
    return (
        f'<link name="{name}"><inertial><origin xyz="0.01 0.005 {L / 2}"/><mass value="{m}"/><inertia ixx="{long + thick}" '
        f'iyy="{long + 0.8 * thick}" izz="{thick}" ixy="0" ixz="{0.05 * thick}" iyz="0"/></inertial></link>'
    )


def urdf(joints: tuple[Joint, ...]) -> str:
    """The description, with a frame "tool" at the last rod's end."""
    parts = ['<robot name="rods"><link name="base"/>']
    for i, joint in enumerate(joints):
        parent = f"rod{i - 1}" if i else "base"
        parts.append(_link(f"rod{i}", joint))
        parts.append(
            f'<joint name="j{i}" type="{joint.kind}"><parent link="{parent}"/><child link="rod{i}"/><origin xyz="{joint.xyz}" '
            f'rpy="{joint.rpy}"/><axis xyz="{joint.axis}"/><limit lower="-3" upper="3" effort="500" velocity="5"/></joint>'
        )
    last = len(joints) - 1
    parts.append(
        f'<link name="tool"/><joint name="end" type="fixed"><parent link="rod{last}"/><child link="tool"/>'
        f'<origin xyz="0 0 {joints[-1].length}"/></joint></robot>'
    )
    return "".join(parts)


def make_arm(name: str, kind: Kind, *, coulomb: float = 2.0, breakaway: float = 2.6, **changes: Any) -> ArmTruth:
    """An arm of `ARMS` with friction of one kind, alike in all joints; ``changes`` replace the truth's fields."""
    joints = ARMS[name]
    n = len(joints)
    same = lambda value: np.full(n, float(value))  # noqa: E731
    text = urdf(joints)
    links = np.array([body.toDynamicParameters() for body in list(pin.buildModelFromXML(text).inertias)[1:]])
    prismatic = np.array([joint.kind == "prismatic" for joint in joints])
    truth: dict[str, Any] = {
        "name": name, "urdf": text, "tool": "tool", "links": links,
        "rotor_inertia": np.where(prismatic, 2.0, 0.15), "torque_offset": same(0.0),
        "friction": FrictionTruth(
            kind=kind, coulomb=same(coulomb), viscous=same(1.5), breakaway=same(breakaway), stribeck_speed=same(0.02),
            bristle_stiffness=same(2e4), bristle_damping=same(40), width=same(0.004), per_degree=same(0.006),
        ),
        "lower": np.where(prismatic, -0.1, -1.5), "upper": np.where(prismatic, 0.1, 1.5),
        "top_speed": same(1.5), "top_acceleration": same(6.0), "bandwidth": 60.0,
    }  # fmt: skip
    return ArmTruth(**(truth | changes))


@dataclass(frozen=True, eq=False)
class Sway:
    """Each joint swings about zero with its ``amplitude`` (n,) [rad], all from and to rest, at paces that differ."""

    amplitude: Array
    duration: float = 4.0

    def states(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities, accelerations (N, n)."""
        # sin^3 has no speed and no acceleration at its ends
        rate = np.pi / self.duration * (2 + np.arange(len(self.amplitude)) % 3)
        s, c = np.sin(angle := np.outer(time, rate)), np.cos(angle)
        q, v, a = s**3, 3 * s**2 * c * rate, (6 * s * c**2 - 3 * s**3) * rate**2
        return self.amplitude * q, self.amplitude * v, self.amplitude * a


@dataclass(frozen=True, eq=False)
class Ramp:
    """Stand at ``start`` (n,) [rad] for a while [s], then move at even ``speed`` (n,) [rad/s]."""

    start: Array
    speed: Array
    wait: float = 0.0
    duration: float = 5.0

    def states(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities, accelerations (N, n)."""
        way = np.maximum(time - self.wait, 0.0)[:, None]
        return self.start + way * self.speed, (way > 0) * self.speed, 0.0 * way * self.speed


def swung(rng: np.random.Generator, time: Array) -> tuple[Array, Array, Array]:
    """Angles [rad], velocities and the torques (N, 2) [N m] of the links of the "two", along four sines of each joint at up to 2 rad/s."""
    return swinging(rng, time, ARMS["two"], 0.2, (0.5, 4.0))


def swinging(
    rng: np.random.Generator,
    time: Array,
    joints: tuple[Joint, ...],
    reach: float,
    pace: tuple[float, float],
    rotor_inertia: Array | float = 0.0,
) -> tuple[Array, Array, Array]:
    """Angles [rad], velocities and the torques (N, n) [N m] of some joints' links and rotors [kg m^2], along four sines of each, of a ``reach``
    [rad] and a ``pace`` [rad/s]."""
    omega, phase = rng.uniform(*pace, (4, len(joints))), rng.uniform(0, 2 * np.pi, (4, len(joints)))
    angle = time[:, None, None] * omega + phase
    parts = np.sin(angle), omega * np.cos(angle), -(omega**2) * np.sin(angle)
    q, v, a = (reach * part.sum(axis=1) for part in parts)
    return q, v, needed(joints, q, v, a, rotor_inertia)


def needed(joints: tuple[Joint, ...], q: Array, v: Array, a: Array, rotor_inertia: Array | float = 0.0) -> Array:
    """Torques (N, n) [N m] of some joints' links and rotors [kg m^2] along a motion, by pinocchio."""
    model = pin.buildModelFromXML(urdf(joints))
    model.armature = np.full(len(joints), 0.0) + rotor_inertia
    data = model.createData()
    return np.array([pin.rnea(model, data, *state) for state in zip(q, v, a, strict=True)])
