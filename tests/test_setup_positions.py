"""Positions that count the other way, and encoders that are frozen, are named with their joint; a held joint is left alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physident as pid
from tests.test_setup_checks import ALL, Runs, each, kinds, rigid


@pytest.fixture(scope="module")
def runs(healthy_runs: Runs) -> Runs:
    return healthy_runs[:2]


@pytest.mark.parametrize("joint", ALL)
def test_the_direction_that_one_position_counts_in(ur5: pid.Robot, runs: Runs, joint: int) -> None:
    """Joints whose weight shows it; elsewhere the effort's sign, with the position's as its rival or the reverse."""
    sign = np.where(np.arange(6) == joint - 1, -1.0, 1.0)

    def change(r: pid.Recording) -> pid.Recording:
        return replace(r, q=sign * r.q, dq=None if r.dq is None else sign * r.dq)

    (found,) = pid.check_setup(ur5, each(runs, change))
    assert (found.joints, found.void) == ((joint,), True)
    counts = f"the position of joint {joint} counts the other way"
    assert found.kind == "position_sign" if joint in (2, 3) else counts in str(found)


def test_an_encoder_that_is_frozen_and_a_joint_that_is_held(ur5: pid.Robot, runs: Runs) -> None:
    """A held joint's torque is pinocchio's; here it also creaks within its stiction, as noise that the filter lets through."""
    stands = np.arange(6) == 2

    def freeze(r: pid.Recording) -> pid.Recording:
        return replace(r, q=np.where(stands, 0.3, r.q), dq=None)

    assert kinds(ur5, each(runs, freeze)) == [("position_frozen", (3,))]
    rng = np.random.default_rng(4)

    def hold(r: pid.Recording) -> pid.Recording:
        held = replace(r, q=np.where(stands, 0.3, r.q), dq=None)
        torque = rigid(ur5, held)
        slow = np.repeat(rng.standard_normal(len(torque) // 20 + 1), 20)[: len(torque)]
        rest = (r.effort - rigid(ur5, r)) * ~stands + stands * 0.2 * torque.std(axis=0) * slow[:, None]
        return replace(
            held, effort=torque + rest + 0.3 * stands * torque.std(axis=0) * rng.standard_normal(torque.shape)
        )

    assert "position_frozen" not in [kind for kind, _ in kinds(ur5, each(runs, hold))]


def test_a_velocity_that_goes_on_beside_a_frozen_position(ur5: pid.Robot, runs: Runs) -> None:
    """Without a description, too; the noise of a joint that is held goes nowhere."""
    stands, rng = np.arange(6) == 2, np.random.default_rng(6)
    frozen = each(runs, lambda r: replace(r, q=np.where(stands, 0.3, r.q)))
    held = each(
        runs,
        lambda r: replace(
            r,
            q=np.where(stands, 0.3, r.q),
            dq=np.where(stands, 0.02 * rng.standard_normal(r.q.shape) + 0.01, np.asarray(r.dq)),
        ),
    )
    for robot in (ur5, None):
        (found,) = pid.check_setup(robot, frozen)
        assert (found.kind, found.joints, found.void) == ("position_frozen", (3,), True)
    assert pid.check_setup(None, held) == ()
