"""Friction that differs by no more than between healthy recordings is no change; more than that is one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.grading.grades import expected_error
from physident.diagnosis.problem.columns import Columns
from physident.diagnosis.problem.problem import state_problem
from physident.diagnosis.remainder.unexplained import describe_unexplained
from physident.diagnosis.repeated.comparison import compare_with_control
from physident.diagnosis.search.forward_search import settled_hypothesis
from physident.diagnosis.search.hypothesis import AcceptedEffect, state_hypothesis
from physident.diagnosis.statistics.intervals import uncertainty_of
from physident.diagnosis.usual.as_usual import differ_as_usual, friction_of_the_day
from physident.diagnosis.usual.usual_friction import UsualFriction
from physident.dynamics.friction_parameters import friction_values
from physident.estimation.identify import prepare_all
from physident.estimation.results.fitted import fitted_recordings
from tests.serial_arms import ARMS, swung, urdf

pytestmark = pytest.mark.slow

DRY, DRAG = np.array([1.8, 0.9]), np.array([3.5, 1.6])  # N m, N m s/rad
DAILY = 0.02  # of a joint's friction, standard deviation from recording to recording
BEFORE = 5  # healthy recordings


def recorded(motion: int, noise: int, level: np.ndarray, push: float = 0.0, dip: float = 0.0) -> pid.Recording:
    """Thirty seconds of two joints with parallel axes, by pinocchio; dry friction that is a step, of a ``level`` (2,) of its own, and on the
    second joint a constant ``push`` [N m] and dry friction that is larger by ``dip`` [N m] below a tenth of a radian a second."""
    rng, time = np.random.default_rng(motion), np.arange(0.0, 30.0, 0.005)
    q, v, tau = swung(rng, time)
    tau += level * (DRY * np.clip(v / 1e-4, -1, 1) + DRAG * v)
    tau[:, 1] += push + dip * np.clip(v[:, 1] / 1e-4, -1, 1) * (np.abs(v[:, 1]) < 0.1)
    tau += 0.05 * np.random.default_rng(1000 + noise).standard_normal(tau.shape)
    return pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=f"{motion} {noise}")


def daily(number: int, share: float) -> np.ndarray:
    """The levels (2,) of a recording's friction."""
    return 1 + share * np.random.default_rng(500 + number).standard_normal(2)


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> pid.Robot:
    path = tmp_path_factory.mktemp("daily") / "planar.urdf"
    path.write_text(urdf(ARMS["two"]))
    return pid.load_robot(path)


def healthy(robot: pid.Robot, folder: Path, share: float) -> pid.Estimate:
    """The model of recordings whose friction differs by a share from one to the next."""
    paths = [folder / f"{k}.csv" for k in range(BEFORE)]
    for k, path in enumerate(paths):
        recorded(k, k, daily(k, share)).to_pandas().to_csv(path, index=False)
    return pid.identify(robot, paths)


@pytest.fixture(scope="module")
def model(robot: pid.Robot, tmp_path_factory: pytest.TempPathFactory) -> pid.Estimate:
    return healthy(robot, tmp_path_factory.mktemp("before"), DAILY)


def test_it_knows_by_how_much_healthy_recordings_differ(robot: pid.Robot, model: pid.Estimate) -> None:
    """Against the scatter of the levels that were drawn, of as many joints and recordings."""
    own = [pid.load_recording(source.path) for source in model.sources]
    found = UsualFriction.of(model.model, prepare_all(robot, own, model.filter), model.filter, 1)
    drawn = np.array([daily(k, DAILY) for k in range(BEFORE)])
    deviation = float(np.sqrt(drawn.var(axis=0, ddof=1).mean()))
    quantile = 2.75  # of Student's t for 0.05 / 4 and eight degrees of freedom, from a table
    assert found.joint == pytest.approx(quantile * deviation * np.sqrt(2), rel=0.25)


def test_more_than_a_tenth_is_never_usual(robot: pid.Robot, tmp_path: Path) -> None:
    wild = healthy(robot, tmp_path, 0.3)
    own = [pid.load_recording(source.path) for source in wild.sources]
    found = UsualFriction.of(wild.model, prepare_all(robot, own, wild.filter), wild.filter, 1)
    assert found.joint == found.arm == 0.1


@pytest.mark.parametrize("day", [11, 12, 13])
def test_a_healthy_arm_is_not_accused_of_the_friction_of_the_day(model: pid.Estimate, day: int) -> None:
    answer = pid.diagnose_motion(model, [recorded(0, day, daily(day, DAILY))])
    assert answer.compared
    assert not answer.causes
    reasons = [one.confounder for one in answer.missing_since_before if one.confounder]
    assert reasons  # it is seen, and said
    assert all("by which healthy recordings may differ, too" in text for text in reasons)
    assert "healthy recordings may differ" in " ".join(str(answer).split())


def test_more_friction_than_that_is_a_cause(model: pid.Estimate) -> None:
    answer = pid.diagnose_motion(model, [recorded(0, 21, daily(21, DAILY) * [1.0, 1.4])])
    assert {one.joints for one in answer.causes} == {(2,)}  # its dry friction, and its drag


@pytest.mark.parametrize(("level", "accused"), [(1.05, False), (0.96, False), (1.2, True)])
def test_one_recording_does_not_tell_what_is_usual(
    robot: pid.Robot, tmp_path: Path, level: float, accused: bool
) -> None:
    """Some per cent are the friction of a day on any arm; a fifth is not, and nobody needs three recordings to know."""
    recorded(0, 0, np.ones(2)).to_pandas().to_csv(tmp_path / "0.csv", index=False)
    model = pid.identify(robot, [tmp_path / "0.csv"])
    for motion in (0, 1):
        answer = pid.diagnose_motion(model, [recorded(motion, 31, np.full(2, level))])
        assert bool(answer.causes) is accused
        assert accused or "fewer than 3 recordings do not tell" in " ".join(str(answer).split())


def test_what_no_friction_makes_is_a_cause_however_small(model: pid.Estimate) -> None:
    """A twentieth of the joint's dry friction, less than its friction differs by from day to day."""
    answer = pid.diagnose_motion(model, [recorded(0, 22, daily(22, DAILY), push=0.06)])
    assert [(one.effect, one.joints) for one in answer.causes] == [("torque_offset", (2,))]


@pytest.mark.parametrize("day", [11, 12])
def test_a_healthy_arm_is_not_accused_of_the_zero_of_the_day(robot: pid.Robot, tmp_path: Path, day: int) -> None:
    """A sensor whose zero wanders from one recording to the next; a push that is three times as large as ever is told."""

    def zero(number: int) -> float:
        return float(0.04 * np.random.default_rng(700 + number).choice([-1.0, 1.0]))

    paths = [tmp_path / f"{k}.csv" for k in range(BEFORE)]
    for k, path in enumerate(paths):
        recorded(k, k, np.ones(2), push=zero(k)).to_pandas().to_csv(path, index=False)
    model = pid.identify(robot, paths)
    answer = pid.diagnose_motion(model, [recorded(0, day, np.ones(2), push=-zero(0))])
    assert answer.compared
    assert not answer.causes
    (seen,) = (one for one in answer.missing_since_before if one.effect == "torque_offset")
    assert "an offset of" in seen.confounder
    worse = pid.diagnose_motion(model, [recorded(0, day, np.ones(2), push=zero(0) + 0.4)])
    assert [(one.effect, one.joints) for one in worse.causes] == [("torque_offset", (2,))]


def test_where_healthy_recordings_agree_a_small_change_is_a_cause(robot: pid.Robot, tmp_path: Path) -> None:
    answer = pid.diagnose_motion(
        healthy(robot, tmp_path, 0.0), [recorded(0, 31, np.array([1.0, 1.06])), recorded(1, 32, np.array([1.0, 1.06]))]
    )
    assert {one.joints for one in answer.causes} == {(2,)}  # its dry friction, and its drag


def test_a_value_is_as_uncertain_as_the_friction_of_the_day_moves_it(robot: pid.Robot, model: pid.Estimate) -> None:
    """Against the same fit to recordings whose friction is larger by a standard deviation."""
    now = recorded(0, 41, np.ones(2))
    signals = prepare_all(robot, [now], model.filter)
    problem = state_problem("different", model, signals, model.filter, 0)
    (gain,) = (c for c in problem.candidates if c.key == ("torque_constant", (1,)))
    effect = gain.options[0].effect
    assert effect is not None
    state = settled_hypothesis(problem, [AcceptedEffect(gain, effect)])
    first, size = state.data.regressor.joints[0], np.sum(friction_values(problem.model), axis=0)
    own = first.columns < len(size)
    friction = 0.02 * first.values[:, own] @ size[first.columns[own]]
    none = (np.zeros(0, dtype=np.intp), np.zeros((len(friction), 0)))
    wander = Columns(1, len(friction), ((np.zeros(1, dtype=np.intp), friction[:, None]), none))
    place = state.extension.places[0][0]
    known, unsure = (uncertainty_of(state, some).theta.covariance[place, place] for some in (None, wander))
    response = state.data.response + friction[:, None] * np.array([1.0, 0.0])
    other = replace(state.data, response=response, kept={})
    again = state_hypothesis(problem, state.accepted, state.model, other)
    assert np.sqrt(unsure - known) == pytest.approx(
        abs(again.effect_values[0][0] - state.effect_values[0][0]), rel=0.02
    )


def judged_along_another_motion(model: pid.Estimate, level: float, names: list[str], dip: float = 0.0) -> list[str]:
    """Which of some effects of the second joint, all accepted, are no more than usual where its friction has a ``level``, and a
    ``dip``, now: a joint of a healthy arm differs by at most 7 %."""
    signals = prepare_all(model.model.robot, [recorded(60, 61, np.array([1.0, level]), dip=dip)], model.filter)
    problem = state_problem("different", model, signals, model.filter, 0)
    accepted = []
    for name in names:
        (one,) = (c for c in problem.candidates if c.key == (name, (2,)))
        effect = one.options[0].effect
        assert effect is not None
        accepted.append(AcceptedEffect(one, effect))
    usual = UsualFriction(
        joint=0.07, arm=0.07, offset=0.02, spread=0.025, offset_spread=0.007, freedom=8, recordings=BEFORE
    )
    return [name for name, _ in differ_as_usual(settled_hypothesis(problem, accepted), usual)]


@pytest.mark.parametrize("names", [["viscous_friction"], ["nonlinear_viscous_friction", "viscous_friction"]])
def test_along_another_motion_all_that_bends_friction_is_held_against_the_day_together(
    model: pid.Estimate, names: list[str]
) -> None:
    """What the laws and the model's own friction make of it together is as usual as one number is."""
    assert judged_along_another_motion(model, 1.05, names) == names
    assert judged_along_another_motion(model, 1.25, names) == []


@pytest.mark.parametrize("law", ["coulomb_friction", "nonlinear_viscous_friction", "presliding_hysteresis"])
def test_a_law_that_others_take_back_is_no_change_and_one_that_the_joint_has_is(model: pid.Estimate, law: str) -> None:
    names = [law, "stribeck_friction"]
    assert set(judged_along_another_motion(model, 1.05, names)) == set(names)
    assert "stribeck_friction" not in judged_along_another_motion(model, 1.05, names, dip=0.3)


def test_along_another_motion_a_torque_that_no_friction_makes_is_never_usual(model: pid.Estimate) -> None:
    assert judged_along_another_motion(model, 1.0, ["torque_offset", "joint_spring"]) == []


def test_what_friction_wanders_by_along_a_repeated_motion_is_not_left_by_a_cause(
    robot: pid.Robot, model: pid.Estimate
) -> None:
    """Against the friction that was simulated: a right model leaves the usual share of its RMS."""
    own = prepare_all(robot, list(fitted_recordings(model)), model.filter)
    now = recorded(0, 71, np.ones(2))
    signals = prepare_all(robot, [now], model.filter)
    comparison = compare_with_control(model.model, signals, own)
    problem = state_problem("different", model, comparison.signals, model.filter, 0, comparison=comparison)
    assert problem.all_compared
    state = settled_hypothesis(problem, ())
    usual = UsualFriction(joint=0.1, arm=0.1, offset=0.1, spread=0.08, offset_spread=0.0, freedom=8, recordings=BEFORE)
    rest = describe_unexplained(state)
    alone, beside = (
        expected_error(state, model, None, rest, wander) for wander in (None, friction_of_the_day(state, usual))
    )
    assert now.dq is not None
    friction = np.sqrt(np.mean((DRY * np.sign(now.dq) + DRAG * now.dq) ** 2, axis=0))
    np.testing.assert_allclose(np.sqrt(beside.right**2 - alone.right**2), 0.08 * friction, rtol=0.1)
    np.testing.assert_array_equal(beside.usual, alone.usual)
