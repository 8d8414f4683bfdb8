"""The motion of a machine in time: an implicit midpoint rule about MuJoCo's accelerations and friction constraints.

A step reaches from half a step before an output time to half a step after it. What is stiff (control, gears, friction's
slope) is linear in the step's acceleration and enters MuJoCo's mass matrix as armature; dry friction is MuJoCo's own
constraint, asked to stop a joint within the step. The rule is of second order.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco as mj
import numpy as np
from numpy.typing import NDArray

from tests.plant_mujoco.bodies import Bodies
from tests.plant_mujoco.control import Control
from tests.plant_mujoco.loads import delivered, delivering, push, resistance, resisting, smooth_loads, spring
from tests.plant_mujoco.machine import Machine
from tests.plant_mujoco.stick import Sticking, sticking

Array = NDArray[np.float64]
STUCK = int(mj.mjtConstraintState.mjCNSTRSTATE_QUADRATIC)
TOLERANCE = 1e-4  # rad/s: a step whose speed was foreseen worse than this is made again
TRIES = 12


@dataclass(frozen=True, eq=False)
class Trace:
    """What a machine did at N output times: positions (N, nq), velocities and accelerations (N, nv) of all its joints,
    ``friction`` (N, n) [N m] near zero speed, ``excess`` (N, n) of asked over delivered torque, and who was stuck."""

    q: Array
    v: Array
    a: Array
    friction: Array
    excess: Array
    stuck: NDArray[np.bool_]


class Forward:
    """A machine under control, made ready to be stepped; ``parts`` are its bodies from a step on."""

    def __init__(self, made: Machine, control: Control, time: Array, step: float) -> None:
        self.made, self.control, self.time, self.step = made, control, time, step
        self.warm = made.warmth(time)
        self.resisting, self.delivering = resisting(made.disturbances), delivering(made.disturbances)
        self.dry = made.friction.kind == "dry"
        self.pairs = [(p.first, p.second) for p in made.couplings]
        self.frozen = np.array([p.dry for p in made.couplings])
        self.loaded = made.friction.loaded
        self.sprung = bool(made.spring.any())
        widths = made.friction.width if made.friction.kind == "smooth" else np.ones(made.n)
        self.tolerance = min(TOLERANCE, 0.02 * float(np.min(widths)))

    def use(self, bodies: Bodies) -> None:
        """Continue with these bodies."""
        self.bodies, self.model, self.data = bodies, bodies.model, bodies.data
        half, dof = self.step / 2, bodies.dof
        slope, stiff = bodies.damping.copy(), bodies.stiffness.copy()
        slope[dof] += self.control.damping + self.made.friction.viscous
        stiff[dof] += self.control.stiffness
        self.implicit = half * slope + half * half * stiff
        self.rotor = np.zeros(len(slope))
        self.rotor[dof] = self.made.rotor
        self.passive = bool(len(slope) > len(dof))
        # MuJoCo puts friction's rows first: joints, then the couplings
        self.rows = np.count_nonzero(self.model.dof_frictionloss) + self.model.ntendon

    def accelerate(self, k: int, state: tuple[Array, Array], foreseen: Array, near: Sticking) -> Array:
        """Accelerations (nv,) of step k from positions and velocities at its begin, linear about the foreseen ones."""
        bodies, model, data, made, control = self.bodies, self.model, self.data, self.made, self.control
        half, dof, time, warm = self.step / 2, bodies.dof, self.time[k], self.warm[k]
        q, v = data.qpos, data.qvel
        q[:], v[:] = state[0], state[1] + half * foreseen
        mj.mj_integratePos(model, q, state[1] + half * foreseen, half)
        theta, speed = q[bodies.pos], v[dof]
        implicit = self.implicit.copy()
        implicit[dof] += half * near.slope
        model.dof_armature[:] = self.rotor + implicit
        mj.mj_fwdPosition(model, data)
        mj.mj_fwdVelocity(model, data)
        self.asked = control.command[k] - control.stiffness * (theta - made.zero) - control.damping * speed
        self.given = delivered(self.delivering, time, speed, self.asked)
        torque = implicit * foreseen
        torque[dof] += self.given - smooth_loads(made, theta, speed, warm) - near.at(speed)
        if self.resisting:
            torque[dof] -= resistance(self.resisting, time, theta, speed)
        if self.passive:
            torque -= bodies.stiffness * q[bodies.at] + bodies.damping * v
        if self.sprung:
            torque += spring(made, bodies, q)
        if made.pushes:
            push(made, bodies, time, torque)
        data.qfrc_applied[:] = torque
        mj.mj_fwdAcceleration(model, data)
        self._constrain(state[1][dof], near.level)
        return data.qacc.copy()

    def _constrain(self, before: Array, level: Array) -> None:
        """Dry friction of at most ``level`` (n,) [N m] that would stop the joints, ``before`` (n,) [rad/s], in this step."""
        data: Any = self.data
        if not self.rows:
            mj.mj_fwdConstraint(self.model, data)
            return
        most = np.zeros(self.rows)
        if self.dry:
            most[: len(level)] = level
        if self.pairs:
            both = [before[i] + before[j] for i, j in self.pairs]
            most[-len(both) :] = self.frozen
            data.efc_aref[self.rows - len(both) : self.rows] = -np.array(both) / self.step
        if self.rows >= len(level):
            data.efc_aref[: len(level)] = -before / self.step
        data.efc_frictionloss[: self.rows] = most
        mj.mj_fwdConstraint(self.model, data)

    def run(self, parts: dict[int, Bodies], start: tuple[Array, Array]) -> Trace:
        """The motion from positions and velocities at half a step before the first output time."""
        count, n = len(self.time), self.made.n
        self.use(parts[0])
        q, v = start[0].copy(), start[1].copy()
        bodies, step, dof = self.bodies, self.step, self.bodies.dof
        Q, V, A = np.empty((count, len(q))), np.empty((count, len(v))), np.empty((count, len(v)))
        friction, excess, stuck = np.empty((count, n)), np.zeros((count, n)), np.zeros((count, n), dtype=bool)
        a, z, load = np.zeros(len(v)), np.zeros((2, n)), np.zeros((2, n))
        for k in range(count):
            if k and k in parts:
                self.use(parts[k])
                bodies = self.bodies
            near, new, loaded = self._step(k, (q, v), a, z, 2 * load[0] - load[1])
            Q[k], V[k], A[k] = q, v + step / 2 * new, new
            mj.mj_integratePos(self.model, Q[k], V[k], step / 2)
            friction[k] = near.at(V[k][dof]) - self.data.qfrc_constraint[dof]
            if self.delivering:
                excess[k] = self.asked - self.given
            z = near.bent(V[k][dof])
            mj.mj_integratePos(self.model, q, V[k], step)
            v = v + step * new
            a = new
            if self.dry:
                stuck[k] = self.data.efc_state[:n] == STUCK
                a[dof[stuck[k]]] = 0.0  # a joint that has been stopped is not stopped again
            a[bodies.free] = 0.0  # nor does the blow of a tooth last
            load[1], load[0] = load[0], loaded
        return Trace(Q, V, A, friction, excess, stuck)

    def _step(self, k: int, state: tuple[Array, Array], foreseen: Array, z: Array, load: Array) -> Any:
        """One step, made again until its speed was foreseen: the law near zero speed, accelerations, and loads (n,)."""
        dof, half = self.bodies.dof, self.step / 2
        guess = state[1][dof] + half * foreseen[dof]
        for _ in range(TRIES):
            near = sticking(self.made.friction, guess, load, self.warm[k], z, self.step)
            new = self.accelerate(k, state, foreseen, near)
            if self.loaded:
                mass = np.empty_like(new)
                mj.mj_mulM(self.model, self.data, mass, new)
                load = (mass + self.data.qfrc_bias - self.model.dof_armature * new)[dof]
            speed = state[1][dof] + half * new[dof]
            if np.abs(half * (new - foreseen)[dof]).max() < self.tolerance:
                break
            # the tangent of a saturating law overshoots; from its steepest point, zero, it does not
            guess = np.where(speed * guess < 0, 0.0, speed)
            foreseen = new
        return near, new, load
