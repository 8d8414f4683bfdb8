"""Friction that turns smoothly: by a law that no width describes exactly, and over a width that a missing effect has hidden."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.diagnosis.problem.problem import DiagnosisProblem, state_problem
from physident.diagnosis.problem.question import choose_question
from physident.diagnosis.search.forward_search import SearchResult, search_effects, settled_hypothesis
from physident.diagnosis.search.turning_speeds import _with_speeds_beside
from physident.diagnosis.stability.reversals import LOST
from physident.effects.friction import CoulombFriction
from physident.estimation.identify import prepare_all
from tests.exact_friction import WIDTH, exact_arm
from tests.made_once import STEP
from tests.plant import Sensors, hide, multisine, record
from tests.serial_arms import ARMS, urdf
from tests.sines import sines

pytestmark = pytest.mark.slow

JOINT = 5


def smooth(seed: int, width: float) -> pid.Recording:
    """Two joints without measured speed, whose friction turns as a hyperbolic tangent of speed over a ``width`` [rad/s]; the first has more
    at low speed."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, 30.0, 0.004)
    q, v, a = sines(rng, time, 4, 2, (0.3, 2.2), 0.4)
    model = pin.buildModelFromXML(urdf(ARMS["two"]))
    data = model.createData()
    tau = np.array([pin.rnea(model, data, *state) for state in zip(q, v, a, strict=True)])
    tau += np.column_stack([5.0 + 2.0 / np.cosh(v[:, 0] / 0.12), np.full(len(v), 4.0)]) * np.tanh(v / width)
    tau += 2.0 * v + 0.1 * rng.standard_normal(tau.shape)
    q += 1.5e-5 * rng.standard_normal(q.shape)
    return pid.Recording.from_arrays(time, np.round(q / 2e-5) * 2e-5, effort=tau, source=f"smooth {seed}")


@pytest.mark.parametrize("width", [0.01, 0.02])
def test_what_describes_a_turn_of_another_law_worse_is_not_handed_on(tmp_path: Path, width: float) -> None:
    """Bristles describe the slow tails of the second joint's turn, where rows count, and err at the turn, where they hardly do."""
    (tmp_path / "two.urdf").write_text(urdf(ARMS["two"]))
    runs, unseen = [smooth(seed, width) for seed in (1, 2)], smooth(5, width)
    model = pid.identify(tmp_path / "two.urdf", runs)
    answer = pid.diagnose_motion(model, runs)
    assert answer.estimate is not None
    before, after = (pid.validate(one, [unseen]).rms for one in (model, answer.estimate))
    assert after[0] < 0.1 * before[0]
    assert after[1] < 1.05 * before[1]  # with the bristles 2.9 to 4.5 times as large
    (bristles,) = (one for one in answer.findings if one.joints == (2,))
    assert (bristles.grade, LOST in bristles.doubts) == ("hint", True)
    assert [one.joints for one in answer.causes] == [(1,)]


@pytest.fixture(scope="module")
def begun(ur5: pid.Robot, tmp_path_factory: pytest.TempPathFactory) -> tuple[pid.Estimate, list[pid.Recording]]:
    """A model of an arm whose friction turns over a known width, and one joint of which has more at low speed."""
    arm, folder = hide(exact_arm(), "stribeck_friction", JOINT, 0.8, stribeck_speed=0.1), tmp_path_factory.mktemp("low")
    for seed in (41, 43):
        record(arm, multisine(seed), Sensors(), seed, step=STEP).write_csv(folder / f"{seed}.csv")
    runs = [pid.load_recording(folder / f"{seed}.csv") for seed in (41, 43)]
    return pid.identify(ur5, runs), runs


@pytest.mark.parametrize("given", [0.0, 0.001, 0.004])
def test_beside_what_was_missing_a_turn_is_as_slow_as_it_is(
    begun: tuple[pid.Estimate, list[pid.Recording]], given: float
) -> None:
    """Without the friction of low speed, a turn is too fast by as much as stands for it."""
    estimate, runs = begun
    problem = turning(estimate, runs, given)
    found = search_effects(problem)
    low = [one for one in found.accepted if one.candidate.key == ("stribeck_friction", (JOINT,))]
    assert low
    alone = replace(found.last, hypothesis=settled_hypothesis(problem, low))
    other = _with_speeds_beside(SearchResult(accepted=tuple(low), first=found.first, last=alone, overfull=False))
    assert other is not None
    (widths,) = (w for e in other.model.effects if (w := e.transition(other.model.robot)) is not None)
    assert widths[JOINT - 1] == pytest.approx(WIDTH)


def turning(estimate: pid.Estimate, runs: list[pid.Recording], width: float) -> DiagnosisProblem:
    """What is missing from a model whose friction turns over a ``width`` [rad/s] on the joint."""
    effects = []
    for effect in estimate.model.effects:
        if isinstance(effect, CoulombFriction):
            assert isinstance(effect.smoothing, tuple)
            own = tuple(width if j == JOINT - 1 else w for j, w in enumerate(effect.smoothing))
            effect = replace(effect, smoothing=own)
        effects.append(effect)
    other = replace(estimate, model=replace(estimate.model, effects=tuple(effects)))
    signals = prepare_all(other.model.robot, runs, other.filter)
    return state_problem(choose_question(other, runs), other, signals, other.filter, 0)
