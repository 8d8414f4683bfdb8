"""A UR5 of known truth with and without a load, for tests of payloads and drive gains."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import physident as pid
from physident.simulation.sensors import Sensors
from tests.followed import followed

# dry friction that turns over a speed which the model is given: what a load shows is judged here, not reversals
DRY = pid.CATALOGUE["coulomb_friction"](smoothing=0.01, presliding=0.0)
EFFECTS = ("rigid_body", "rotor_inertia", "viscous_friction", DRY)
VISCOUS = (9.0, 9.0, 6.0, 2.5, 2.0, 1.5)  # N m s/rad
COULOMB = (7.7, 8.3, 7.8, 1.4, 2.0, 2.1)  # N m
SENSORS = Sensors(  # a UR5's encoder, and noise as measured on one
    encoder_step=2 * np.pi / 2**17, velocity_noise=1e-3, torque_noise=(1.5, 2.0, 1.2, 0.3, 0.3, 0.25)
)


def body(mass: float, centre: tuple[float, float, float], principal: tuple[float, float, float]) -> np.ndarray:
    """Ten parameters of a body with its principal axes along the frame's."""
    c = np.array(centre)
    I = np.diag(principal) + mass * (c @ c * np.eye(3) - np.outer(c, c))
    return np.array([mass, *(mass * c), I[0, 0], I[0, 1], I[1, 1], I[0, 2], I[1, 2], I[2, 2]])


def arm(robot: pid.Robot, load: np.ndarray | None = None) -> pid.Model:
    """The true arm, with a load (10,) on its last link."""
    model = pid.Model.nominal(robot, EFFECTS)
    theta = np.array(model.theta)
    theta[-2 * robot.n :] = [*VISCOUS, *COULOMB]
    if load is not None:
        theta[10 * (robot.n - 1) : 10 * robot.n] += load
    return replace(model, theta=theta)


def record(model: pid.Model, seed: int, sensors: Sensors = SENSORS) -> pid.Recording:
    """Twenty seconds of a random motion of its own, with the sensors' noise."""
    return followed(model, pid.random_trajectory(model.robot, seed=seed, duration=20.0), sensors, seed)
