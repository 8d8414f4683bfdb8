"""The torque an arm reports along a given motion: what a perfect model of it would predict."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from tests.plant.arm import Arm
from tests.plant.laws import Bristle, Dry, Smooth
from tests.plant.links import link_motion
from tests.plant.report import asked, reported
from tests.plant.turns import kept
from tests.truth import Disturbance

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
STILL = 1e-9  # rad/s: two moving joints whose motions cancel but for rounding


def torque_along(
    arm: Arm, time: Array, q: Array, v: Array, a: Array, stuck: Flags | None = None, seen: Array | None = None
) -> Array:
    """Reported torque (N, n) [N m], noise-free and without the delay's first moments, of a dense motion from rest.

    ``time`` (N,) [s] uniform; ``q`` [rad] as encoders show it, ``v``, ``a`` (N, n). Where dry friction takes any torque, at
    zero speed or where ``stuck`` (N, n) says so, it is NaN; ``seen`` (N, n) [N m], what was reported of this very motion,
    helps there where the measurement mixes joints or instants.
    """
    theta = q + arm.zero_offset
    motor = _overcome(arm, time, theta, v, a)
    if isinstance(arm.friction.law, Dry):
        rests = (v == 0) | (False if stuck is None else stuck)
        for pair in arm.friction.couplings:
            rests[:, [pair.first, pair.second]] |= (np.abs(v[:, pair.first] + v[:, pair.second]) < STILL)[:, None]
        motor[rests] = np.nan
    return reported(arm, time, theta, v, asked(arm, time, v, motor), seen)


def _overcome(arm: Arm, time: Array, theta: Array, v: Array, a: Array) -> Array:
    """Torque (N, n) [N m] that must act on the rotors."""
    soft = arm.drives.elastic
    link = link_motion(arm, time, theta, v, a) if len(soft) else (theta, v, a)
    load, spring = _link_torque(arm, time, link)
    motor = load + spring
    # pinocchio's torque holds a stiff gear's rotor, an elastic gear's is on the other side of its spring; no gear carries its rotor
    motor[:, soft] += arm.drives.rotor_inertia[soft] * a[:, soft]
    carried = load - np.where(arm.drives.compliance > 0, 0.0, arm.drives.rotor_inertia) * a
    motor += _friction(arm, time, theta, v, carried) + arm.drives.ripple(theta)
    resisting = [d for d in arm.disturbances if type(d).resist is not Disturbance.resist]
    for k in range(len(time)) if resisting else ():
        for disturbance in resisting:
            torque = disturbance.resist(time[k], theta[k], v[k])
            motor[k] += 0.0 if torque is None else torque
    return motor


def _friction(arm: Arm, time: Array, theta: Array, v: Array, load: Array) -> Array:
    """Friction (N, n) [N m] of joints that carry a load (N, n) [N m]."""
    friction, law = arm.friction, arm.friction.law
    warm = friction.warm(time, arm.temperature(time))
    u = v @ friction.elements.T
    level = friction.level(u, warm)
    bristles, dahl = kept(friction, float(time[1] - time[0]), theta, v, warm[:-1])
    if isinstance(law, Bristle):
        assert bristles is not None
        z = _run_through(*bristles)
        direction, torque = np.clip(z * law.stiffness / level, -1, 1), law.torque(u, z, level)
    else:
        direction = law.direction(u) if isinstance(law, Smooth) else np.sign(u)
        torque = direction * level
    total = torque @ friction.elements + direction[:, : arm.joints] * friction.load_dependent * np.abs(load)
    total += friction.wet(v, warm)
    return total if dahl is None else total + friction.stiffness * _run_through(*dahl)


def _run_through(keep: Array, gain: Array) -> Array:
    """Deflections (N, m) [rad] of bristles that start relaxed."""
    z = np.zeros((len(keep) + 1, keep.shape[1]))
    for k in range(len(keep)):
        z[k + 1] = keep[k] * z[k] + gain[k]
    return z


def _link_torque(arm: Arm, time: Array, link: tuple[Array, Array, Array]) -> tuple[Array, Array]:
    """Torque (N, n) of inertia and gravity, and of springs and contacts, at the links."""
    data = arm.bodies.createData()
    load = np.empty_like(link[0])
    for start, bodies in arm.carried:
        for k in np.flatnonzero(time + 1e-9 >= start):
            load[k] = pin.rnea(bodies, data, link[0][k], link[1][k], link[2][k])
    other = arm.spring * link[0]
    if arm.contacts:
        for k, t in enumerate(time):
            contact = arm.contact_torque(data, link[0][k], t)
            other[k] += 0.0 if contact is None else contact
    return load, other
