"""What the thesis prints: its trajectories (Tables 4.1, 4.2), friction (Table 2.5), costs and lists of base parameters."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import physident as pid

Array = NDArray[np.float64]
RATE = 125.0  # Hz
BASE_FREQUENCY = 0.15  # Hz: w_f = 0.3 pi rad/s, which the thesis writes as Hz
PERIODS = 3
COST = {"bse": 99.9, "w": 26.6}  # reached by the genetic algorithm; cond(Y_B), though eq. 3.59 says cond(Y_B^T Y_B)
HOURS = {"bse": 100.0, "w": 118.0}
GEAR_RATIO = 101.0
TORQUE_CONSTANT = np.array([0.125, 0.125, 0.125, 0.0922, 0.0922, 0.0922])  # N m/A
MOTOR_FRICTION = np.array(  # N m at the motor, forwards and backwards
    [[0.076, -0.076], [0.083, -0.082], [0.078, -0.077], [0.014, -0.014], [0.020, -0.019], [0.020, -0.021]]
)
MOTOR_INERTIA = np.array([1.87e-8, 1.87e-8, 1.87e-8, 2.07e-5, 2.07e-5, 2.07e-5])  # kg m^2
ROTOR_INERTIA = GEAR_RATIO**2 * MOTOR_INERTIA  # kg m^2 at the joint
COULOMB = GEAR_RATIO * (MOTOR_FRICTION[:, 0] - MOTOR_FRICTION[:, 1]) / 2  # N m at the joint
OFFSET = GEAR_RATIO * (MOTOR_FRICTION[:, 0] + MOTOR_FRICTION[:, 1]) / 2  # N m: what differs by direction

SINES = np.array(
    [
        [0.0094, 0.0482, 0.0038, -0.0024, -0.0214],
        [0.5765, -0.0032, -0.0051, -0.0116, 0.1018],
        [0.0435, -0.0250, 0.0174, -0.0023, -0.0074],
        [0.0642, -0.0128, 0.0186, 0.0029, -0.0212],
        [-0.6081, -0.0068, 0.0079, 0.1485, 0.0010],
        [0.6136, -0.0190, -0.1571, -0.0276, 0.0010],
    ]
)
COSINES = np.array(
    [
        [-0.0085, 0.1599, -0.0283, -0.0826, 0.0378],
        [0.1459, -0.0048, -0.0093, 0.0120, -0.0094],
        [0.6786, -0.0274, -0.0145, -0.0734, -0.0106],
        [-1.2397, 0.0079, -0.0352, -0.0082, 0.0662],
        [-0.4490, 0.0036, 0.0078, 0.0059, 0.0108],
        [0.1662, 0.0217, -0.0068, -0.0529, 0.0022],
    ]
)


def trajectory() -> pid.Trajectory:
    """The thesis' trajectory of all six joints: three periods of 6.67 s about q = 0 (Tables 4.1, 4.2)."""
    return pid.Trajectory(SINES, COSINES, np.zeros(6), BASE_FREQUENCY, PERIODS / BASE_FREQUENCY)


# Each entry of (4.4), (4.5) as it is printed: coefficients of standard parameters in the thesis' DH link frames.
PRINTED: dict[str, tuple[dict[str, float], ...]] = {
    "bse": (
        {"Izz_1": 1, "Iyy_3": 1, "Izz_3": -1},
        {"m_2": 1},
        {"mx_2": 1},
        {"my_2": 1},
        {"Ixy_2": 1},
        {"Iyy_2": 1, "Izz_2": -1},
        {"Iyz_2": 1},
        {"m_3": 1},
        {"mx_3": 1},
        {"my_3": 1},
        {"mz_3": 1},
        {"Ixx_3": 1, "Iyy_3": -1, "Izz_3": 1},
        {"Ixy_3": 1},
        {"Ixz_3": 1},
        {"Iyz_3": 1},
    ),
    "w": (
        {"mz_6": 0.2, "my_5": -0.2},
        {"mz_5": 1},
        {"mz_5": 1, "mz_6": 1},
        {"Ixy_5": 1},
        {"Ixz_5": 1},
        {"m_6 * z_5": 0.2},  # a mass of one link times the centre of another: no standard parameter
        {"Iyz_5": 1},
        {"Izz_5": 1},
        {"mx_6": 1},
        {"my_6": 1},
        {"Ixx_6": 1, "Iyy_6": -1},
        {"Ixy_6": 1},
        {"Ixz_6": 1},
        {"Iyz_6": 1},
        {"Izz_6": 1},
    ),
}
# The column that each entry stands for, once the misprints are mended: what a list of first columns can mean.
MEANT = {
    "bse": [
        "Iyy_1",
        "m_2",
        "mx_2",
        "my_2",
        "Ixy_2",
        "Iyy_2",
        "Iyz_2",
        "m_3",
        "mx_3",
        "my_3",
        "mz_3",
        "Ixx_3",
        "Ixy_3",
        "Ixz_3",
        "Iyz_3",
    ],
    "w": [
        "Iyy_4",
        "mx_5",
        "mz_5",
        "Ixy_5",
        "Ixz_5",
        "Iyy_5",
        "Iyz_5",
        "Izz_5",
        "mx_6",
        "my_6",
        "Ixx_6",
        "Ixy_6",
        "Ixz_6",
        "Iyz_6",
        "Izz_6",
    ],
}
