"""Designed motions: exact gradients, limits that hold at every instant, criteria that mean what they say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.excitation.criterion.criterion import CRITERIA, Condition, make_criterion
from physident.excitation.limits.joint_limits import JointLimits, scale_into_limits
from physident.excitation.motion.series import Series
from physident.excitation.search.problem import Problem
from physident.excitation.task import task_of

TURNING = pid.CATALOGUE["coulomb_friction"](smoothing=0.01)  # so wide that a finite difference can follow it
EVERYTHING = ("rigid_body", "rotor_inertia", "viscous_friction", TURNING, "torque_offset", "load_dependent_friction")


def numbers(series: Series, seed: int) -> np.ndarray:
    return 0.3 * np.random.default_rng(seed).standard_normal(series.size)


def richardson(f, y, d, h):
    """A directional derivative to fourth order."""

    def central(step):
        return (f(y + step * d) - f(y - step * d)) / (2 * step)

    return (4 * central(h / 2) - central(h)) / 3


def test_series_are_exactly_at_rest_and_invertible():
    series = Series(4, 6, 0.2)
    y = numbers(series, 0)
    motion = series.trajectory(y, periods=3)
    assert motion.at_rest
    np.testing.assert_allclose(series.numbers(motion), y, atol=1e-13)
    states = motion.states(np.linspace(0, 5, 40, endpoint=False))
    bases = series.basis(np.linspace(0, 1, 40, endpoint=False))
    for basis, expected in zip(bases, (states.q, states.v, states.a), strict=True):
        np.testing.assert_allclose((y.reshape(4, -1) @ basis.T).T, expected, atol=1e-12)


@pytest.mark.parametrize("name", CRITERIA)
def test_gradients_against_finite_differences(ur5, name):
    for source in (ur5, pid.Model.nominal(ur5, EVERYTHING)):
        task, series = task_of(source), Series(6, 4, 0.2)
        information, criterion = task.information(series, 40), make_criterion(name)
        y = numbers(series, 1)
        slope = information.pullback(y, criterion.gradient(information.matrix(y))[1])
        for seed in range(3):
            d = np.random.default_rng(seed).standard_normal(series.size)
            expected = richardson(lambda x: criterion.gradient(information.matrix(x))[0], y, d, 6e-5)  # noqa: B023
            assert slope @ d == pytest.approx(expected, rel=5e-6, abs=1e-8)


def test_gradients_of_effects_with_a_memory(ur5):
    effects = pid.make_effects(["rigid_body", pid.CATALOGUE["presliding_hysteresis"](distance=(0.05,))])
    task, series = task_of(pid.Model.nominal(ur5, effects)), Series(6, 3, 0.2)
    information, criterion = task.information(series, 60), make_criterion("d_optimal")
    y = numbers(series, 2)
    slope = information.pullback(y, criterion.gradient(information.matrix(y))[1])
    d = np.random.default_rng(0).standard_normal(series.size)
    expected = richardson(lambda x: criterion.gradient(information.matrix(x))[0], y, d, 1e-5)
    assert slope @ d == pytest.approx(expected, rel=1e-6)


def test_information_is_pinocchios(ur5):
    """The information matrix is that of Pinocchio's regressor along the same states."""
    series = Series(6, 5, 0.15)
    task = task_of(ur5)
    y = numbers(series, 3)
    information = task.information(series, 20)
    data = ur5.pinocchio.createData()
    states = zip(*information.states(y), strict=True)
    Y = np.concatenate([pin.computeJointTorqueRegressor(ur5.pinocchio, data, *one)[:, task.chosen] for one in states])
    np.testing.assert_allclose(information.matrix(y), Y.T @ Y, atol=1e-9)
    np.testing.assert_allclose(information.matrices(np.stack([y, 2 * y]))[0], Y.T @ Y, atol=1e-9)
    value = float(Condition().values(information.matrix(y)))
    assert np.exp(value) == pytest.approx(np.linalg.cond(Y))
    # the soft condition number is an upper bound that closes as it sharpens
    bounds = [Condition(p).gradient(information.matrix(y))[0] for p in (6.0, 60.0, 600.0)]
    assert bounds[0] > bounds[1] > bounds[2] > value
    assert bounds[2] == pytest.approx(value, abs=0.02)


def test_criteria_by_hand():
    G = np.diag([4.0, 1.0, 0.25])
    assert float(make_criterion("condition").values(G)) == pytest.approx(np.log(4.0))
    assert float(make_criterion("d_optimal").values(G)) == pytest.approx(0.0)
    assert float(make_criterion("a_optimal").values(G)) == pytest.approx(0.5 * np.log((0.25 + 1 + 4) / 3))


def test_any_genes_stay_inside_the_joint_limits(ur5):
    series, limits = Series(6, 5, 0.15), JointLimits.of(ur5)
    rng = np.random.default_rng(0)
    motions = scale_into_limits(
        limits, series, 64, rng.uniform(-1, 1, (20, 6, 8)), rng.uniform(size=(20, 6)), rng.uniform(size=(20, 6))
    )
    for y in motions:
        motion = series.trajectory(y)
        assert motion.violations(ur5) == []
        assert motion.at_rest


def test_joint_rows_bound_every_instant(ur5):
    """A motion that just meets the tightened rows meets the limits between the nodes too."""
    series, limits = Series(6, 5, 0.15), JointLimits.of(ur5)
    constraints = limits.constraints(series, 48)
    y = numbers(series, 4)
    moving = np.tile([1.0] * (series.m - 1) + [0.0], 6)  # offsets stay
    y = y * moving / np.abs(constraints.value(y * moving)).max()
    assert constraints.slack(y).min() == pytest.approx(0.0, abs=1e-12)
    _, q, v, a = series.trajectory(y).sample(3000.0)
    assert (np.abs(v) <= limits.speed).all()
    assert (np.abs(a) <= limits.acceleration).all()
    assert (np.abs(q) <= limits.upper).all()


@pytest.fixture(scope="module")
def quick(ur5) -> pid.Design:
    return pid.design_trajectory(ur5, limits="joint", seed=1, harmonics=3, starts=1, generations=4)


def test_a_motion_in_which_a_joint_hardly_moves_is_not_called_good(quick: pid.Design) -> None:
    assert quick.still_joints == ()
    t, slow = quick.trajectory, np.array([1, 1, 1e-4, 1, 1, 1])
    still = replace(quick, trajectory=replace(t, a=t.a * slow[:, None], b=t.b * slow[:, None]))
    assert still.still_joints == (3,)
    assert "verdict: joint 3 hardly moves" in str(still)


def test_a_design_beats_random_motions_within_the_limits(ur5, quick):
    assert quick.trajectory.violations(ur5) == []
    assert quick.trajectory.at_rest
    assert all(one.margin > 0 for one in quick.margins)
    assert len(quick.margins) == 18
    data = ur5.pinocchio.createData()

    def condition(motion: pid.Trajectory) -> float:
        chosen = pid.find_base_parameters(ur5, pid.make_effects(["rigid_body"])).independent
        rows = zip(*motion.sample(1000 * motion.base_frequency)[1:], strict=True)
        return float(
            np.linalg.cond(
                np.concatenate([pin.computeJointTorqueRegressor(ur5.pinocchio, data, *x)[:, chosen] for x in rows])
            )
        )

    assert condition(quick.trajectory) == pytest.approx(
        quick.condition, rel=2e-3
    )  # the end of the period counts twice here
    random = [condition(pid.random_trajectory(ur5, seed, base_frequency=0.15)) for seed in range(5)]
    assert quick.condition < 0.25 * min(random)


def test_same_seed_same_motion(ur5, quick):
    again = pid.design_trajectory(ur5, limits="joint", seed=1, harmonics=3, starts=1, generations=4)
    np.testing.assert_array_equal(again.trajectory.a, quick.trajectory.a)
    np.testing.assert_array_equal(again.trajectory.q0, quick.trajectory.q0)


def test_the_problem_is_stated_in_the_robots_own_numbers(ur5):
    joints = JointLimits.of(ur5)
    task, series = task_of(ur5), Series(6, 5, 0.15)
    problem = Problem(series, Condition(), task.information(series, 48), task.information(series, 24), joints, None)
    still = problem.solution(np.zeros(series.size))
    assert still.feasible
    assert not problem.solution(50 * numbers(series, 0)).feasible
