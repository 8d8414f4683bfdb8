"""An arm for the tests of the simulator, with friction, and its energy."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import physident as pid
from physident.effects.friction import CoulombFriction, ViscousFriction
from physident.effects.inertia import RigidBody, RotorInertia

ROTOR = np.array([0.9, 0.8, 0.6, 0.2, 0.2, 0.2])  # kg m^2
VISCOUS = np.array([6.0, 6.0, 4.0, 2.0, 2.0, 1.0])  # N m s/rad
COULOMB = np.array([8.0, 8.0, 6.0, 2.0, 2.0, 1.5])  # N m
OFFSET = np.array([0.5, -0.4, 0.3, -0.2, 0.1, 0.2])  # N m
POSE = np.array([0.3, -1.0, 0.8, 0.2, -0.5, 0.1])
SMOOTH = CoulombFriction(smoothing=0.01, presliding=0.0)  # a function of the state, so that a model states its torque


def arm(robot: pid.Robot, coulomb: CoulombFriction = SMOOTH, *others: pid.Effect, theta: tuple = ()) -> pid.Model:
    """A UR5 with rotor inertia, viscous and dry friction, and whatever else."""
    effects = (RigidBody(), RotorInertia(), ViscousFriction(), coulomb, *others)
    return pid.Model(robot, effects, np.concatenate([robot.nominal, ROTOR, VISCOUS, COULOMB, *theta]))


def frictionless(robot: pid.Robot, rotor: np.ndarray) -> pid.Model:
    return pid.Model(robot, (RigidBody(), RotorInertia()), np.concatenate([robot.nominal, rotor]))


def resting(q: np.ndarray, duration: float) -> pid.Trajectory:
    """A motion that stays where it is."""
    none = np.zeros((len(q), 2))
    return pid.Trajectory(none, none, q, 1 / duration, duration)


def energy(model: pid.Model, states: pid.Signals, rotor: np.ndarray) -> np.ndarray:
    body = model.robot.pinocchio
    data = body.createData()
    return np.array(
        [
            pin.computeKineticEnergy(body, data, q, v) + pin.computePotentialEnergy(body, data, q) + rotor @ v**2 / 2
            for q, v in zip(states.q, states.v, strict=True)
        ]
    )


def drive(states: pid.Signals) -> np.ndarray:
    """The drive's torque (N, n)."""
    assert states.torque is not None
    return states.torque
