"""Drive gains of an arm whose gains are known, from currents whose errors have a memory: bias, error, coverage."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

import physident as pid

EFFECTS = ("rigid_body", "rotor_inertia", "viscous_friction", "coulomb_friction")
VISCOUS = (9.0, 9.0, 6.0, 2.5, 2.0, 1.5)  # N m s/rad
COULOMB = (7.7, 8.3, 7.8, 1.4, 2.0, 2.1)  # N m
GAINS = np.array([14.0, 12.0, 10.0, 9.0, 11.0, 8.0])  # N m/A
ERROR = np.array([4.0, 5.0, 3.0, 1.0, 1.0, 0.8])  # N m, about what five effects leave of a real UR10e's torque
MEMORY = 0.33  # s
MASS, CENTRE, RADIUS = 4.0, np.array([0.05, 0.08, 0.1]), 0.05  # kg, m, m
RATE = 100.0  # Hz
ARMS = 40
Array = NDArray[np.float64]


def simulated_gains() -> dict[str, Any]:
    """Three unloaded and one loaded recording of 20 s for each of ``ARMS`` arms; errors of log gains, in percent."""
    robot = pid.load_robot("ur5")
    free = pid.Model.nominal(robot, EFFECTS)
    free = replace(free, theta=np.concatenate([free.theta[:-12], VISCOUS, COULOMB]))
    tensor = MASS * ((2 * RADIUS**2 + CENTRE @ CENTRE) * np.eye(3) - np.outer(CENTRE, CENTRE))
    load = np.array([MASS, *(MASS * CENTRE), *tensor[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]])
    theta = np.array(free.theta)
    theta[10 * (robot.n - 1) : 10 * robot.n] += load
    carrying = replace(free, theta=theta)
    errors: dict[str, list[Array]] = {"tls": [], "ls": []}
    inside = []
    for arm in range(ARMS):
        unloaded = [_record(free, 100 * arm + part) for part in range(3)]
        loaded = [_record(carrying, 100 * arm + 3)]
        for method, found in errors.items():
            gains = pid.identify_drive_gains(robot, unloaded, loaded, MASS, method, EFFECTS)
            found.append(100 * np.log(np.maximum(gains.gains, 1e-3) / GAINS))
            if method == "tls":
                inside.append((gains.intervals[:, 0] < GAINS) & (gains.intervals[:, 1] > GAINS))
    return {
        "arms": ARMS,
        "memory_s": MEMORY,
        "load_kg": MASS,
        "tls_bias_percent": np.mean(errors["tls"], axis=0).tolist(),
        "tls_rms_percent": np.sqrt(np.mean(np.square(errors["tls"]), axis=0)).tolist(),
        "tls_coverage_percent": (100 * np.mean(inside, axis=0)).tolist(),
        "tls_coverage_all_percent": float(100 * np.mean(inside)),
        "ls_bias_percent": (100 * np.expm1(np.mean(errors["ls"], axis=0) / 100)).tolist(),
    }


def _record(model: pid.Model, seed: int) -> pid.Recording:
    """Currents along a random motion, with an error of first order (an exponential memory) in every joint."""
    time, q, v, a = pid.random_trajectory(model.robot, seed=seed, duration=20.0).sample(RATE)
    torque = model.torque(pid.Signals.of_states(q, v, a))
    keep = np.exp(-1 / (RATE * MEMORY))
    white = np.random.default_rng(seed).normal(size=torque.shape)
    error = lfilter([np.sqrt(1 - keep**2)], [1, -keep], white, axis=0) * ERROR
    return pid.Recording(time, q, (torque + error) / GAINS, "current", dq=v)
