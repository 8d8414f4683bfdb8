"""A push is one only if it is harder than what the model errs by along healthy recordings looks like."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import physident as pid
from physident.diagnosis.grading.grades import AS_ELSEWHERE, AS_HEALTHY
from tests.serial_arms import ARMS, swung, urdf

pytestmark = pytest.mark.slow

BEFORE = 4  # healthy recordings
LASTS = 1.5  # s


def recorded(number: int, push: float, jolts: int = 0) -> pid.Recording:
    """Twenty seconds of two joints, by pinocchio; something pushes the tool along x with so many newtons for a while, and both joints
    are jolted some times, each by a torque of any sign and of a size that differs from jolt to jolt."""
    rng, time = np.random.default_rng(number), np.arange(0.0, 20.0, 0.005)
    q, v, tau = swung(rng, time)
    tau += np.array([1.8, 0.9]) * np.clip(v / 1e-4, -1, 1) + np.array([3.5, 1.6]) * v
    model = pin.buildModelFromXML(urdf(ARMS["two"]))
    data, tool = model.createData(), model.getFrameId("tool")
    start = rng.uniform(4.0, 14.0)
    for i in np.flatnonzero((time >= start) & (time < start + LASTS)):
        J = pin.computeFrameJacobian(model, data, q[i], tool, pin.LOCAL_WORLD_ALIGNED)
        tau[i] += J[0] * push
    for begin in rng.uniform(1.0, 18.0, jolts):
        lasting = (time >= begin) & (time < begin + rng.uniform(0.4, 1.0))
        tau[lasting] += rng.choice([-1, 1], 2) * 0.6 * np.exp(0.3 * rng.standard_normal(2))
    tau += 0.05 * rng.standard_normal(tau.shape)
    return pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=f"{number} {push}")


@pytest.mark.parametrize(("usual", "now", "is_cause"), [(2.0, 2.0, False), (2.0, 30.0, True), (0.0, 2.0, True)])
def test_a_push_is_a_cause_where_it_is_harder_than_healthy_recordings_seem_pushed(
    tmp_path: Path, usual: float, now: float, is_cause: bool
) -> None:
    """What pushes in every recording, at another time in each, is how this arm is: a cable that snags."""
    path = tmp_path / "planar.urdf"
    path.write_text(urdf(ARMS["two"]))
    rng = np.random.default_rng(0)
    healthy = [recorded(k, usual * rng.uniform(0.7, 1.3)) for k in range(BEFORE)]
    model = pid.identify(pid.load_robot(path), healthy)
    found = pid.diagnose_motion(model, [recorded(50, now), recorded(51, 0.0)])
    contacts = [one for one in found.findings if one.effect == "contact"]
    assert [one.grade == "cause" for one in contacts] == ([True] if is_cause else [False] * len(contacts))
    if not is_cause:
        assert contacts
        assert all(AS_HEALTHY in one.doubts for one in contacts)


@pytest.mark.parametrize(("push", "jolts"), [(2.0, 0), (30.0, 6), (0.0, 6)])
def test_what_happens_at_other_times_too_is_no_push(tmp_path: Path, push: float, jolts: int) -> None:
    """Without recordings of the healthy arm the other moments say how the model errs: several jolts are no push, one push is."""
    path = tmp_path / "planar.urdf"
    path.write_text(urdf(ARMS["two"]))
    doubts = []
    for trial in range(3):
        runs = [recorded(100 + 10 * trial, push, jolts), recorded(101 + 10 * trial, 0.0, jolts)]
        found = pid.diagnose_motion(pid.identify(pid.load_robot(path), runs), runs)
        contacts = [one for one in found.findings if one.effect == "contact"]
        assert push or all(one.grade != "cause" for one in contacts)
        doubts.append([AS_ELSEWHERE in one.doubts for one in contacts if (one.takes_percent or 0.0) > 50.0])
    assert all(doubts) if push else any(doubts)
    assert not push or not any(map(any, doubts))
