"""A joint whose friction differs by far more than that of all others, along the same repeated motion, has changed."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import physident as pid
from physident.diagnosis.usual.other_joints import as_other_joints_show
from physident.diagnosis.usual.usual_friction import UsualFriction
from physident.dynamics.model import Model

ACCUSED, ROWS = 3, 50  # the joint on which something was found
SAMPLES = 5  # that say how far the recordings of a healthy arm are apart: three of them, of few joints


def usual(spread: float, limit: float = 0.1) -> UsualFriction:
    """What the recordings of a healthy arm say."""
    return UsualFriction(
        joint=limit, arm=0.1, offset=0.1, spread=spread, offset_spread=0.0, freedom=SAMPLES, recordings=3
    )


def compared(robot: pid.Robot, shares: NDArray[np.float64], all_compared: bool = True) -> Any:
    """Recordings that repeat a motion, in which the friction of each joint is more by a share, and nothing else is; something was found on
    one joint."""
    model = Model.nominal(robot, ["coulomb_friction"])
    model = Model(robot, model.effects, np.linspace(1.0, 2.0, robot.n))
    sign = np.random.default_rng(0).choice([-1.0, 1.0], (ROWS, robot.n))
    joints = [SimpleNamespace(columns=np.array([j]), values=sign[:, [j]]) for j in range(robot.n)]
    problem = SimpleNamespace(model=model, all_compared=all_compared, regressor=SimpleNamespace(joints=joints))
    found = SimpleNamespace(candidate=SimpleNamespace(joints=(ACCUSED,)), effect=None)
    change = shares * model.theta * sign
    own = np.where(np.arange(robot.n) == ACCUSED - 1, change, 0.0)  # the effect takes all of its joint's
    columns = SimpleNamespace(torque=lambda values: own)
    return SimpleNamespace(
        problem=problem, fit=SimpleNamespace(residual=change - own), accepted=(found,), effect_values=(np.ones(1),),
        columns=lambda candidate, effect: columns,
    )  # fmt: skip


def test_where_the_other_joints_agree_a_small_change_is_more_than_usual(ur5: pid.Robot) -> None:
    """Recordings of other motions seem 4 % apart by what the model lacks; along the repeated one the other joints are 0.3 % apart."""
    shares = np.array([0.003, -0.002, 0.05, 0.004, -0.003, 0.002])
    found = as_other_joints_show(compared(ur5, shares), usual(0.04))
    deviation = np.sqrt(np.mean(np.delete(shares, ACCUSED - 1) ** 2))
    quantile = 4.22  # of Student's t for 0.05 / 12 and five degrees of freedom, from a table
    assert abs(found.joint / (quantile * deviation) - 1) < 0.02
    assert found.joint < 0.05
    assert found.offset == 0.1


def test_joints_that_are_left_of_several_findings_say_nothing(ur5: pid.Robot) -> None:
    """They were chosen: those that differ by more have a finding of their own."""
    state = compared(ur5, np.array([0.003, -0.002, 0.05, 0.004, -0.003, 0.002]))
    state.accepted = (*state.accepted, SimpleNamespace(candidate=SimpleNamespace(joints=(5,)), effect=None))
    state.effect_values = (*state.effect_values, np.ones(1))
    assert as_other_joints_show(state, usual(0.04)) == usual(0.04)


def test_where_the_other_joints_differ_as_recordings_do_nothing_is_changed(ur5: pid.Robot) -> None:
    shares = np.array([0.03, -0.02, 0.05, 0.04, -0.03, 0.02])
    assert as_other_joints_show(compared(ur5, shares), usual(0.04)) == usual(0.04)


def test_no_joint_is_expected_to_rub_the_same_to_less_than_a_per_cent(ur5: pid.Robot) -> None:
    shares = np.array([0.0003, -0.0002, 0.008, 0.0004, -0.0003, 0.0002])
    assert as_other_joints_show(compared(ur5, shares), usual(0.04)).joint == 0.01


def test_of_another_motion_the_other_joints_say_nothing(ur5: pid.Robot) -> None:
    shares = np.array([0.003, -0.002, 0.05, 0.004, -0.003, 0.002])
    assert as_other_joints_show(compared(ur5, shares, all_compared=False), usual(0.04)) == usual(0.04)


def test_few_healthy_arms_are_accused_on_the_joint_that_differs_most(ur5: pid.Robot) -> None:
    """All joints and all recordings differ alike, and the joint that differs most is accused: one arm of twenty exceeds either limit, as they
    are meant to, and few more exceed the one that is taken."""
    rng, day, accused, before = np.random.default_rng(1), 0.02, 0, 0
    quantile = 4.22
    for _ in range(400):
        spread = day * np.sqrt(rng.chisquare(SAMPLES) / SAMPLES)
        shares = day * rng.standard_normal(ur5.n)
        top = int(np.argmax(np.abs(shares)))
        shares[[top, ACCUSED - 1]] = shares[[ACCUSED - 1, top]]
        told = usual(spread, quantile * spread)
        accused += abs(shares[ACCUSED - 1]) > as_other_joints_show(compared(ur5, shares), told).joint
        before += abs(shares[ACCUSED - 1]) > told.joint
    assert before < 0.07 * 400
    assert accused < before + 0.04 * 400
