"""How a design went on: every iteration that led to the motion, with the condition number that the result states."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.excitation.criterion.criterion import Condition
from physident.excitation.limits.constraints import Constraints
from physident.excitation.limits.joint_limits import JointLimits
from physident.excitation.motion.series import Series
from physident.excitation.search.genetic import evolve
from physident.excitation.search.ipopt import minimise
from physident.excitation.search.problem import Solution, Stage
from physident.excitation.search.search import _later_solutions
from physident.excitation.task import CHECKED, task_of
from tests.serial_arms import ARMS, urdf

pytestmark = pytest.mark.slow

GENERATIONS = 4


@pytest.fixture(scope="module")
def designs(ur5: pid.Robot, tmp_path_factory: pytest.TempPathFactory) -> dict[str, pid.Design]:
    """Quick ones: of the bare arm; by another criterion, and one that tells two rivals apart, of an arm of two joints."""
    path = tmp_path_factory.mktemp("arm") / "two.urdf"
    path.write_text(urdf(ARMS["two"]))
    two = pid.load_robot(path)
    quick: dict[str, Any] = {"limits": "joint", "harmonics": 3, "starts": 2, "generations": GENERATIONS, "seed": 1}
    told = pid.design_discriminating(two, "coulomb_friction", "load_dependent_friction", joint=2, noise=0.5, **quick)
    return {
        "condition": pid.design_trajectory(ur5, **quick),
        "d_optimal": pid.design_trajectory(two, "d_optimal", **quick),
        "rivals": told.design,
    }


@pytest.mark.parametrize("name", ["condition", "d_optimal", "rivals"])
def test_the_last_entry_is_what_the_result_states(designs: dict[str, pid.Design], name: str) -> None:
    one = designs[name]
    written = json.loads(json.dumps(one.as_dict(), allow_nan=False))
    assert written["progress"][-1] == pytest.approx(written["condition"], rel=1e-9)
    assert written["generations"] == GENERATIONS
    assert len(written["progress"]) > GENERATIONS + 5
    assert min(written["progress"]) >= 1  # no condition number is less


def test_every_entry_is_pinocchios_condition_number(designs: dict[str, pid.Design], ur5: pid.Robot) -> None:
    one = designs["condition"]
    t, data = one.trajectory, ur5.pinocchio.createData()
    series, chosen = Series(t.n, t.harmonics, t.base_frequency), task_of(ur5).chosen
    for k in (0, GENERATIONS - 1, GENERATIONS, len(one.progress) // 2, len(one.progress) - 1):
        states = series.trajectory(one.iterates[k]).states(np.arange(CHECKED) / CHECKED * series.period)
        rows = zip(states.q, states.v, states.a, strict=True)
        Y = [pin.computeJointTorqueRegressor(ur5.pinocchio, data, *row)[:, chosen] for row in rows]
        assert one.progress[k] == pytest.approx(float(np.linalg.cond(np.concatenate(Y))), rel=1e-6)


def test_it_goes_down(designs: dict[str, pid.Design]) -> None:
    progress = np.array(designs["condition"].progress)
    assert progress[-1] < 0.5 * progress[GENERATIONS - 1] < 0.5 * progress[0]
    assert progress[-1] <= 1.01 * progress.min()  # a point outside the limits may lie a little lower


def test_the_best_of_a_generation_is_never_worse_than_of_the_one_before(ur5: pid.Robot) -> None:
    series, task = Series(6, 3, 0.15), task_of(ur5)
    information = task.information(series, 24)
    heard: list[np.ndarray] = []
    fitness = lambda y: Condition().values(information.matrices(y))  # noqa: E731
    last = evolve(JointLimits.of(ur5), series, fitness, None, 6, 0, population=40, on_generation=heard.append)
    values = fitness(np.array(heard))
    assert len(heard) == 6
    assert (np.diff(values) <= 1e-12).all()
    np.testing.assert_array_equal(heard[-1], last[0])


def test_the_solver_tells_the_point_after_each_iteration() -> None:
    pattern = np.array([[0, 0], [1, 1]])
    rows = Constraints(np.full(2, -2.0), np.full(2, 2.0), pattern, lambda y: y, lambda _: np.ones(2))
    heard: list[np.ndarray] = []
    aim, start = np.array([1.0, 5.0]), np.array([-1.5, -1.0])
    end = minimise(lambda y: (float((y - aim) @ (y - aim)), lambda: 2 * (y - aim)), rows, start, 50, heard.append)
    np.testing.assert_allclose(end, [1.0, 2.0], atol=1e-3)
    np.testing.assert_array_equal(heard[-1], end)
    assert not np.array_equal(heard[0], start)
    assert 1 < len(heard) <= 50
    few: list[np.ndarray] = []
    minimise(lambda y: (float((y - aim) @ (y - aim)), lambda: 2 * (y - aim)), rows, start, 2, few.append)
    np.testing.assert_allclose(few, heard[:2])  # one iteration after the other, and no more than asked for


@pytest.mark.parametrize(("behind", "stages"), [(0.02, 3), (0.07, 2), (0.5, 1)])
def test_a_start_far_behind_is_given_up(behind: float, stages: int) -> None:
    """The best one cost 2.6, 2.55 and 2.5 after its stages; a start is ``behind`` those by a constant."""
    best = [2.6, 2.55, 2.5]
    left = iter(best)
    problem: Any = SimpleNamespace(improve=lambda one, _: Solution(one.y, 0.0, 0.0, next(left) + behind))
    later = tuple(Stage(p, 10) for p in (20.0, 60.0, 200.0))
    begun = Solution(np.zeros(1), 0.0, 0.0, 3.0)
    assert len(list(_later_solutions(problem, begun, later, best))) == stages
    left = iter(best)
    assert len(list(_later_solutions(problem, begun, later, []))) == 3  # the first to be finished has none to be behind
