"""Recordings of an arm that follows its plan exactly, for tests whose subject is not the simulator."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
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


def follow_exactly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let every simulated arm follow its plan as here, also where it is simulated by the command line."""

    def integrate(model: pid.Model, motion: Motion, *given: Any) -> pid.Signals:
        step = given[2]
        parts = [(e, t) for e, t in model.effect_parameters() if e.acts_on == "plant"]
        plant = pid.Model(model.robot, tuple(e for e, _ in parts), np.concatenate([t for _, t in parts]))
        planned = motion.states(step * np.arange(round(motion.duration / step) + 1, dtype=float))
        return replace(planned, torque=plant.torque(planned), rate=1 / step, source="simulation")

    monkeypatch.setattr("physident.simulation.simulate.integrate", integrate)
