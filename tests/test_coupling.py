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
from physident.diagnosis.search.candidate_scores import score_candidates
from physident.diagnosis.search.forward_search import settled_hypothesis
from physident.diagnosis.stability import stability
from physident.diagnosis.stability.stability import searched_in_halves
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


def test_halves_are_not_searched_for_what_the_whole_search_refused_as_a_leak(
    tmp_path: Path, ur5: pid.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of what beats chance only: what is too little to be judged may show in a half."""
    runs: list[pid.Recording] = []
    for name, arm in (("before", dry()), ("after", hide(dry(), "coulomb_friction", PAIR[0], 1.5))):
        for seed in SEEDS:
            record(arm, multisine(seed), Sensors(), seed, step=2e-3).write_csv(tmp_path / f"{name}{seed}.csv")
            runs.append(leaking(pid.load_recording(tmp_path / f"{name}{seed}.csv")))
    estimate = pid.identify(ur5, runs[:2])
    problem = state_problem("different", estimate, prepare_all(ur5, runs[2:], estimate.filter), estimate.filter, 0)
    first, pair = score_candidates(settled_hypothesis(problem, ())), ("coupled_friction", PAIR)
    every = searched_in_halves(first, ())
    assert pair in every
    monkeypatch.setattr(stability, "holds_against_leaks", lambda _, candidate: candidate.name != pair[0])
    assert every - searched_in_halves(first, ()) == {pair}
    assert searched_in_halves(first, (pair,)) == every
