"""A healthy arm's recordings, and the state in which the search for what is different in them begins."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import physident as pid
from physident.diagnosis.case import Case
from physident.diagnosis.question import ask
from physident.diagnosis.search import settled
from physident.diagnosis.state import State
from physident.estimation.identify import prepare_all
from tests.exact_friction import exact_arm
from tests.plant import Sensors, multisine, record

SEEDS = (31, 33, 35, 37)


def record_healthy(folder: Path) -> list[pid.Recording]:
    """Four recordings of one healthy arm, made in a folder."""
    for seed in SEEDS:
        record(exact_arm(), multisine(seed), Sensors(), seed, step=2e-3).write_csv(folder / f"{seed}.csv")
    return [pid.load_recording(folder / f"{seed}.csv") for seed in SEEDS]


def opened(robot: pid.Robot, runs: list[pid.Recording], change: np.ndarray | None = None) -> State:
    """The recordings from the third on put to the model of the first two, with a torque (N, 6) added to them."""
    estimate = pid.identify(robot, runs[:2])
    asked = [r if change is None else replace(r, effort=r.effort + change[: len(r.time)]) for r in runs[2:]]
    signals = prepare_all(robot, asked, estimate.filter)
    return settled(Case.open(ask(estimate, runs[2:]), estimate, signals, estimate.filter, 0), ())
