"""Friction that builds up over a distance makes it seem to turn slowly: found beside it, the turn is sharper, and nothing else is missing."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.diagnosis.problem.problem import DiagnosisProblem, state_problem
from physident.diagnosis.problem.question import choose_question
from physident.diagnosis.search.forward_search import SearchResult, search_effects
from physident.diagnosis.search.turning_speeds import (
    _with_sharp_turns,
    _with_speeds_beside,
    search_with_turning_speeds,
)
from physident.estimation.identify import prepare_all
from tests.made_once import STEP
from tests.plant import Arm, Sensors, hide, multisine, record
from tests.serial_arms import ARMS, urdf

pytestmark = pytest.mark.slow

SLIP = 0.003  # rad
LEVELS = (8.0, 8.0, 5.0, 1.5, 1.5, 1.5)  # N m of friction that builds up over the slip


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[pid.Recording]:
    """Three recordings of an arm whose every joint slips before it slides."""
    arm, folder = Arm(), tmp_path_factory.mktemp("slipping")
    for joint, level in enumerate(LEVELS, 1):
        arm = hide(arm, "presliding_hysteresis", joint, level / SLIP, slip=SLIP)
    for seed in (31, 33, 35):
        record(arm, multisine(seed), Sensors(), seed, step=STEP).write_csv(folder / f"{seed}.csv")
    return [pid.load_recording(folder / f"{seed}.csv") for seed in (31, 33, 35)]


@pytest.fixture(scope="module")
def estimate(ur5: pid.Robot, runs: list[pid.Recording]) -> pid.Estimate:
    return pid.identify(ur5, runs[:2])


@pytest.fixture(scope="module")
def diagnosed(runs: list[pid.Recording], estimate: pid.Estimate) -> tuple[SearchResult, SearchResult, pid.Diagnosis]:
    """A search at the speeds of the model, the one of a diagnosis, which tries others, and the diagnosis."""
    single, found = [], []

    def search(problem: DiagnosisProblem, *given: Any) -> SearchResult:
        single.append(search_effects(problem))
        found.append(search_with_turning_speeds(problem, *given))
        return found[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("physident.diagnosis.learned.search_and_learn.search_with_turning_speeds", search)
        diagnosis = pid.diagnose_motion(estimate, runs[:2])
    return single[0], found[0], diagnosis


@pytest.fixture(scope="module")
def once(diagnosed: tuple[SearchResult, SearchResult, pid.Diagnosis]) -> SearchResult:
    return diagnosed[0]


@pytest.fixture(scope="module")
def again(diagnosed: tuple[SearchResult, SearchResult, pid.Diagnosis]) -> SearchResult:
    return diagnosed[1]


def widths(found: SearchResult) -> np.ndarray:
    robot = found.last.hypothesis.problem.model.robot
    (own,) = (w for e in found.last.hypothesis.problem.model.effects if (w := e.transition(robot)) is not None)
    return own


def named(found: SearchResult) -> set[str]:
    return {f"{one.candidate.name} {one.candidate.joints[0]}" for one in found.accepted}


def test_what_a_slow_turn_imitates_is_named_only_by_a_single_search(once: SearchResult, again: SearchResult) -> None:
    slipping = {f"presliding_hysteresis {joint}" for joint in range(1, 7)}
    assert named(once) > slipping  # and laws that the arm does not have
    assert named(again) == slipping


def test_beside_what_was_found_friction_turns_faster_and_never_slower(once: SearchResult, again: SearchResult) -> None:
    assert (widths(again) <= widths(once)).all()
    assert np.median(widths(again) / widths(once)) <= 0.5


def test_the_extended_model_is_closer_to_a_run_that_it_never_saw(
    runs: list[pid.Recording], estimate: pid.Estimate, diagnosed: tuple[SearchResult, SearchResult, pid.Diagnosis]
) -> None:
    found = diagnosed[2]
    assert found.estimate is not None
    gain = pid.validate(found.estimate, runs[2:]).relative_all / pid.validate(estimate, runs[2:]).relative_all
    assert np.max(gain) < 0.6


def test_the_turn_of_another_days_model_is_part_of_what_is_asked(once: SearchResult) -> None:
    assert _with_speeds_beside(once) is not None
    last = once.last
    asked = replace(last.hypothesis.problem, question="different")
    other = replace(once, last=replace(last, hypothesis=replace(last.hypothesis, problem=asked)))
    assert _with_speeds_beside(other) is None
    assert _with_speeds_beside(replace(once, accepted=())) is None


def slipping(seed: int) -> pid.Recording:
    """Two joints without measured speed. The first one's friction gives way one slider after the other, over some milliradians, and each holds
    15 per cent more at low speed (Maxwell slip with the dip of Stribeck)."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, 45.0, 0.004)
    omega, phase = rng.uniform(0.4, 2.5, (5, 2)), rng.uniform(0, 2 * np.pi, (5, 2))
    angle = time[:, None, None] * omega + phase
    q, v, a = (0.5 * part.sum(axis=1) for part in (np.sin(angle), omega * np.cos(angle), -(omega**2) * np.sin(angle)))
    model = pin.buildModelFromXML(urdf(ARMS["two"]))
    data, stretched = model.createData(), np.zeros(4)
    tau = np.array([pin.rnea(model, data, *state) for state in zip(q, v, a, strict=True)])
    for k in range(1, len(q)):
        holds = np.array([2.08, 1.56, 1.04, 0.52]) * (1 + 0.15 * np.exp(-((v[k, 0] / 0.05) ** 2)))
        stretched += np.array([1733.0, 780.0, 347.0, 173.0]) * (q[k, 0] - q[k - 1, 0])
        stretched = np.clip(stretched, -holds, holds)
        tau[k, 0] += stretched.sum()
    tau += 4 * v + 0.1 * rng.standard_normal(tau.shape)
    return pid.Recording.from_arrays(time, np.round(q / 1e-4) * 1e-4, effort=tau, source=f"{seed}")


def test_beside_friction_that_builds_up_the_sign_turns_at_once(tmp_path: Path) -> None:
    """A wide turn fits these rows as well, because it calls those near a reversal uncertain; it hides the dip and errs on unseen motions."""
    (tmp_path / "two.urdf").write_text(urdf(ARMS["two"]))
    runs, unseen = [slipping(seed) for seed in (1, 2, 3)], slipping(5)
    answer = pid.diagnose_motion(pid.identify(tmp_path / "two.urdf", runs), runs)
    assert {(one.effect, one.joints) for one in answer.causes} == {
        ("presliding_hysteresis", (1,)),
        ("stribeck_friction", (1,)),
    }
    assert answer.estimate is not None
    assert pid.validate(answer.estimate, [unseen]).rms[0] < 0.045  # 0.052 with a turn of 0.032 rad/s
    (bristles,) = (one for one in answer.causes if one.effect == "presliding_hysteresis")
    (told,) = re.findall(r"With the other dry friction of joint 1 it is ([\d.]+) N m", bristles.in_words)
    assert float(told) == pytest.approx(5.2, rel=0.02)  # what all sliders hold at speed


def built_up(seed: int) -> pid.Recording:
    """Two joints without measured speed. The friction of the first approaches its level over two milliradians (Dahl), that of the second turns with
    speed, slowly; both grow with the root of speed."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, 30.0, 0.004)
    omega, phase = rng.uniform(0.3, 2.2, (4, 2)), rng.uniform(0, 2 * np.pi, (4, 2))
    angle = time[:, None, None] * omega + phase
    q, v, a = (0.4 * part.sum(axis=1) for part in (np.sin(angle), omega * np.cos(angle), -(omega**2) * np.sin(angle)))
    model = pin.buildModelFromXML(urdf(ARMS["two"]))
    data, held = model.createData(), 0.0
    tau = np.array([pin.rnea(model, data, *state) for state in zip(q, v, a, strict=True)])
    for k in range(1, len(q)):
        step = q[k, 0] - q[k - 1, 0]
        held = np.sign(step) + (held - np.sign(step)) * np.exp(-abs(step) / 2e-3)
        tau[k, 0] += 5.0 * held
    tau[:, 1] += 4.0 * 2 / np.pi * np.arctan(v[:, 1] / 0.06)
    tau += 2.0 * np.sign(v) * np.sqrt(np.abs(v)) + 0.1 * rng.standard_normal(tau.shape)
    q += 1.5e-5 * rng.standard_normal(q.shape)
    return pid.Recording.from_arrays(time, np.round(q / 2e-5) * 2e-5, effort=tau, source=f"built up {seed}")


def test_a_wide_turn_gives_way_where_friction_builds_up_and_only_there(tmp_path: Path) -> None:
    """Beside a turn that imitates it hardly any row is certain that would show it."""
    (tmp_path / "two.urdf").write_text(urdf(ARMS["two"]))
    runs = [built_up(seed) for seed in (1, 2)]
    model = pid.identify(tmp_path / "two.urdf", runs)
    signals = prepare_all(model.model.robot, runs, model.filter)
    problem = state_problem(choose_question(model, runs), model, signals, model.filter, 0)
    robot = model.model.robot
    (given,) = (w for e in problem.model.effects if (w := e.transition(robot)) is not None)
    (searched,) = (w for e in _with_sharp_turns(problem).model.effects if (w := e.transition(robot)) is not None)
    assert given.min() > 0.005
    assert searched[0] <= 0.0042
    assert searched[1] == given[1]
