"""A recording of the arm: what its instruments wrote, and beside it the truth that a test may know."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from tests.plant.arm import Arm
from tests.plant.controller import Controller
from tests.plant.dynamics import STEP, Run, simulate
from tests.plant.inverse import torque_along
from tests.plant.motions import Motion
from tests.plant.sensors import Sensors

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Record:
    """Rows (N,) and (N, 6) of one recording.

    Written: ``time`` [s], ``q`` [rad], ``dq`` [rad/s] or None, ``effort`` [N m] or, as ``effort_kind`` says, [A],
    ``temperature`` [degC] or None. Truth, free of noise: ``true_q`` as perfect encoders would show it, ``true_v``,
    ``true_a``, the reported torque ``with_effect`` [N m], and ``without_effect``, what a perfect model of the arm without
    the hidden effect predicts for the very same motion.
    """

    time: Array
    q: Array
    dq: Array | None
    effort: Array
    effort_kind: str
    temperature: Array | None
    true_q: Array
    true_v: Array
    true_a: Array
    with_effect: Array
    without_effect: Array

    @property
    def change(self) -> Array:
        """RMS (6,) [N m] of what the hidden effect adds to each joint's torque."""
        return np.sqrt(np.mean((self.with_effect - self.without_effect) ** 2, axis=0))

    def table(self) -> dict[str, Array]:
        """Columns (N,) under the canonical header ``time,q_1..,dq_1..,tau_1..`` or ``current_1..``."""
        effort = {"torque": "tau", "current": "current"}[self.effort_kind]
        channels = {"q": self.q, "dq": self.dq, effort: self.effort, "temperature": self.temperature}
        joints = {
            f"{name}_{j + 1}": values[:, j] for name, values in channels.items() if values is not None for j in range(6)
        }
        return {"time": self.time, **joints}

    def write_csv(self, path: str | Path) -> None:
        """Write what the instruments wrote."""
        table = self.table()
        np.savetxt(path, np.column_stack(list(table.values())), "%.10g", ",", header=",".join(table), comments="")


def record(
    arm: Arm,
    motion: Motion,
    sensors: Sensors | None = None,
    seed: int = 0,
    without: Arm | None = None,
    controller: Controller | None = None,
    step: float = STEP,
) -> Record:
    """Let the arm follow the motion and write it down; ``without`` is the arm to compare with, by default ``Arm()``."""
    sensors, rng = sensors or Sensors(), np.random.default_rng([seed, 3])
    run = simulate(arm, motion, controller, step)
    written, instants = sensors.instants(motion.duration, rng)
    q, v, a = (CubicSpline(run.time, x)(instants) for x in (run.q - arm.zero_offset, run.v, run.a))
    torque = arm.drives.reported(_late(run, arm.drives.delays, instants))
    plain = torque_along(without or Arm(), run.time, run.q - arm.zero_offset, run.v, run.a)
    shown = sensors.positions(q)
    dq = sensors.velocities(written, shown, v, rng)
    effort = torque + sensors.noise(len(written), rng)
    if sensors.drive_gains is not None:
        effort = effort / np.array(sensors.drive_gains)
    warmth = arm.temperature(instants) if arm.temperature_rise.any() else None
    rows = sensors.kept(len(written), rng)
    values = (written, shown, dq, effort, warmth, q, v, a, torque, CubicSpline(run.time, plain)(instants))
    time, shown, dq, effort, warmth, *truth = (None if x is None else x[rows] for x in values)
    kind = "torque" if sensors.drive_gains is None else "current"
    return Record(time, shown, dq, effort, kind, warmth, *truth)  # pyright: ignore[reportArgumentType]


def _late(run: Run, delays: Array, instants: Array) -> Array:
    """Motor torque (N, n) [N m], that of each joint as it was a delay (n,) [s] before the instants."""
    each = zip(run.torque.T, delays, strict=True)
    return np.column_stack([CubicSpline(run.time, tau)(np.maximum(instants - delay, 0.0)) for tau, delay in each])
