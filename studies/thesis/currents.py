"""Torque to motor current and back with noise on current and torque constant (thesis eq. 4.7-4.9)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from studies.thesis.published import GEAR_RATIO, TORQUE_CONSTANT

Array = NDArray[np.float64]
SIGNAL_TO_NOISE = 50.0  # dB


def to_current(torque: Array, joints: slice = slice(None)) -> Array:
    """Motor currents (N, n) [A] of joint torques (N, n) [N m]: I = tau / (K_T G), eq. 4.7."""
    return torque / (TORQUE_CONSTANT[joints] * GEAR_RATIO)


def with_noise(values: Array, decibel: float, rng: np.random.Generator) -> Array:
    """Values plus white noise of a ratio [dB] to a signal of unit power, eq. 4.8.

    That is what MATLAB's ``awgn(x, snr)`` does where it is not told to measure the signal: 50 dB is a standard deviation
    of 3.2e-3 in the values' own unit, whatever their size.
    """
    return values + 10 ** (-decibel / 20) * rng.standard_normal(values.shape)


def measured_torque(torque: Array, rng: np.random.Generator, joints: slice = slice(None)) -> Array:
    """Joint torques (N, n) [N m] of noisy currents times a noisy torque constant times the gear ratio, eq. 4.9.

    Both noises are white and new at every sample; the thesis prints no ratio for the torque constant's, here it is that
    of the current, a standard deviation of 2.5 % (joints 1-3) and 3.4 % (joints 4-6) of the torque.
    """
    current = with_noise(to_current(torque, joints), SIGNAL_TO_NOISE, rng)
    constant = with_noise(np.broadcast_to(TORQUE_CONSTANT[joints], torque.shape), SIGNAL_TO_NOISE, rng)
    return current * constant * GEAR_RATIO
