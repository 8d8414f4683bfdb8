"""Coupled friction acts on both joints of a pair alike, and a gain on what a joint's own channel shows; torque that leaks from one channel
into another does neither."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

import physident as pid
from physident.diagnosis.problem.problem import state_problem
from physident.diagnosis.search.acceptance import holds_against_leaks
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


def scaled() -> Arm:
    return hide(dry(), "torque_constant", (PAIR[1],), 0.3)


@pytest.mark.parametrize(
    ("name", "joints", "arm", "change", "holds"),
    [
        ("coupled_friction", PAIR, coupled(), lambda one: one, True),
        ("coupled_friction", PAIR, dry(), leaking, False),
        ("torque_constant", PAIR[1:], scaled(), lambda one: one, True),
        ("torque_constant", PAIR[1:], dry(), leaking, False),
    ],
    ids=("gears", "gears or channels", "gain", "gain or channels"),
)
def test_torque_that_leaks_is_no_coupling_and_no_gain(
    tmp_path: Path,
    ur5: pid.Robot,
    name: str,
    joints: tuple[int, ...],
    arm: Arm,
    change: Callable[[pid.Recording], pid.Recording],
    holds: bool,
) -> None:
    for seed in SEEDS:
        record(arm, multisine(seed), Sensors(), seed, step=2e-3).write_csv(tmp_path / f"{seed}.csv")
    recordings = [change(pid.load_recording(tmp_path / f"{seed}.csv")) for seed in SEEDS]
    estimate = pid.identify(ur5, recordings)
    problem = state_problem("missing", estimate, prepare_all(ur5, recordings, estimate.filter), estimate.filter, 0)
    hypothesis = settled_hypothesis(problem, ())
    (candidate,) = (c for c in hypothesis.data.candidates if (c.name, c.joints) == (name, joints))
    assert holds_against_leaks(hypothesis, candidate) is holds
