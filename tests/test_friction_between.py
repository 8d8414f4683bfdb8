"""How much of what a model leaves is friction that differs from one recording to the next."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.problem.problem import state_problem
from physident.diagnosis.remainder.friction_between import FrictionBetween
from physident.diagnosis.remainder.unexplained import describe_unexplained
from physident.diagnosis.search.forward_search import settled_hypothesis
from physident.estimation.identify import prepare_all
from tests.serial_arms import ARMS, swung, urdf

DRY, DRAG, NOISE = np.array([1.8, 0.9]), np.array([3.5, 1.6]), 0.05  # N m, N m s/rad, N m
LEVELS = (1.05, 0.97, 1.0, 0.98)  # of the first joint's friction, in one recording after the other


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> pid.Robot:
    path = tmp_path_factory.mktemp("between") / "planar.urdf"
    path.write_text(urdf(ARMS["two"]))
    return pid.load_robot(path)


def left(robot: pid.Robot, levels: Sequence[float]) -> tuple[FrictionBetween | None, ...]:
    """What the default model leaves of twenty seconds of each level of the first joint's friction."""
    runs = []
    for number, level in enumerate(levels):
        time = np.arange(0.0, 20.0, 0.005)
        q, v, tau = swung(np.random.default_rng(number), time)
        tau += np.array([level, 1.0]) * (DRY * np.clip(v / 1e-4, -1, 1) + DRAG * v)
        tau += NOISE * np.random.default_rng(100 + number).standard_normal(tau.shape)
        runs.append(pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=f"run{number}"))
    model = pid.identify(robot, runs)
    problem = state_problem("missing", model, prepare_all(robot, runs, model.filter), model.filter, 0)
    return tuple(one.friction_between for one in describe_unexplained(settled_hypothesis(problem, ())))


def test_the_joint_whose_friction_differs_is_told_and_by_how_much(robot: pid.Robot) -> None:
    first, second = left(robot, LEVELS)
    assert first is not None
    assert first.share > 0.5
    assert first.percent == pytest.approx(100 * (LEVELS[0] / np.mean(LEVELS) - 1), rel=0.2)
    assert second is None


def test_friction_that_is_the_same_in_every_recording_is_not_told(robot: pid.Robot) -> None:
    assert left(robot, [1.0] * 4) == (None, None)


def test_two_recordings_do_not_say_how_much_recordings_differ(robot: pid.Robot) -> None:
    assert left(robot, LEVELS[:2]) == (None, None)


def test_it_is_said_with_its_size() -> None:
    words = FrictionBetween(share=0.345, percent=4.42).in_words
    assert words.startswith("at most 34 % of it is friction")
    assert words.endswith("by up to 4.4 % of itself")
