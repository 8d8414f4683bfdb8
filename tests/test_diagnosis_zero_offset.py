"""A zero that is wrong by much is one fault: beyond its first order it is no load, no spring and no other link."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.effects.mounting import JointZeroOffset

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("offset", [0.05, -0.3, 0.5])
def test_a_large_offset_is_named_alone_with_its_size(
    offset: float, healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording], tmp_path: Path
) -> None:
    shift = offset * (np.arange(6) == 1)
    runs = [replace(run, q=run.q - shift) for run in healthy_runs[2:]]
    found = pid.diagnose_motion(healthy_estimate, runs)
    assert [(one.effect, one.joints) for one in found.causes] == [("joint_zero_offset", (2,))], repr(found)
    (value,) = found.causes[0].parameters
    assert value.value == pytest.approx(offset, abs=0.003)
    assert found.estimate is not None
    found.estimate.save(tmp_path / "extended.json")
    loaded = pid.load_estimate(tmp_path / "extended.json")
    before, after = (pid.validate(one, runs, include_fitted=True).rms for one in (found.estimate, loaded))
    assert after == pytest.approx(before, rel=1e-9)
    assert (after < 1.2 * pid.validate(healthy_estimate, healthy_runs[2:]).rms).all()


def test_about_an_offset_the_torque_is_that_of_the_shifted_arm(ur5: pid.Robot) -> None:
    """Against pinocchio, at the offset itself; a small one is nearly a line."""
    rng = np.random.default_rng(4)
    q, v, a = rng.uniform(-1, 1, (3, 50, 6))
    model = pid.Model.nominal(ur5)
    still = pid.Signals(np.arange(50) / 100, q, v, a, 0 * q, rate=100.0)
    signals = model.refer(still)
    data = ur5.pinocchio.createData()
    tau = np.array(
        [
            [pin.rnea(ur5.pinocchio, data, at + shift, *rest) for at, *rest in zip(q, v, a, strict=True)]
            for shift in (0, 0.4 * (np.arange(6) == 2))
        ]
    )
    about = JointZeroOffset((3,), about=(0.4,)).regressor(ur5, signals)[..., 0] * 0.4
    assert about == pytest.approx(tau[1] - tau[0], abs=1e-9)
    small, line = (JointZeroOffset((3,), about=D).regressor(ur5, signals) for D in ((1e-6,), None))
    assert small == pytest.approx(line, abs=1e-4)
    with pytest.raises(pid.InputError, match="about is"):
        JointZeroOffset((3,), about=(0.0,))


@pytest.mark.parametrize("angle", [0.02, 0.3])
def test_a_base_that_leans_far_makes_no_other_link(
    angle: float, healthy_estimate: pid.Estimate, healthy_runs: list[pid.Recording]
) -> None:
    """Vertical gravity becomes smaller, too: beside a part of 0.3 of it by a twentieth, which is the weight of no link. The torque is pinocchio's."""
    robot = healthy_estimate.model.robot.pinocchio
    size = float(np.linalg.norm(healthy_estimate.model.robot.gravity))
    leaning = pin.Model(robot)
    leaning.gravity.linear = size * np.array([np.sin(angle), 0.0, -np.cos(angle)])
    runs = []
    for run in healthy_runs[2:]:
        still = np.array(
            [
                pin.computeGeneralizedGravity(leaning, leaning.createData(), q)
                - pin.computeGeneralizedGravity(robot, robot.createData(), q)
                for q in run.q
            ]
        )
        runs.append(replace(run, effort=run.effort + still))
    found = pid.diagnose_motion(healthy_estimate, runs)
    assert [one.effect for one in found.causes] == ["gravity_tilt"], repr(found)
    x, y = (value.value for value in found.causes[0].parameters)
    assert x == pytest.approx(size * np.sin(angle), abs=0.05)
    assert y == pytest.approx(0.0, abs=0.05)
