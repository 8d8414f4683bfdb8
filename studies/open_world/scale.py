"""How large the torques, speeds and inertias of an arm are: what friction, noise and hidden causes are scaled to."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from studies.open_world import motions
from tests.truth import ArmTruth

Array = NDArray[np.float64]
STEP = 0.02  # s: a look at a motion, not a simulation
LASTS = 12.0  # s of each motion that is looked at
LOOKS = 3 * (motions.fourier, motions.point_to_point, motions.teaching, motions.chirp)


@dataclass(frozen=True, eq=False)
class Scale:
    """Typical sizes (n,) along motions, in N m (or N), rad (or m) and seconds.

    ``rigid`` and ``friction`` are RMS torques of inertia with gravity and of sliding friction, ``torque`` that of both, ``speed`` the RMS
    speed; ``inertia`` [kg m^2|kg] is what a joint accelerates with the others at rest; ``prismatic`` says which joints
    slide; ``mass`` [kg] is that of all links, ``reach`` [m] the largest distance of the tool from the base, ``tool`` (3,)
    [m] its place in the last joint's frame.
    """

    rigid: Array
    friction: Array
    torque: Array
    speed: Array
    inertia: Array
    prismatic: NDArray[np.bool_]
    mass: float
    reach: float
    tool: Array


@dataclass(frozen=True, eq=False)
class States:
    """Where an arm ordinarily is: ``time`` (N,) [s] and positions, velocities, accelerations (N, n), of several motions."""

    time: Array
    q: Array
    v: Array
    a: Array


@lru_cache(maxsize=16)
def bodies(urdf: str) -> Any:
    """The pinocchio model of a description's joints and links."""
    return pin.buildModelFromXML(urdf)


def with_links(urdf: str, links: Array) -> Any:
    """The same model with other link parameters (n, 10)."""
    model = bodies(urdf).copy()
    for i, link in enumerate(links, 1):
        model.inertias[i] = pin.Inertia.FromDynamicParameters(link)
    return model


def pilot(arm: ArmTruth, rng: np.random.Generator) -> States:
    """States of three random motions of every kind, within an arm's limits."""
    time = np.arange(0.0, LASTS, STEP)
    parts = [look(arm, rng, LASTS, float(rng.uniform(0.6, 1.0))).states(time) for look in LOOKS]
    q, v, a = (np.concatenate(x) for x in zip(*parts, strict=True))
    return States(np.concatenate([time] * len(LOOKS)), q, v, a)


def rigid_torque(arm: ArmTruth, states: States) -> Array:
    """Torque (N, n) of links, rotors and gravity along states."""
    model = with_links(arm.urdf, arm.links)
    data = model.createData()
    rows = zip(states.q, states.v, states.a, strict=True)
    return np.array([pin.rnea(model, data, *row) for row in rows]) + arm.rotor_inertia * states.a


def friction_torque(arm: ArmTruth, states: States) -> Array:
    """Sliding friction (N, n) along states."""
    return arm.friction.coulomb * np.sign(states.v) + arm.friction.viscous * states.v


def measure(arm: ArmTruth, states: States) -> Scale:
    """The sizes of an arm along states."""
    rigid, friction = rigid_torque(arm, states), friction_torque(arm, states)
    model = with_links(arm.urdf, arm.links)
    data = model.createData()
    every = len(states.q) // 50
    inertia = np.mean([np.diag(pin.crba(model, data, q)) for q in states.q[::every]], axis=0)
    frame = model.getFrameId(arm.tool)
    return Scale(
        rms(rigid), rms(friction), rms(rigid + friction), rms(states.v), inertia + arm.rotor_inertia,
        prismatic(arm.urdf), float(arm.links[:, 0].sum()), _reach(model, frame, states.q[::every]),
        np.array(model.frames[frame].placement.translation),
    )  # fmt: skip


@lru_cache(maxsize=64)
def scale_of(arm: ArmTruth) -> Scale:
    """The sizes of an arm along its ordinary motions."""
    return measure(arm, pilot(arm, np.random.default_rng(1)))


def prismatic(urdf: str) -> NDArray[np.bool_]:
    """Which joints (n,) slide instead of turn."""
    return np.array([joint.shortname().startswith("JointModelP") for joint in list(bodies(urdf).joints)[1:]])


def rms(values: Array) -> Array:
    """Root mean square (n,) of rows (N, n)."""
    return np.sqrt(np.mean(values**2, axis=0))


def _reach(model: Any, frame: int, poses: Array) -> float:
    data = model.createData()
    distances = []
    for q in poses:
        pin.framesForwardKinematics(model, data, q)
        distances.append(float(np.linalg.norm(data.oMf[frame].translation)))
    return max(distances)
