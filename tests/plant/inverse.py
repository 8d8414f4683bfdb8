"""The torque an arm reports along a given motion: what a perfect model of it would predict."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from tests.plant.arm import Arm
from tests.plant.controller import Controller
from tests.plant.dynamics import simulate
from tests.plant.friction import SMOOTHING, Friction

Array = NDArray[np.float64]
HEAVY = 1e7  # kg m^2
FOLLOWING = 60.0  # rad/s: both poles of the control of heavy rotors


def torque_along(arm: Arm, time: Array, q: Array, v: Array, a: Array) -> Array:
    """Reported torque (N, 6) [N m], noise-free and without the delay's first moments, of a dense motion from rest.

    ``time`` (N,) [s] uniform; ``q`` [rad] as encoders show it, ``v``, ``a`` (N, 6).
    """
    theta = q + arm.zero_offset
    soft = arm.drives.elastic
    link = _link_motion(arm, time, theta, v, a) if len(soft) else (theta, v, a)
    load, spring = _link_torque(arm, time, link)
    motor = load + spring
    # a stiff gear's rotor is in the load, an elastic gear's is on the other side of its spring
    motor[:, soft] += arm.drives.rotor_inertia[soft] * a[:, soft]
    friction, warm = arm.friction, arm.friction.warm(time, arm.temperature(time))
    dry = friction.dry(v, warm) + friction.load_dependent * np.abs(load)
    motor += np.tanh(v / SMOOTHING) * dry + friction.wet(v, warm) + arm.drives.ripple(theta)
    if friction.stiffness.any():
        motor += friction.stiffness * _bristles(theta, friction.slip)
    delay = arm.drives.time_delay
    if delay:
        motor = CubicSpline(time, motor)(np.maximum(time - delay, time[0]))
    return arm.drives.reported(motor)


@dataclass(frozen=True, eq=False)
class _Replay:
    """A motion known at the very steps of a simulation."""

    duration: float
    motion: tuple[Array, Array, Array]

    def states(self, time: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities, accelerations (N, 6)."""
        return self.motion


def _link_motion(arm: Arm, time: Array, q: Array, v: Array, a: Array) -> tuple[Array, Array, Array]:
    """Motion (N, 6) of the links behind elastic gears whose rotors move as given: rotors too heavy to be disturbed."""
    heavy = np.full(6, HEAVY)
    drives = replace(arm.drives, rotor_inertia=heavy, ripples=())
    free = replace(arm, drives=drives, friction=Friction(np.zeros(6), np.zeros(6)), zero_offset=np.zeros(6))
    follow = Controller(tuple(FOLLOWING**2 * heavy), tuple(2 * FOLLOWING * heavy), tuple(heavy))
    run = simulate(free, _Replay(float(time[-1]), (q, v, a)), follow, float(time[1] - time[0]))
    return run.link_q, run.link_v, run.link_a


def _link_torque(arm: Arm, time: Array, link: tuple[Array, Array, Array]) -> tuple[Array, Array]:
    """Torque (N, 6) of inertia and gravity, and of springs and contacts, at the links."""
    model = arm.bodies
    data = model.createData()
    load = np.array([pin.rnea(model, data, *state) for state in zip(*link, strict=True)])
    other = arm.spring * link[0]
    if arm.contacts:
        for k, t in enumerate(time):
            contact = arm.contact_torque(data, link[0][k], t)
            other[k] += 0.0 if contact is None else contact
    return load, other


def _bristles(q: Array, slip: float) -> Array:
    """Deflection (N, 6) [rad] of dz = dq - |dq| z/slip, exact for steady motion within each step."""
    z = np.zeros_like(q)
    for k, move in enumerate(np.diff(q, axis=0), 1):
        end = slip * np.sign(move)
        z[k] = end + (z[k - 1] - end) * np.exp(-np.abs(move) / slip)
    return z
