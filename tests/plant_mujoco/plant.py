"""The second test plant: MuJoCo's bodies and friction constraints under a control of their own."""

from __future__ import annotations

from dataclasses import fields, replace

import mujoco as mj
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from tests.plant_mujoco.bodies import Bodies, compiled
from tests.plant_mujoco.control import Control, control
from tests.plant_mujoco.forward import Forward
from tests.plant_mujoco.friction import Friction
from tests.plant_mujoco.hidden import ACTS, machine
from tests.plant_mujoco.inverse import asked, carried, loads, near_zero
from tests.plant_mujoco.machine import REFERENCE, Machine
from tests.truth import ArmTruth, Motion, Run

Array = NDArray[np.float64]
STEP = 5e-4  # s
KEPT = ("kind", "width", "slip", "dips", "powers")  # what a law without friction needs all the same
SETTLING, SETTLING_STEP = 1.6, 1.2e-3  # s


class MujocoPlant:
    """An arm in MuJoCo; the arguments and results are those of ``tests.truth.Plant``."""

    name: str = "mujoco"
    effects: frozenset[str] = frozenset(ACTS)

    def simulate(self, arm: ArmTruth, motion: Motion, *, warmer: float = 0.0, step: float | None = None) -> Run:
        """The arm following a motion from rest, ``warmer`` [K] than 25 degC, in steps of ``step`` [s]."""
        step = step or STEP
        time: Array = np.arange(round(motion.duration / step) + 1) * np.float64(step)
        made = machine(arm, warmer)
        ahead = control(arm, motion.states(time))
        parts = _parts(made, time)
        start = settled(made, parts[0], ahead)
        trace = Forward(made, ahead, time, step).run(parts, (start, np.zeros(parts[0].model.nv)))
        _, needed = loads(made, parts, time, (trace.q, trace.v, trace.a))
        dof, pos = parts[0].dof, parts[0].pos
        theta, speed = trace.q[:, pos], trace.v[:, dof]
        torque = reported(made, time, theta, speed, needed + trace.friction + trace.excess)
        warmth = REFERENCE + warmer + made.warmed(time)
        rest = trace.stuck if made.friction.kind == "dry" else None
        return Run(time, theta - made.zero, speed, trace.a[:, dof], torque, warmth, rest)

    def torque_along(self, arm: ArmTruth, run: Run) -> Array:
        """Reported torque (N, n) [N m] for the encoder motion of a run, at its temperature; NaN at rest by dry friction."""
        start = float(np.mean(run.temperature[0])) - REFERENCE
        made, time = machine(arm, start), run.time
        parts = _parts(made, time)
        motors = (run.q + made.zero, run.v, run.a)
        state = motors
        if parts[0].model.nv > made.n:
            first = _hung(made, parts[0], motors[0][0])
            held = _held(made, motors[0][0])
            first = settled(replace(made, disturbances=()), parts[0], held, first)
            state = carried(made, parts, time, motors, first)
        rigid, needed = loads(made, parts, time, state)
        needed = needed + near_zero(made, time, run.v, rigid)
        if made.friction.kind == "dry" and run.at_rest is not None:
            needed[run.at_rest] = np.nan
        return reported(made, time, motors[0], run.v, asked(made, time, run.v, needed))


def _parts(made: Machine, time: Array) -> dict[int, Bodies]:
    """The bodies from each row of ``time`` on: loads that will be dropped are there until their time."""
    events = sorted({0.0, *(t for t, _ in made.drops)})
    parts: dict[int, Bodies] = {}
    for event in events:
        links = made.links.copy()
        links[-1] += sum((body for t, body in made.drops if t > event), start=np.zeros(10))
        row = int(np.searchsorted(time, event - 1e-9))
        if row < len(time):
            parts[row] = compiled(made, links)
    return parts


def _hung(made: Machine, bodies: Bodies, theta: Array, rest: Array | None = None) -> Array:
    """Generalised positions (nq,) with the motors at theta (n,), other joints as in ``rest`` and a swinging load along
    gravity."""
    model, data = bodies.model, bodies.data
    data.qpos[:] = model.qpos0 if rest is None else rest
    data.qpos[bodies.pos] = theta
    if made.pendulum:
        mj.mj_kinematics(model, data)
        turn = data.xmat[bodies.tool].reshape(3, 3) @ made.tree.tool[:3, :3]
        up = -turn.T @ made.gravity / np.linalg.norm(made.gravity)
        where = int(model.joint("swing").qposadr[0])
        quaternion = np.zeros(4)
        mj.mju_quatZ2Vec(quaternion, up)
        data.qpos[where : where + 4] = quaternion
    return data.qpos.copy()


def _held(made: Machine, theta: Array) -> Control:
    """Control so stiff that the motors stay at theta (n,)."""
    stiffness = np.full(made.n, 1e9)
    return Control(stiffness, stiffness / 50, (stiffness * (theta - made.zero))[None])


def settled(made: Machine, bodies: Bodies, ahead: Control, start: Array | None = None) -> Array:
    """Generalised positions (nq,) at which the arm stands still at time 0 without the help of friction.

    The passive joints are damped so heavily meanwhile that they come to rest; a swinging load is hung anew in the end.
    """
    count, zero = round(SETTLING / SETTLING_STEP), np.zeros(made.n)
    hold = replace(ahead, command=np.repeat(ahead.command[:1], count, axis=0))
    easy = replace(made, friction=_without(made.friction), couplings=())
    heavy = replace(bodies, damping=20 * bodies.damping + 0.05 * bodies.stiffness)
    forward = Forward(easy, hold, zero[:1].repeat(count), SETTLING_STEP)
    now = _hung(made, bodies, ahead.command[0] / ahead.stiffness + made.zero) if start is None else start
    for _ in range(2 if made.pendulum else 1):
        trace = forward.run({0: heavy}, (now, np.zeros(bodies.model.nv)))
        now = trace.q[-1]
        if made.pendulum:
            now = _hung(made, bodies, now[bodies.pos], now)
    return now


def _without(law: Friction) -> Friction:
    """No friction but a viscous one."""
    return replace(
        law,
        kind="smooth",
        **{f.name: np.zeros(len(law.width)) for f in fields(law) if f.name not in KEPT},
        dips=(),
        powers=(),
    )


def _late(time: Array, torque: Array, delay: float) -> Array:
    """Torque (N,) of one channel as it was a delay [s] before; unknown where it was unknown on either side."""
    if not delay:
        return torque
    known, late = np.isfinite(torque), np.maximum(time - delay, time[0])
    shown = CubicSpline(time, np.where(known, torque, 0.0))(late)
    near = np.clip(np.searchsorted(time, late - 1e-12), 1, len(time) - 1)
    shown[~(known[near] & known[near - 1])] = np.nan
    return shown


def reported(made: Machine, time: Array, q: Array, v: Array, torque: Array) -> Array:
    """Torque (N, n) [N m] as the instruments show that of the motors: late, scaled, shifted, and disturbed at last."""
    torque = np.column_stack(
        [_late(time, tau, delay) for tau, delay in zip(torque.T, np.broadcast_to(made.delay, made.n), strict=True)]
    )
    torque = (1.0 + made.constant) * torque + made.offset
    for d in made.disturbances:
        torque = d.report(time, q, v, torque)
    return torque
