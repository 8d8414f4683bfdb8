"""A residual that remembers no longer than noise is noise only where the torque signal itself has so much."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import physident as pid
from tests.serial_arms import ARMS, swung, urdf

RATE, NOISE = 250.0, 0.05  # Hz, N m


def knocked(number: int, knock: float) -> pid.Recording:
    """Twenty seconds of two joints, by pinocchio; at random times something knocks the second for 30 ms, either way, by ``knock`` [N m]."""
    rng, time = np.random.default_rng(number), np.arange(0.0, 20.0, 1 / RATE)
    q, v, tau = swung(rng, time)
    tau += np.array([2.0, 1.0]) * v + NOISE * rng.standard_normal(tau.shape)
    for start in rng.uniform(1, 18, 40):
        tau[(time > start) & (time < start + 0.03), 1] += knock * rng.choice((-1, 1))
    return pid.Recording.from_arrays(time, q, dq=v, effort=tau, source=str(number))


@pytest.mark.parametrize(("knock", "joints"), [(0.0, []), (6.0, [2])])
def test_what_is_much_louder_than_the_sensor_is_no_noise(knock: float, joints: list[int], tmp_path: Path) -> None:
    (tmp_path / "two.urdf").write_text(urdf(ARMS["two"]))
    runs = [knocked(number, knock) for number in (1, 2)]
    found = pid.diagnose_motion(pid.identify(pid.load_robot(tmp_path / "two.urdf"), runs), runs)
    assert [one.joint for one in found.structured] == joints
    told = " ".join(repr(found).split())
    assert found.causes == ()
    if not knock:
        assert found.verdict == "nothing_missing"
        return
    (left,) = found.structured
    assert not left.remembers
    assert left.times_noise == pytest.approx(left.rms / (NOISE * np.sqrt(2 * 5.0 / RATE)), rel=0.2)
    assert found.verdict == "unexplained"
    assert f"it remembers no longer than noise, but is {left.times_noise:.1f} times that of the torque signal" in told
    assert "residual is noise" not in told
