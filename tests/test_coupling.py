"""Coupled friction acts on both joints of a pair alike; torque that leaks from one channel into another does not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

import physident as pid
from physident.diagnosis.problem.problem import state_problem
from physident.diagnosis.search.acceptance import holds_on_each_joint
from physident.diagnosis.search.forward_search import settled_hypothesis
from physident.estimation.identify import prepare_all
from tests.plant import Arm, Sensors, hide, multisine, record
from tests.plant.laws import Dry

SEEDS = (61, 63)
PAIR = (5, 6)


def dry() -> Arm:
    plain = Arm()
    return replace(plain, friction=replace(plain.friction, law=Dry()))


def leaking(recording: pid.Recording) -> pid.Recording:
    """A third of what the fifth channel shows stands in the sixth too."""
    effort = recording.effort.copy()
    effort[:, 5] += effort[:, 4] / 3
    return replace(recording, effort=effort)


def coupled() -> Arm:
    return hide(dry(), "coupled_friction", PAIR, 0.8 * float(Arm().friction.coulomb[5]))


@pytest.mark.parametrize(
    ("arm", "change", "holds"), [(coupled(), lambda one: one, True), (dry(), leaking, False)], ids=("gears", "channels")
)
def test_what_couples_two_joints_acts_on_both_alike(
    tmp_path: Path, ur5: pid.Robot, arm: Arm, change: Callable[[pid.Recording], pid.Recording], holds: bool
) -> None:
    for seed in SEEDS:
        record(arm, multisine(seed), Sensors(), seed, step=2e-3).write_csv(tmp_path / f"{seed}.csv")
    recordings = [change(pid.load_recording(tmp_path / f"{seed}.csv")) for seed in SEEDS]
    estimate = pid.identify(ur5, recordings)
    problem = state_problem("missing", estimate, prepare_all(ur5, recordings, estimate.filter), estimate.filter, 0)
    hypothesis = settled_hypothesis(problem, ())
    (candidate,) = (c for c in hypothesis.data.candidates if (c.name, c.joints) == ("coupled_friction", PAIR))
    assert holds_on_each_joint(hypothesis, candidate) is holds
