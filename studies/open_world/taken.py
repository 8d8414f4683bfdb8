"""A recording as a user has it, and beside it what only the study knows: the hidden torque."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import physident as pid
from studies.open_world.sensors import Sensors
from tests.truth import ArmTruth, Disturbance, HiddenEffect, Motion, Plant, Run

Array = NDArray[np.float64]
KEPT = 200.0  # Hz of the truth on disk
ASTRAY = 0.6  # rad|m from the plan: an arm that fell or ran away is no recording
ROUNDS = 12  # until a mixture of torques of some per cent is unmixed
SPENT = {"simulation": 0.0}  # s of processor time


class Unsound(RuntimeError):
    """A simulated arm that fell, ran away or broke: another cause has to be drawn."""


@dataclass(frozen=True, eq=False)
class Taken:
    """A ``recording``, and at its rows the ``hidden`` torque (N, n) [N m], NaN where a stuck joint leaves it open, and whether
    friction holds a joint: ``stuck`` (N, n). ``motion`` is the kind of its plan."""

    recording: pid.Recording
    hidden: Array
    stuck: NDArray[np.bool_]
    motion: str

    @property
    def alone(self) -> pid.Recording:
        """The same motion with nothing but the hidden torque; where that is open, it is bridged."""
        return replace(self.recording, effort=bridged(self.hidden))


def take(
    path: Path,
    plant: Plant,
    arm: ArmTruth,
    motion: Motion,
    sensors: Sensors,
    seed: int,
    warmer: float,
    effects: tuple[HiddenEffect, ...] = (),
    disturbances: tuple[Disturbance, ...] = (),
    known: bool = True,
) -> Taken:
    """A run of an arm with causes hidden in it, written and read as a user would; from disk where it was made before.

    Where the hidden torque is not ``known`` it is not computed, which saves time, and NaN.
    """
    csv, truth = path.with_suffix(".csv"), path.with_suffix(".npz")
    if not truth.exists():
        begun = time.process_time()
        changed = replace(arm, effects=(*arm.effects, *effects), disturbances=(*arm.disturbances, *disturbances))
        run = _sound(plant.simulate(changed, motion, warmer=warmer), motion)
        hidden = np.full_like(run.torque, 0.0 if known else np.nan)
        if known and (effects or disturbances):
            hidden = run.torque - torque_along(plant, arm, run)
        path.parent.mkdir(parents=True, exist_ok=True)
        sensors.write(run, seed, csv)
        stuck = np.zeros_like(run.q, dtype=bool) if run.at_rest is None else run.at_rest
        rows = slice(None, None, max(1, round(1 / KEPT / (run.time[1] - run.time[0]))))
        part = path.with_suffix(".part.npz")
        np.savez(part, time=run.time[rows], hidden=hidden[rows], stuck=stuck[rows])
        part.replace(truth)
        SPENT["simulation"] += time.process_time() - begun
    return _read(csv, truth, getattr(motion, "kind", type(motion).__name__.lower()))


def torque_along(plant: Plant, arm: ArmTruth, run: Run) -> Array:
    """Reported torque (N, n) [N m] that an arm needs for the motion of a run; NaN for a stuck joint, and for it alone.

    An instrument that mixes torques shows a little of a stuck joint's torque in the others; that little is taken from what the
    run reported of the stuck joint.
    """
    mixing = [d for d in arm.background if type(d).report is not Disturbance.report]
    if not mixing or run.at_rest is None:
        return plant.torque_along(arm, run)
    rest = tuple(d for d in arm.background if d not in mixing)
    torque = plant.torque_along(replace(arm, background=rest), run)
    unknown = np.isnan(torque)
    trial = np.where(unknown, run.torque, torque)
    shown = trial
    for _ in range(ROUNDS):
        shown = trial
        for disturbance in mixing:
            shown = disturbance.report(run.time, run.q, run.v, shown)
        trial = trial + np.where(unknown, run.torque - shown, 0.0)
    return np.where(unknown, np.nan, shown)


def _read(csv: Path, truth: Path, kind: str) -> Taken:
    recording = pid.load_recording(csv)
    with np.load(truth) as data:
        at = np.clip(np.searchsorted(data["time"], recording.time), 0, len(data["time"]) - 1)
        hidden = np.column_stack([np.interp(recording.time, data["time"], column) for column in data["hidden"].T])
        return Taken(recording, hidden, data["stuck"][at], kind)


def _sound(run: Run, motion: Motion) -> Run:
    """The run, where it is one of an arm under control."""
    plan, _, _ = motion.states(run.time)
    if not np.isfinite(run.torque).all() or not np.isfinite(run.q).all():
        raise Unsound("the simulated arm broke: torques or positions that are no numbers")
    if np.abs(run.q - plan).max() > ASTRAY:
        raise Unsound(f"the simulated arm left its plan by {np.abs(run.q - plan).max():.2g} rad or m")
    return run


def bridged(values: Array) -> Array:
    """Values (N, n) with straight lines where they are NaN."""
    rows = np.arange(len(values))
    result = values.copy()
    for column in result.T:
        known = np.isfinite(column)
        column[~known] = np.interp(rows[~known], rows[known], column[known]) if known.any() else 0.0
    return result
