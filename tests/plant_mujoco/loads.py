"""What the drives must overcome besides inertia, gravity and friction near zero speed."""

from __future__ import annotations

import mujoco as mj
import numpy as np
from numpy.typing import NDArray

from tests.plant_mujoco.bodies import Bodies
from tests.plant_mujoco.machine import Machine
from tests.truth import Disturbance

Array = NDArray[np.float64]


def smooth_loads(made: Machine, q: Array, v: Array, warm: Array) -> Array:
    """Viscous friction, ripple and viscous coupling (..., n) [N m] of motors at q [rad], v [rad/s] (..., n)."""
    total = made.friction.wet(v, warm)
    for r in made.ripples:
        total[..., r.joint] += r.amplitude * np.sin(r.order * q[..., r.joint] + r.phase)
    for pair in made.couplings:
        both = pair.viscous * (v[..., pair.first] + v[..., pair.second])
        total[..., pair.first] += both
        total[..., pair.second] += both
    return total


def resisting(disturbances: tuple[Disturbance, ...]) -> tuple[Disturbance, ...]:
    """Those disturbances that resist the motion, so that the others cost nothing."""
    return tuple(d for d in disturbances if type(d).resist is not Disturbance.resist)


def delivering(disturbances: tuple[Disturbance, ...]) -> tuple[Disturbance, ...]:
    """Those disturbances that change the delivered torque."""
    return tuple(d for d in disturbances if type(d).deliver is not Disturbance.deliver)


def resistance(disturbances: tuple[Disturbance, ...], time: float, q: Array, v: Array) -> Array:
    """Their torque (n,) [N m] against the drives at one instant."""
    total = np.zeros(len(q))
    for d in disturbances:
        torque = d.resist(time, q, v)
        if torque is not None:
            total += torque
    return total


def delivered(disturbances: tuple[Disturbance, ...], time: float, v: Array, asked: Array) -> Array:
    """Torque (n,) [N m] that acts at one instant where control asks for another."""
    for d in disturbances:
        asked = d.deliver(time, v, asked)
    return asked


def push(made: Machine, bodies: Bodies, time: float, torque: Array) -> None:
    """Take from ``torque`` (nv,) [N m] what the tool's pushes on its surroundings cost; positions must be up to date."""
    force = np.sum([p.at(time) for p in made.pushes], axis=0)
    if not force.any():
        return
    data = bodies.data
    point = data.xpos[bodies.tool] + data.xmat[bodies.tool].reshape(3, 3) @ bodies.place
    mj.mj_applyFT(bodies.model, data, -force, np.zeros(3), point, bodies.tool, torque)


def spring(made: Machine, bodies: Bodies, positions: Array) -> Array:
    """Torque (nv,) [N m] by which the joint springs pull links at generalised positions (nq,) back."""
    link = bodies.link
    return -link.T @ (made.spring * (link @ positions[bodies.at]))
