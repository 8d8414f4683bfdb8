"""The torque that a machine needs along the motion that its encoders show."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import mujoco as mj
import numpy as np
from numpy.typing import NDArray

from tests.plant_mujoco.bodies import Bodies
from tests.plant_mujoco.control import rigid_torque
from tests.plant_mujoco.friction import smooth
from tests.plant_mujoco.loads import delivered, delivering, push, resistance, resisting, smooth_loads, spring
from tests.plant_mujoco.machine import Machine
from tests.plant_mujoco.stick import sticking

Array = NDArray[np.float64]
Parts = dict[int, Bodies]
FIRM = 1e12  # kg m^2: a motor that nothing disturbs
RESTING = 1e-7  # rad/s
ROUNDS = 30


def spans(parts: Parts, count: int) -> Iterator[tuple[Bodies, slice]]:
    """The bodies and the rows of N for which they are there."""
    begins = [*sorted(parts), count]
    for begin, end in pairwise(begins):
        yield parts[begin], slice(begin, end)


def loads(made: Machine, parts: Parts, time: Array, state: tuple[Array, Array, Array]) -> tuple[Array, Array]:
    """Loads of inertia and gravity, and all motor torque but friction near zero speed (N, n) [N m], along positions (N, nq),
    velocities and accelerations (N, nv) of all joints."""
    rigid = np.empty((len(time), made.n))
    more = np.empty_like(rigid)
    warm = made.warmth(time)
    active = resisting(made.disturbances)
    for bodies, rows in spans(parts, len(time)):
        q, v, a = (x[rows] for x in state)
        dof, theta, speed = bodies.dof, q[:, bodies.pos], v[:, bodies.dof]
        rigid[rows] = rigid_torque(bodies.model, bodies.data, q, v, a)[:, dof]
        more[rows] = smooth_loads(made, theta, speed, warm[rows]) + made.rotor * a[:, dof]
        if active:
            at = zip(time[rows], theta, speed, strict=True)
            more[rows] += [resistance(active, t, x, y) for t, x, y in at]
        if made.spring.any():
            more[rows] -= [spring(made, bodies, x)[dof] for x in q]
        if made.pushes:
            more[rows] += [_pushed(made, bodies, t, x)[dof] for t, x in zip(time[rows], q, strict=True)]
    return rigid, rigid + more


def _pushed(made: Machine, bodies: Bodies, time: float, q: Array) -> Array:
    """Torque (nv,) [N m] that the tool's pushes cost at generalised positions (nq,)."""
    bodies.data.qpos[:] = q
    mj.mj_kinematics(bodies.model, bodies.data)
    mj.mj_comPos(bodies.model, bodies.data)
    torque = np.zeros(bodies.model.nv)
    push(made, bodies, time, torque)
    return -torque


def near_zero(made: Machine, time: Array, v: Array, load: Array) -> Array:
    """Friction (N, n) [N m] that depends on speeds (N, n) near zero, viscous friction left out; NaN where a joint with dry
    friction is at rest."""
    law, warm, step = made.friction, made.warmth(time), float(time[1] - time[0])
    level = law.level(v, load, warm)
    rest = np.abs(v) < RESTING
    total = np.zeros_like(v)
    if law.kind == "dry":
        total = np.where(rest, np.nan, np.sign(v) * level)
    elif law.kind == "smooth":
        total = smooth(level, law.width, v)
    if law.kind == "bristle" or law.hysteretic:
        z = np.zeros((2, made.n))
        for k, speed in enumerate(v):
            near = sticking(law, speed, load[k], warm[k], z, step)
            z = near.bent(speed)
            total[k] += sum(b.force + b.slope * speed for b in near.bristles if b is not None)
    for pair in made.couplings:
        both = v[:, pair.first] + v[:, pair.second]
        felt = np.where(np.abs(both) < RESTING, np.nan, np.sign(both) * pair.dry)
        total[:, pair.first] += felt
        total[:, pair.second] += felt
    return total


def asked(made: Machine, time: Array, v: Array, needed: Array) -> Array:
    """Torque (N, n) [N m] that control must ask for so that ``needed`` is delivered, by rounds of correction."""
    active = delivering(made.disturbances)
    if not active:
        return needed
    out = needed.copy()
    for k, (t, speed, target) in enumerate(zip(time, v, needed, strict=True)):
        known = np.isfinite(target)
        target = np.where(known, target, 0.0)
        guess = target.copy()
        for _ in range(ROUNDS):
            miss = target - delivered(active, float(t), speed, guess)
            guess = guess + miss
            if np.abs(miss).max() < 1e-9:
                break
        out[k] = np.where(known, guess, np.nan)
    return out


def carried(
    made: Machine, parts: Parts, time: Array, motors: tuple[Array, Array, Array], start: Array
) -> tuple[Array, Array, Array]:
    """Motion of all joints, (N, nq) and twice (N, nv), whose motors move as given (N, n) and whose passive joints start
    from rest at generalised positions (nq,)."""
    step = float(time[1] - time[0])
    count, half, bodies = len(time), step / 2, parts[0]
    nv = bodies.model.nv
    Q, V, A = np.empty((count, len(start))), np.empty((count, nv)), np.empty((count, nv))
    q, v, a = start.copy(), np.zeros(nv), np.zeros(nv)
    for k in range(count):
        bodies = parts.get(k, bodies)
        dof, pos, model, data = bodies.dof, bodies.pos, bodies.model, bodies.data
        theta, speed, rate = (x[k] for x in motors)
        foreseen = a.copy()
        foreseen[bodies.free] = 0.0
        for _ in range(2):
            foreseen[dof] = rate
            data.qvel[:] = v + half * foreseen
            data.qvel[dof] = speed
            data.qpos[:] = q
            mj.mj_integratePos(model, data.qpos, data.qvel, half)
            data.qpos[pos] = theta
            a = _follow(made, bodies, float(time[k]), foreseen, half)
            foreseen = np.where(bodies.free, foreseen, a)
        a[dof] = rate
        V[k], A[k] = v + half * a, a
        V[k, dof], Q[k] = speed, q
        mj.mj_integratePos(model, Q[k], V[k], half)
        Q[k, pos] = theta
        mj.mj_integratePos(model, q, V[k], step)
        v = v + step * a
    return Q, V, A


def _follow(made: Machine, bodies: Bodies, time: float, foreseen: Array, half: float) -> Array:
    """Accelerations (nv,) of all joints, those of the motors as foreseen."""
    model, data, dof = bodies.model, bodies.data, bodies.dof
    implicit = half * bodies.damping + half * half * bodies.stiffness
    model.dof_armature[:] = implicit
    model.dof_armature[dof] = FIRM
    mj.mj_fwdPosition(model, data)
    mj.mj_fwdVelocity(model, data)
    torque = implicit * foreseen - bodies.stiffness * data.qpos[bodies.at] - bodies.damping * data.qvel
    torque += spring(made, bodies, data.qpos)
    if made.pushes:
        push(made, bodies, time, torque)
    torque[dof] = FIRM * foreseen[dof]
    data.qfrc_applied[:] = torque
    mj.mj_fwdAcceleration(model, data)
    # friction's rows come first; here they do nothing
    rows = int(np.sum(data.efc_type < int(mj.mjtConstraint.mjCNSTR_LIMIT_JOINT)))
    data.efc_frictionloss[:rows] = 0.0
    mj.mj_fwdConstraint(model, data)
    return data.qacc.copy()
