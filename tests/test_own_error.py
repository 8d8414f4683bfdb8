"""How much more a model errs on recordings that it was not fitted to is told by its own, left out one by one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physident as pid
from physident.diagnosis.grading.agreement import theta_without_each
from physident.diagnosis.remainder.own_error import OwnError
from physident.estimation.identify import prepare_all
from physident.validation.predictions import predict
from tests.serial_arms import ARMS, swung, urdf

pytestmark = pytest.mark.slow

OWN, NEW = 4, 2  # recordings


def recorded(seed: int, loose: float = 0.0) -> pid.Recording:
    """Twenty seconds of two joints by pinocchio, with friction that no model here has: it follows a root of the speed. The second joint's gear
    has play: a torque of its own while it turns back, as large as ``loose`` [N m]."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, 20.0, 0.005)
    q, v, tau = swung(rng, time)
    tau += np.array([1.2, 0.6]) * np.sign(v) * np.sqrt(np.abs(v)) + 0.05 * rng.standard_normal(tau.shape)
    tau[:, 1] += loose * np.sign(v[:, 1]) * (np.abs(v[:, 1]) < 0.05)
    return pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=f"{seed}")


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> pid.Robot:
    path = tmp_path_factory.mktemp("own") / "two.urdf"
    path.write_text(urdf(ARMS["two"]))
    return pid.load_robot(path)


def usual(robot: pid.Robot, group: int) -> tuple[pid.Estimate, OwnError]:
    """The model of four recordings, and what they say of two new ones."""
    own = [recorded(100 * group + k) for k in range(OWN)]
    estimate = pid.identify(robot, own)
    return estimate, OwnError.of(estimate, prepare_all(robot, own, estimate.filter), NEW)


def test_each_is_left_out_as_if_the_others_had_been_identified(robot: pid.Robot) -> None:
    own = [recorded(k) for k in range(OWN)]
    estimate = pid.identify(robot, own)
    each = theta_without_each(estimate, prepare_all(robot, own, estimate.filter))
    for k, theta in enumerate(each):
        others = pid.identify(robot, [one for i, one in enumerate(own) if i != k])
        without = replace(estimate, model=replace(estimate.model, theta=theta))
        left, expected = predict(without, [own[k]]).rms, predict(others, [own[k]]).rms
        np.testing.assert_allclose(
            left, expected, rtol=0.03
        )  # others' noise levels weigh the joints a little otherwise


def test_a_healthy_arm_errs_by_no_more_and_one_with_play_by_more(robot: pid.Robot) -> None:
    beyond, found, above = 0, 0, 0
    for group in range(1, 13):
        estimate, own = usual(robot, group)
        assert own.times is not None
        new = [[recorded(100 * group + 50 + k, loose) for k in range(NEW)] for loose in (0.0, 2.0)]
        healthy, loose = (predict(estimate, some).rms / own.rms for some in new)
        assert own.often is not None
        above += int(np.sum(healthy * own.rms > own.often))
        beyond += int((healthy > own.times).any())
        found += int(loose[1] > own.times[1])
    assert beyond <= 1  # of twelve, at a hundredth each
    assert 0 < above <= 6  # of 24 joints, a tenth each
    assert found == 12


def test_two_recordings_do_not_say_what_is_usual(robot: pid.Robot) -> None:
    own = [recorded(k) for k in range(2)]
    estimate = pid.identify(robot, own)
    assert OwnError.of(estimate, prepare_all(robot, own, estimate.filter), NEW).times is None
