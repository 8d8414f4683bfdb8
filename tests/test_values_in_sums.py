"""Of numbers that no motion shows apart from each other none is told, and those that have a value of their own are."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.diagnosis.result.values import parameter_values, values_in_words
from physident.diagnosis.search.hypothesis import AcceptedEffect, Hypothesis, state_hypothesis
from physident.diagnosis.statistics.intervals import uncertainty_of
from physident.diagnosis.statistics.normal_equations import undecided
from tests.opened import opened

NAMES = ("m", "mcx", "mcy", "mcz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
STATES = 40


@pytest.fixture(scope="module")
def state(ur5: pid.Robot, healthy_runs: list[pid.Recording]) -> Hypothesis:
    return opened(ur5, healthy_runs[:3])


def by_pinocchio(robot: pid.Robot, link: int) -> tuple[set[str], set[str]]:
    """The numbers of a link (from 1) that random states show by themselves, and those that they show in sums alone."""
    rng = np.random.default_rng(7)
    states = rng.uniform(-2, 2, (STATES, 3, robot.n))
    data = robot.pinocchio.createData()
    Y = np.concatenate([pin.computeJointTorqueRegressor(robot.pinocchio, data, *one) for one in states])
    own = Y[:, 10 * (link - 1) : 10 * link]
    _, s, vt = np.linalg.svd(own)
    same_torque = vt[s < 1e-9 * s[0]]  # changes of a link that no torque shows
    alone = np.abs(same_torque).max(axis=0, initial=0.0) < 1e-9
    felt = np.abs(own).max(axis=0) > 1e-9
    return {n for n, k in zip(NAMES, alone, strict=True) if k}, {
        n for n, k, f in zip(NAMES, alone, felt, strict=True) if f and not k
    }


@pytest.mark.parametrize("link", [1, 2, 3])
def test_the_numbers_of_a_link_are_told_where_a_motion_shows_them(state: Hypothesis, link: int) -> None:
    robot = state.problem.model.robot
    (one,) = (c for c in state.problem.candidates if c.key == ("link_inertia", (link,)))
    effect = one.options[0].effect
    assert effect is not None
    found = state_hypothesis(state.problem, [AcceptedEffect(one, effect)], state.problem.model)
    (accepted,) = found.accepted
    alone, in_sums = by_pinocchio(robot, link)
    assert {v.name for v in parameter_values(found, accepted, uncertainty_of(found))} == alone
    sentence = values_in_words(found, [accepted], uncertainty_of(found))
    assert bool(in_sums) == ("only in sums" in sentence)
    if in_sums:
        assert set(sentence.split("show ")[1].split(" of joint")[0].replace(" and ", ", ").split(", ")) == in_sums


@pytest.mark.parametrize("share", [0.0, 0.06])
def test_of_shares_only_those_are_said_that_are_certain(
    share: float, ur5: pid.Robot, healthy_runs: list[pid.Recording]
) -> None:
    """A channel that shows a part of joint 2's torque shows nothing of the other joints', and their shares are not exactly zero."""
    leaking = []
    for run in healthy_runs[:3]:
        effort = run.effort.copy()
        effort[:, 0] += share * effort[:, 1]
        leaking.append(replace(run, effort=effort))
    state = opened(ur5, leaking)
    (one,) = (c for c in state.problem.candidates if c.key == ("torque_crosstalk", (1,)))
    effect = one.options[0].effect
    assert effect is not None
    found = state_hypothesis(state.problem, [AcceptedEffect(one, effect)], state.problem.model)
    values = parameter_values(found, found.accepted[0], uncertainty_of(found))
    certain = {v.name.removeprefix("share_of_joint") for v in values if v.interval95[0] * v.interval95[1] > 0}
    said = values_in_words(found, list(found.accepted), uncertainty_of(found))
    assert len(certain) < len(values) == ur5.n - 1
    assert set(re.findall(r"what joint (\d) carries", said)) <= certain
    if share:
        assert said == "The torque reading of joint 1 also shows 6 % of what joint 2 carries."


def test_a_sum_is_decided_where_its_parts_are_not() -> None:
    rows = np.random.default_rng(3).standard_normal((50, 2))
    Y = np.column_stack([rows, 3 * rows[:, 1], np.zeros(50)])  # b and c act as b + 3 c, d not at all
    asked = np.array([[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 1, 3, 0], [0, 0, 0, 1]])
    assert undecided(Y.T @ Y, asked).tolist() == [False, True, True, False, True]
    assert undecided(0 * (Y.T @ Y), asked).all()
