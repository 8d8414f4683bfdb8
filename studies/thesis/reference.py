"""The reference models A-D: Pinocchio's inverse dynamics of a robot, friction by direction, noise of the currents.

Shares no code with the effects that must find them again: friction is written here, as the Robotics Toolbox has it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

import physident as pid
from studies.thesis.currents import measured_torque
from studies.thesis.halves import HALVES, half
from studies.thesis.published import GEAR_RATIO, MOTOR_FRICTION, RATE

Array = NDArray[np.float64]
FRICTION = {"a": False, "b": True, "c": False, "d": True}
NOISE = {"a": False, "b": False, "c": True, "d": True}


@dataclass(frozen=True, eq=False)
class Run:
    """A motion as it is, and its torques: ``time`` (N,) [s], ``q``, ``v``, ``a``, ``true`` and ``torque`` (N, n) [N m],
    the last with noise where the reference has some."""

    time: Array
    q: Array
    v: Array
    a: Array
    true: Array
    torque: Array

    def recording(self, name: str) -> pid.Recording:
        """What an arm would have recorded: time, positions, velocities, torques."""
        return pid.Recording(self.time, self.q.copy(), self.torque.copy(), "torque", self.v.copy(), source=name)

    def signals(self) -> pid.Signals:
        """The motion with its exact derivatives."""
        return pid.Signals(self.time, self.q, self.v, self.a, self.torque, rate=RATE)


def run(model: str, motion: pid.Trajectory, robot: pid.Robot, seed: int = 0, joints: slice = slice(None)) -> Run:
    """Reference model "a" to "d" of a robot whose joints are ``joints`` of the whole arm, along a motion of the arm."""
    time, q, v, a = motion.sample(RATE)
    q, v, a = (np.ascontiguousarray(x[:, joints]) for x in (q, v, a))
    true = newton_euler(robot, q, v, a)
    if FRICTION[model]:
        true = true + friction(v, joints)
    torque = measured_torque(true, np.random.default_rng(seed), joints) if NOISE[model] else true
    return Run(time, q, v, a, true, torque)


def half_run(model: str, motion: pid.Trajectory, name: str, seed: int = 0) -> Run:
    """The reference of a half as a robot of its own, as the thesis simulates it."""
    return run(model, motion, half(name), seed, HALVES[name])


def newton_euler(robot: pid.Robot, q: Array, v: Array, a: Array) -> Array:
    """Torque (N, n) [N m] by the recursive Newton-Euler algorithm, the thesis' ``rne``."""
    data = robot.pinocchio.createData()
    return np.array([pin.rnea(robot.pinocchio, data, *state) for state in zip(q, v, a, strict=True)])


def friction(v: Array, joints: slice = slice(None)) -> Array:
    """Coulomb friction (N, n) [N m] at the joint: the motor's, by direction, times the gear ratio (Table 2.5)."""
    forwards, backwards = GEAR_RATIO * MOTOR_FRICTION[joints].T
    return np.where(v > 0, forwards, np.where(v < 0, backwards, 0.0))
