"""Recordings of an arm that follows its plan exactly, for tests whose subject is not the simulator."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.excitation.motion.motion import Motion
from physident.simulation.simulate import Simulation

Array = NDArray[np.float64]
STEP = 0.004  # s: as in a simulation, so that sampling instants at 125 Hz and 250 Hz lie on the grid


def followed(model: pid.Model, motion: Motion, sensors: pid.Sensors, seed: int) -> pid.Recording:
    """What ``pid.simulate`` records of a model of effects without measurement, had the arm a perfect control.

    Every effect is in it, and the noise is the same; no equation of motion is solved, which takes seconds.
    """
    time: Array = STEP * np.arange(round(motion.duration / STEP) + 1, dtype=float)
    planned = motion.states(time)
    truth = replace(planned, torque=model.torque(planned), rate=1 / STEP)
    table = sensors.read(model.robot, truth, motion.duration, np.random.default_rng(seed))
    return Simulation(model, motion, sensors=sensors, seed=seed).recording(table)
