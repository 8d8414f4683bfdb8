"""A simulated recording: the true motion of a model's robot, seen through its sensors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from physident.dynamics.model import Model
from physident.errors import InputError
from physident.estimation.estimate import Estimate
from physident.excitation.motion.motion import Motion
from physident.recordings.columns.layout import ColumnLayout
from physident.recordings.formats.table import Table
from physident.recordings.recording import Recording, recording_from_rows
from physident.recordings.rows import MIN_DURATION
from physident.recordings.signals import Signals
from physident.simulation.beyond_curves import warn_beyond_curves
from physident.simulation.controllers import Controller
from physident.simulation.integrate import STEP, check_step, integrate
from physident.simulation.radau import ExtraTorque
from physident.simulation.sensors import Sensors
from physident.threads import one_thread

IDEAL = Sensors()


@dataclass(frozen=True, eq=False)
class Simulation:
    """The settings of one simulated recording; see ``simulate``."""

    model: Model
    trajectory: Motion
    controller: Controller | None = None
    sensors: Sensors = IDEAL
    extra_torque: ExtraTorque | None = None
    seed: int = 0
    step: float = STEP

    def table(self) -> Table:
        """The table that the sensors write, bad rows included."""
        sensors, robot = self.sensors, self.model.robot
        check_step(self.step)
        sensors.check(robot)
        if self.trajectory.duration < MIN_DURATION:
            raise InputError(
                f"simulation: the motion lasts {self.trajectory.duration:g} s, expected at least {MIN_DURATION:g} s"
            )
        # sampling instants lie on the integration's grid, so that without jitter nothing is interpolated
        period = 1 / sensors.rate
        step = period / math.ceil(period / self.step - 1e-9)
        warming = sensors.temperature
        truth = integrate(
            self.model,
            self.trajectory,
            self.controller,
            self.extra_torque,
            step,
            None if warming is None else lambda time: warming.at(time, robot.n),
        )
        warn_beyond_curves(self.model, truth)
        rng = np.random.default_rng(self.seed)
        return sensors.read(robot, measured(self.model, truth), self.trajectory.duration, rng)

    def recording(self, table: Table) -> Recording:
        """The recording of such a table, without its bad rows."""
        assert table.names is not None
        layout = ColumnLayout.from_header(table.names, "simulation")
        source = f"simulation of {self.model.robot.name}, seed {self.seed}"
        recording = recording_from_rows(layout.split(table.values), source, table.rows)
        if layout.effort_kind == "torque":
            return recording
        return recording.with_drive_gains(self.sensors.gains(self.model.robot).tolist())

    def run(self) -> Recording:
        """The recording."""
        return self.recording(self.table())


@one_thread
def simulate(
    model: Model | Estimate,
    trajectory: Motion,
    controller: Controller | None = None,
    sensors: Sensors | None = None,
    extra_torque: ExtraTorque | None = None,
    seed: int = 0,
    step: float = STEP,
) -> Recording:
    """A recording of the model's robot that follows a trajectory, with every effect the model has.

    ``controller``: ``PD`` (default, 8 Hz), ``ComputedTorque`` or ``Released``; ``sensors``: ideal ones at 125 Hz by
    default; ``extra_torque(time, q, v)`` (n,) [N m|N] pushes the joints from outside and is not measured; ``seed`` of
    the sensors' noise; ``step`` [s] the longest of the integration. Raises InputError and NotSolvedError as
    ``integrate``, and InputError for a motion under two seconds; warns of a learned curve whose range the motion leaves.
    """
    model = model.model if isinstance(model, Estimate) else model
    return Simulation(model, trajectory, controller, sensors or IDEAL, extra_torque, seed, step).run()


def simulate_many(simulations: Sequence[Simulation], processes: int | None = None) -> list[Recording]:
    """Recordings of many simulations in parallel processes (by default one for each core), with a progress bar.

    An ``extra_torque`` must be a function that other processes can import. Raises the first error of any of them.
    """
    from concurrent.futures import ProcessPoolExecutor

    from rich.console import Console
    from rich.progress import track

    with ProcessPoolExecutor(processes) as pool:
        results = pool.map(Simulation.run, simulations)
        bar = track(results, "simulating", len(simulations), console=Console(stderr=True), transient=True)
        return list(bar)


def measured(model: Model, truth: Signals) -> Signals:
    """True signals with the measurement effects of the model: offsets, torque constants, delays, joint zeros."""
    if any(effect.needs_model for effect in model.effects):
        truth = replace(model.refer(truth), motor=truth.torque)
    at = 0
    for effect in model.effects:
        k = len(effect.columns(model.robot))
        truth = effect.measure(model.robot, model.theta[at : at + k], truth)
        at += k
        if not all(np.isfinite(x).all() for x in (truth.q, truth.v, truth.torque) if x is not None):
            raise InputError(f"effect {effect.name}: gives values that are not finite; expected finite numbers")
    return truth
