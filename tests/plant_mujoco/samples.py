"""Small arms and a motion to try the plant with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tests.truth import ArmTruth, FrictionTruth

Array = NDArray[np.float64]
Kind = Literal["dry", "bristle", "smooth"]
UPRIGHT, FLAT, ACROSS = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (0.36, 0.48, -0.8)
SERIAL = {
    "planar": (("revolute", FLAT), ("revolute", FLAT)),
    "scara": (("revolute", UPRIGHT), ("revolute", UPRIGHT), ("prismatic", (0.0, 0.0, -1.0)), ("revolute", UPRIGHT)),
    "seven": (("revolute", UPRIGHT), ("revolute", FLAT), ("revolute", ACROSS), *(("revolute", FLAT),) * 4),
}


@dataclass(frozen=True, eq=False)
class Sines:
    """q = centre + w(t) (sum of two sines), w rising from zero and falling to it within ``rise`` [s], with rest at last."""

    duration: float
    centre: Array
    amplitude: Array
    rate: Array
    rise: float = 1.0
    rest: float = 0.0

    def states(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities, accelerations (N, n)."""
        t = time[:, None]
        up, down = _ramp(t / self.rise), _ramp((self.duration - self.rest - t) / self.rise)
        w0, w1 = up[0] * down[0], (up[1] * down[0] - up[0] * down[1]) / self.rise
        w2 = (up[2] * down[0] - 2 * up[1] * down[1] + up[0] * down[2]) / self.rise**2
        s0, s1, s2 = np.zeros((3, len(time), len(self.centre)))
        for share, factor in ((1.0, 1.0), (0.3, 2.7)):
            rate = factor * self.rate
            s0 += share * self.amplitude * np.sin(rate * t)
            s1 += share * self.amplitude * rate * np.cos(rate * t)
            s2 -= share * self.amplitude * rate**2 * np.sin(rate * t)
        return self.centre + w0 * s0, w1 * s0 + w0 * s1, w2 * s0 + 2 * w1 * s1 + w0 * s2


def _ramp(x: Array) -> tuple[Array, Array, Array]:
    """A smooth rise from 0 to 1 and its derivatives: x - sin(2 pi x)/(2 pi)."""
    inside = (x > 0) & (x < 1)
    x = np.clip(x, 0.0, 1.0)
    turn = 2 * np.pi * x
    return x - np.sin(turn) / (2 * np.pi), inside * (1 - np.cos(turn)), inside * 2 * np.pi * np.sin(turn)


def sines(n: int, duration: float = 4.0, scale: float = 1.0, rest: float = 0.0) -> Sines:
    """A motion of n joints, different in each."""
    i = np.arange(n)
    return Sines(duration, 0.3 - 0.15 * i, scale * 0.4 * (-1.0) ** i / (1 + 0.2 * i), 2.0 + 0.7 * i, rest=rest)


def sample(name: str = "planar", kind: Kind = "dry", strength: float = 1.0, **changes: Any) -> ArmTruth:
    """One of the arms of ``SERIAL`` with friction of one kind, ``strength`` times the ordinary."""
    joints = SERIAL[name]
    n = len(joints)
    smaller: Array = 0.8 ** np.arange(n, dtype=np.float64)
    coulomb = strength * 4.0 * smaller
    friction = FrictionTruth(
        kind=kind,
        coulomb=coulomb,
        viscous=strength * 3.0 * smaller,
        breakaway=1.4 * coulomb,
        stribeck_speed=np.full(n, 0.04),
        bristle_stiffness=2000.0 * smaller,
        bristle_damping=4.0 * smaller,
        width=np.full(n, 0.01),
        per_degree=np.full(n, 0.01),
    )
    made = {
        "name": name,
        "urdf": _urdf(name),
        "tool": "tool",
        "links": np.array([_link(k) for k in range(n)]),
        "rotor_inertia": 0.4 * smaller,
        "torque_offset": np.zeros(n),
        "friction": friction,
        "lower": np.full(n, -1.5),
        "upper": np.full(n, 1.5),
        "top_speed": np.full(n, 2.0),
        "top_acceleration": np.full(n, 8.0),
        "bandwidth": 60.0,
    }
    return ArmTruth(**(made | changes))


def _link(k: int) -> Array:
    """A box of its own density and place."""
    mass, centre = 4.0 * 0.75**k, np.array([0.02 - 0.01 * k, 0.03, 0.12])
    second = mass * (0.01 * np.diag([1.0, 1.2, 0.5]) + centre @ centre * np.eye(3) - np.outer(centre, centre))
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = second
    return np.array([mass, *(mass * centre), xx, xy, yy, xz, yz, zz])


def _urdf(name: str) -> str:
    text = [f'<robot name="{name}"><link name="base"/>']
    before = "base"
    for k, (kind, axis) in enumerate(SERIAL[name]):
        place = f'xyz="0.02 {0.01 * k} 0.25" rpy="{0.1 * k} -0.05 {0.3 * (k % 2)}"'
        text.append(
            f'<link name="arm{k}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
            f'</inertial></link><joint name="j{k}" type="{kind}"><parent link="{before}"/><child link="arm{k}"/>'
            f'<origin {place}/><axis xyz="{axis[0]} {axis[1]} {axis[2]}"/>'
            '<limit lower="-3" upper="3" effort="100" velocity="3"/></joint>'
        )
        before = f"arm{k}"
    text.append(
        f'<link name="tool"/><joint name="mount" type="fixed"><parent link="{before}"/><child link="tool"/>'
        '<origin xyz="0.01 0.02 0.2" rpy="0.2 0.1 0"/></joint></robot>'
    )
    return "".join(text)
